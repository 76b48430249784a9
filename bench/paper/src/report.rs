//! The page: all experiments in order, their figures, and every parameter.

mod page;

use lariat_plot::words::{count, list, time};

use crate::at_rest::AtRest;
use crate::clusterings::Clusterings;
use crate::conditioning::Conditioning;
use crate::cost::Cost;
use crate::figure::{Figure, Section};
use crate::fits;
use crate::ordering::Ordering;
use crate::orders::Orders;
use crate::rivals::Rivals;
use crate::robustness::{Lights, Missing, Noise, Outliers};
use crate::shapes::{self, POINTS, Shapes};
use crate::{Csv, Options, PaperError, Ropes};

/// The result of a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Report {
    /// The page, a single self-contained HTML file.
    pub html: String,
    /// The numbers behind each figure.
    pub csvs: Vec<Csv>,
    /// The findings, figure by figure: the first sentence of each caption.
    pub findings: Vec<String>,
}

/// Repeats the paper's experiments. `progress` receives a description of each step.
///
/// # Errors
/// Returns [`PaperError::NoRope`] if no rope is found in any picture. Other errors come from the
/// libraries. No seed and no predefined effort of this crate causes them.
pub fn repeat(
    options: &Options,
    ropes: Ropes<'_>,
    progress: &mut dyn FnMut(&str),
) -> Result<Report, PaperError> {
    let (seed, effort) = (options.seed, &options.effort);
    let shapes = match ropes {
        Ropes::Drawn => {
            progress("drawing ropes and looking at them");
            shapes::drawn(seed, effort)?
        }
        Ropes::Pictured(pictures) => {
            progress("looking at the pictures");
            shapes::pictured(pictures, effort)?
        }
    };
    let clusterings = Clusterings::run(&shapes, progress)?;
    let centerlines: Vec<Figure> = clusterings.figure(&shapes)?.into_iter().collect();
    progress("fits of rising order");
    let orders = Orders::run(&shapes)?;
    let mut features: Vec<Figure> = fits::figure(&shapes, &orders)?.into_iter().collect();
    features.push(orders.figure_3()?);

    progress("robustness");
    let mut robustness = vec![
        Noise::run(&shapes, seed)?.figure()?,
        Missing::run(&shapes, seed)?.figure()?,
        Outliers::run(&shapes, seed)?.figure()?,
    ];
    if shapes.has_truth {
        progress("light");
        robustness.push(Lights::run(seed, effort)?.figure()?);
    }
    progress("time of a fit");
    let cost = vec![Cost::run(&shapes, effort)?.figure()?];
    progress("rivals");
    let rivals = vec![Rivals::run(&shapes, seed, effort)?.figure()?];
    progress("conditioning and ordering");
    let mut beyond = Conditioning::run(&shapes, seed)?.figures()?.to_vec();
    beyond.extend(Ordering::run(&shapes, seed)?.figures()?);
    if shapes.has_truth {
        progress("ropes at rest");
        beyond.push(AtRest::run(seed, effort)?.figure()?);
    }
    let sections = sections(centerlines, features, robustness, cost, rivals, beyond);
    let figures = || sections.iter().flat_map(|section| &section.figures);
    Ok(Report {
        html: page::write(
            &sections,
            &introduction(&shapes),
            &parameters(options, &shapes),
        ),
        csvs: figures().map(|figure| figure.csv.clone()).collect(),
        findings: figures().map(finding).collect(),
    })
}

fn sections(
    centerlines: Vec<Figure>,
    features: Vec<Figure>,
    robustness: Vec<Figure>,
    cost: Vec<Figure>,
    rivals: Vec<Figure>,
    beyond: Vec<Figure>,
) -> Vec<Section> {
    let section = |heading, text: &str, figures| Section {
        heading,
        text: text.to_owned(),
        figures,
    };
    vec![
        section(
            "Centerline detection",
            "The paper takes four clusterings of the rope's pixels from elsewhere, shows what they make of one picture, and \
             finds that k-means has the best ability to extract the centerline. How their centers become a line it does not \
             say. Here each gets the same mask, and its centers are put in order by which of their cells touch within it.",
            centerlines,
        ),
        section(
            "Feature extraction",
            "The paper fits Bezier curves of order n = 2, 4, 6 and 8 to N = 120 points, and finds that the error falls with \
             the order, that 8 is the best and 2 the worst. It shows pictures.",
            features,
        ),
        section(
            "Robustness",
            "The abstract claims robustness, the conclusion that the method does better than existing ones; there is no \
             experiment. Here are noise on the points, missing points, outliers, and light.",
            robustness,
        ),
        section(
            "Computational efficiency",
            "The abstract claims it; the text fears a “computational burden as the fitting order increases”. No time is given.",
            cost,
        ),
        section(
            "Against its rivals",
            "The paper names feature points, the center of mass and Fourier series as what it improves on, and allows \
             B-splines and rational curves in its place (remark 1). It compares none.",
            rivals,
        ),
        section(
            "Beyond the paper",
            "What a control law has to know besides: how far noise moves the descriptor, what it takes of the points' order \
             and spacing, and how still it lies when the rope does.",
            beyond,
        ),
    ]
}

/// Returns the figure's number and the first sentence of its finding.
fn finding(figure: &Figure) -> String {
    let found = &figure.found;
    // A period and a space end a sentence. A decimal point does not.
    let end = found
        .match_indices(". ")
        .map(|(at, _)| at + 1)
        .next()
        .unwrap_or(found.len());
    format!("Figure {}. {}", figure.number, &found[..end])
}

fn introduction(shapes: &Shapes) -> String {
    let source = if shapes.has_truth {
        format!(
            "on {} that lariat draws itself, so that their true centerlines are known",
            count(shapes.all.len(), "rope", "ropes")
        )
    } else {
        format!(
            "on {} seen in real pictures. These come without a truth: errors are against the centerline that lariat's \
             skeleton gives, and what needs a truth or a rope at rest is left out",
            count(shapes.all.len(), "rope", "ropes")
        )
    };
    format!(
        "The experiments of F. Chen, Bezier-based Regression Feature Descriptor for Deformable Linear Objects (arXiv \
         2312.16502), again and with numbers, {source}. Every sentence below that states a finding was made from the numbers \
         of this run."
    )
}

/// Returns every parameter that the numbers depend on.
fn parameters(options: &Options, shapes: &Shapes) -> Vec<(&'static str, String)> {
    let effort = &options.effort;
    let mut rows = vec![
        ("version", format!("lariat {}", env!("CARGO_PKG_VERSION"))),
        (
            "machine",
            options.machine.clone().unwrap_or_else(|| "not known".to_owned()),
        ),
        ("seed", options.seed.to_string()),
        ("points of a centerline, N", POINTS.to_string()),
        ("measured against", shapes.measure().to_owned()),
        (
            "curves",
            "Bezier of order 8 unless noted otherwise; least squares by pinv; ρ even; no ridge, no pinned ends".to_owned(),
        ),
    ];
    if shapes.has_truth {
        rows.extend([
            ("pictures", format!("{} × {} px", effort.size_px[0], effort.size_px[1])),
            (
                "ropes",
                format!(
                    "{}: {} in turn; seeds {} on; not seen as they lie: {}",
                    shapes.all.len(),
                    list(&shapes.kinds().iter().map(|kind| (*kind).to_owned()).collect::<Vec<_>>()),
                    options.seed.wrapping_mul(100_000),
                    shapes.unseen
                ),
            ),
            ("pictures of each kind of light", effort.lights.to_string()),
            (
                "at rest",
                format!(
                    "{} ropes, {} frames each; filters at their defaults, except for the acceleration where noted",
                    effort.ropes_at_rest, effort.frames_at_rest
                ),
            ),
        ]);
    } else {
        rows.push((
            "ropes",
            format!(
                "{} open ones, wholly seen; pictures without any: {}",
                shapes.all.len(),
                shapes.unseen
            ),
        ));
    }
    rows.extend([
        (
            "an extraction without knowledge from before",
            format!("{} (median)", time(shapes.extraction_us)),
        ),
        (
            "pictures for the clusterings",
            shapes.pictures.len().to_string(),
        ),
        ("rounds of each time", effort.rounds.to_string()),
    ]);
    rows
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Effort, Picture};

    fn least(seed: u64) -> Options {
        Options {
            seed,
            effort: Effort::least(),
            machine: None,
        }
    }

    #[test]
    fn the_page_is_whole_and_stands_alone() {
        let report = repeat(&least(2), Ropes::Drawn, &mut |_| {}).unwrap();
        lariat_plot::check_tags(&report.html).unwrap();
        for number in 1..=14 {
            assert!(
                report.html.contains(&format!("Figure {number}.")),
                "{number}"
            );
        }
        for csv in &report.csvs {
            assert!(report.html.contains(csv.name), "{}", csv.name);
            let mut lines = csv.text.lines();
            let columns = lines.next().unwrap().split(',').count();
            assert!(lines.clone().count() > 0, "{}", csv.name);
            // No name in these files contains a comma.
            assert!(lines.all(|line| line.split(',').count() == columns || line.contains('"')));
        }
        // Nothing is fetched: every address on the page is a namespace.
        let addresses = report.html.matches("http").count();
        assert_eq!(
            addresses,
            report.html.matches("http://www.w3.org/2000/svg").count()
        );
        assert!(!report.html.contains("<script") && !report.html.contains("NaN"));
    }

    #[test]
    fn the_same_seed_gives_the_same_numbers_but_for_times() {
        let [a, b, other] =
            [3, 3, 4].map(|seed| repeat(&least(seed), Ropes::Drawn, &mut |_| {}).unwrap());
        for ((a, b), other) in a.csvs.iter().zip(&b.csvs).zip(&other.csvs) {
            if a.name.contains("cost") || a.name.contains("clusterings") {
                continue;
            }
            assert_eq!(a, b);
            // Condition numbers depend on the order alone.
            if a.name != "figure-10-conditioning.csv" {
                assert_ne!(a.text, other.text, "{}", a.name);
            }
        }
    }

    #[test]
    fn pictures_without_a_rope_are_refused_with_a_sentence() {
        let empty = Picture {
            name: "empty".to_owned(),
            width: 200,
            height: 160,
            rgb: vec![200; 3 * 200 * 160],
        };
        let error = repeat(
            &least(1),
            Ropes::Pictured(&mut std::iter::once(Ok(empty))),
            &mut |_| {},
        )
        .unwrap_err();
        assert!(error.to_string().starts_with("no open rope"), "{error}");
    }
}
