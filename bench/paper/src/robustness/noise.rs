//! Noise on the points, for families of equal size.

use lariat_plot::Spread;
use lariat_plot::words::px;
use lariat_plot::{Axis, Chart, LineStyle};

use crate::PaperError;
use crate::csv::Csv;
use crate::family::{Family, Fitting, PAPERS_NUMBERS};
use crate::figure::Figure;
use crate::polyline::rms_apart_px;
use crate::random::of_stream;
use crate::shapes::Shapes;

use super::medians;

/// Standard deviation of each coordinate of each point, px.
const SIGMAS_PX: [f64; 8] = [0.0, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0];
const FAMILIES: [Family; 5] = [
    Family::Bezier,
    Family::BSpline,
    Family::Rational,
    Family::Cosines,
    Family::FeaturePoints,
];

/// Results of one family: spreads over the shapes, by noise level.
#[derive(Debug, Clone, PartialEq)]
struct Row {
    family: Family,
    /// Distance between the rope and the curve.
    off_px: Vec<Spread>,
    /// Distance at the same ρ between the curves with and without noise.
    moved_px: Vec<Spread>,
}

/// Selects one of a row's two lists.
type SpreadsOf = fn(&Row) -> &[Spread];

/// Errors of each family at each noise level.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Noise {
    rows: Vec<Row>,
    shapes: usize,
}

impl Noise {
    pub(crate) fn run(shapes: &Shapes, seed: u64) -> Result<Self, PaperError> {
        let mut rows = Vec::new();
        for family in FAMILIES {
            let Some(mut fitting) = Fitting::of(family, PAPERS_NUMBERS)? else {
                continue;
            };
            let mut clean = Vec::new();
            for shape in &shapes.all {
                fitting.fit(&shape.reference)?;
                clean.push(fitting.sampled()?);
            }
            let (mut off_px, mut moved_px) = (Vec::new(), Vec::new());
            for (k, sigma_px) in SIGMAS_PX.into_iter().enumerate() {
                let (mut off, mut moved) = (Vec::new(), Vec::new());
                for (i, shape) in shapes.all.iter().enumerate() {
                    // The noise is the same for every family.
                    let mut random = of_stream(seed, (1000 * k + i) as u64);
                    let noisy: Vec<[f64; 2]> = (shape.reference.iter())
                        .map(|p| p.map(|c| c + sigma_px * random.normal()))
                        .collect();
                    fitting.fit(&noisy)?;
                    off.push(fitting.off_px(&shape.reference)?);
                    moved.push(rms_apart_px(&fitting.sampled()?, &clean[i]));
                }
                off_px.push(Spread::of(off));
                moved_px.push(Spread::of(moved));
            }
            rows.push(Row {
                family,
                off_px,
                moved_px,
            });
        }
        Ok(Self {
            rows,
            shapes: shapes.all.len(),
        })
    }

    fn of(&self, family: Family) -> Option<&Row> {
        self.rows.iter().find(|row| row.family == family)
    }

    fn finding(&self) -> String {
        let (Some(bezier), Some(points)) =
            (self.of(Family::Bezier), self.of(Family::FeaturePoints))
        else {
            return String::new();
        };
        let one = SIGMAS_PX.iter().position(|&s| s == 1.0).unwrap_or(0);
        let last = SIGMAS_PX.len() - 1;
        let [ours, theirs] = [bezier, points].map(|row| row.moved_px[one].median);
        let verdict = if ours < 0.9 * theirs {
            "A regression averages noise, and feature points do not"
        } else {
            "The regression lets no less noise through than feature points"
        };
        let mut by_noise: Vec<&Row> = self.rows.iter().collect();
        by_noise.sort_by(|a, b| a.off_px[last].median.total_cmp(&b.off_px[last].median));
        let closest = by_noise.first().map_or("none", |row| row.family.name());
        format!(
            "{verdict}: noise of 1 px moves the Bezier curve by {}, the polyline of nine feature points by {}. Without \
             noise they are {} and {} off the rope; with {} of it the closest of all is the {closest}, with {}.",
            px(ours),
            px(theirs),
            px(bezier.off_px[0].median),
            px(points.off_px[0].median),
            format_args!("{} px", SIGMAS_PX[last]),
            px(by_noise
                .first()
                .map_or(f64::NAN, |row| row.off_px[last].median)),
        )
    }

    pub(crate) fn figure(&self) -> Result<Figure, PaperError> {
        let panels: [(&str, SpreadsOf); 2] = [
            ("from the rope", |row| &row.off_px),
            ("from the curve without noise", |row| &row.moved_px),
        ];
        let mut charts = Vec::new();
        for (title, of) in panels {
            let all = self.rows.iter().flat_map(|row| medians(of(row)));
            let mut chart = Chart::new(
                Axis::log("noise of each coordinate, px", [0.085, 11.5]),
                Axis::log_around("distance, px", all),
            )
            .titled(title);
            for (i, row) in self.rows.iter().enumerate() {
                let line = SIGMAS_PX.iter().zip(of(row));
                let line = line.filter(|(sigma, _)| **sigma > 0.0);
                let line = line.map(|(sigma, s)| [*sigma, s.median]).collect();
                chart.line(row.family.name(), LineStyle::nth(i), line);
            }
            charts.push(chart);
        }
        Ok(Figure {
            number: 4,
            title: "Noise on the points".to_owned(),
            svg: lariat_plot::draw("figure 4", &charts, 2)?,
            shows: format!(
                "Normal noise is added to each point of {} ropes, and curves are fitted that take {PAPERS_NUMBERS} numbers \
                 (the rational one 17). Median distance of the rope from the curve (left), and of the curve from the one \
                 fitted without noise, at the same ρ (right).",
                self.shapes
            ),
            found: self.finding(),
            parameters: format!("{PAPERS_NUMBERS} numbers; standard deviations {SIGMAS_PX:?} px"),
            table: None,
            csv: self.csv(),
        })
    }

    fn csv(&self) -> Csv {
        let header = [
            "family",
            "sigma_px",
            "off_p25_px",
            "off_median_px",
            "off_p75_px",
            "moved_p25_px",
            "moved_median_px",
            "moved_p75_px",
        ];
        let mut csv = Csv::new("figure-4-noise.csv", &header);
        for row in &self.rows {
            for (k, sigma_px) in SIGMAS_PX.into_iter().enumerate() {
                let (off, moved) = (row.off_px[k], row.moved_px[k]);
                csv.row(&[
                    row.family.name().into(),
                    sigma_px.into(),
                    off.p25.into(),
                    off.median.into(),
                    off.p75.into(),
                    moved.p25.into(),
                    moved.median.into(),
                    moved.p75.into(),
                ]);
            }
        }
        csv
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(bezier: f64, points: f64) -> Noise {
        let row = |family, at: f64| {
            let spreads = SIGMAS_PX
                .map(|sigma| Spread::of([at * sigma + 0.1]))
                .to_vec();
            Row {
                family,
                off_px: spreads.clone(),
                moved_px: spreads,
            }
        };
        Noise {
            rows: vec![
                row(Family::Bezier, bezier),
                row(Family::FeaturePoints, points),
            ],
            shapes: 1,
        }
    }

    #[test]
    fn the_sentence_follows_the_numbers() {
        let better = noise(0.4, 1.0).finding();
        assert!(
            better.starts_with("A regression averages noise"),
            "{better}"
        );
        assert!(better.ends_with("is the Bezier, with 4.10 px."), "{better}");
        let worse = noise(1.0, 0.5).finding();
        assert!(worse.starts_with("The regression lets no less"), "{worse}");
        assert!(
            worse.ends_with("is the feature points, with 5.10 px."),
            "{worse}"
        );
    }
}
