//! Missing points, in one gap or scattered, and three ways to fit the rest.

use lariat_fit::{Basis, Fitter, Options, Rho, Weights};
use lariat_plot::Spread;
use lariat_plot::words::px;
use lariat_plot::{Axis, Chart, LineStyle};

use crate::PaperError;
use crate::csv::Csv;
use crate::curves::{fitter, sampled};
use crate::figure::Figure;
use crate::polyline::rms_from_line_px;
use crate::random::{below, of_stream, shuffle};
use crate::shapes::{POINTS, Shapes};
use lariat_portable::SplitMix64;

use super::medians;

const SHARES: [f64; 7] = [0.0, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5];
/// Index of the share that the findings are about: a fifth is missing.
const A_FIFTH: usize = 3;
const BASIS: Basis = Basis::Bezier { order: 8 };

/// Ways to fit the remaining points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Way {
    /// The remaining points are treated as a whole centerline at even steps: the paper's words,
    /// taken literally.
    EvenRho,
    /// Each point's ρ is measured along the remaining points.
    MeasuredRho,
    /// The gaps are known, and missing points get a weight of 0.
    NoWeight,
}

impl Way {
    const ALL: [Self; 3] = [Self::EvenRho, Self::MeasuredRho, Self::NoWeight];

    fn name(self) -> &'static str {
        match self {
            Self::EvenRho => "even ρ over the rest",
            Self::MeasuredRho => "measured ρ",
            Self::NoWeight => "no weight where missing",
        }
    }

    fn fitter(self, left: usize) -> Result<Fitter, PaperError> {
        let options = Options::default().basis(BASIS);
        Ok(Fitter::new(match self {
            Self::EvenRho => options.points(left),
            Self::MeasuredRho => options.points(left).rho(Rho::Measured),
            Self::NoWeight => options.points(POINTS).weights(Weights::Given),
        })?)
    }
}

/// Ways to lose points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Loss {
    Gap,
    Scattered,
}

impl Loss {
    const ALL: [Self; 2] = [Self::Gap, Self::Scattered];

    fn name(self) -> &'static str {
        match self {
            Self::Gap => "one gap",
            Self::Scattered => "here and there",
        }
    }

    /// Returns which points remain.
    fn left(self, missing: usize, random: &mut SplitMix64) -> Vec<bool> {
        let mut left = vec![true; POINTS];
        match self {
            Self::Gap => {
                // The gap is never at an end, because points missing there cannot be noticed.
                let from = 1 + below(random, POINTS - missing - 1);
                left[from..from + missing].fill(false);
            }
            Self::Scattered => {
                let mut inner: Vec<usize> = (1..POINTS - 1).collect();
                shuffle(&mut inner, random);
                inner.iter().take(missing).for_each(|&i| left[i] = false);
            }
        }
        left
    }
}

/// Errors by the kind of loss and the way to fit.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Missing {
    rows: Vec<(Loss, Way, Vec<Spread>)>,
    shapes: usize,
}

impl Missing {
    pub(crate) fn run(shapes: &Shapes, seed: u64) -> Result<Self, PaperError> {
        let mut whole = fitter(BASIS)?;
        let mut wholes = Vec::new();
        for shape in &shapes.all {
            wholes.push(sampled(whole.fit(&shape.reference)?, POINTS)?);
        }
        let mut rows = Vec::new();
        for loss in Loss::ALL {
            for way in Way::ALL {
                let mut spreads = Vec::new();
                for (k, share) in SHARES.into_iter().enumerate() {
                    let missing = (share * POINTS as f64).round() as usize;
                    let mut fitter = way.fitter(POINTS - missing)?;
                    let mut off = Vec::new();
                    for (i, shape) in shapes.all.iter().enumerate() {
                        // The same points are missing for each way.
                        let mut random = of_stream(seed, (20_000 + 1000 * k + i) as u64);
                        let left = loss.left(missing, &mut random);
                        off.push(moved_px(
                            &mut fitter,
                            way,
                            &shape.reference,
                            &left,
                            &wholes[i],
                        )?);
                    }
                    spreads.push(Spread::of(off));
                }
                rows.push((loss, way, spreads));
            }
        }
        Ok(Self {
            rows,
            shapes: shapes.all.len(),
        })
    }

    fn at_a_fifth(&self, loss: Loss, way: Way) -> f64 {
        let row = self.rows.iter().find(|row| (row.0, row.1) == (loss, way));
        row.map_or(f64::NAN, |row| row.2[A_FIFTH].median)
    }

    fn finding(&self) -> String {
        let gap = Way::ALL.map(|way| self.at_a_fifth(Loss::Gap, way));
        let verdict = if gap[0] > 1.1 * gap[1] {
            "Arc length has to be measured once a part of the rope is not seen"
        } else {
            "Measuring the arc length makes no difference here"
        };
        format!(
            "{verdict}: a gap of a fifth moves the curve by {} when what is left is taken for the whole rope, {} with \
             measured ρ, and {} when the hidden points are known and weigh nothing. A fifth missing here and there costs \
             {}, {} and {}.",
            px(gap[0]),
            px(gap[1]),
            px(gap[2]),
            px(self.at_a_fifth(Loss::Scattered, Way::EvenRho)),
            px(self.at_a_fifth(Loss::Scattered, Way::MeasuredRho)),
            px(self.at_a_fifth(Loss::Scattered, Way::NoWeight)),
        )
    }

    pub(crate) fn figure(&self) -> Result<Figure, PaperError> {
        let all = || self.rows.iter().flat_map(|row| medians(&row.2[1..]));
        let mut charts = Vec::new();
        let mut csv = Csv::new(
            "figure-5-missing.csv",
            &[
                "missing",
                "way",
                "share",
                "p25_px",
                "median_px",
                "p75_px",
                "p95_px",
            ],
        );
        for loss in Loss::ALL {
            let mut chart = Chart::new(
                Axis::linear("missing, %", [-2.0, 52.0], 10.0),
                Axis::log_around("distance, px", all()),
            )
            .titled(loss.name());
            let rows = self.rows.iter().filter(|row| row.0 == loss);
            for (i, (_, way, spreads)) in rows.enumerate() {
                let line = SHARES
                    .iter()
                    .zip(spreads)
                    .filter(|(share, _)| **share > 0.0);
                let line = line.map(|(share, s)| [100.0 * share, s.median]);
                chart.line(way.name(), LineStyle::nth(i), line.collect());
                for (share, s) in SHARES.iter().zip(spreads) {
                    csv.row(&[
                        loss.name().into(),
                        way.name().into(),
                        (*share).into(),
                        s.p25.into(),
                        s.median.into(),
                        s.p75.into(),
                        s.p95.into(),
                    ]);
                }
            }
            charts.push(chart);
        }
        Ok(Figure {
            number: 5,
            title: "Missing points".to_owned(),
            svg: lariat_plot::draw("figure 5", &charts, 2)?,
            shows: format!(
                "Median distance, over {} ropes, between the Bezier curve of order 8 that was fitted to all {POINTS} points \
                 of a rope and the one fitted to what is left of them; the points are exact.",
                self.shapes
            ),
            found: self.finding(),
            parameters: format!("n = 8; shares {SHARES:?}; never an end"),
            table: None,
            csv,
        })
    }
}

/// Returns the distance between the curve through the remaining points and `whole`, the curve
/// through all points.
fn moved_px(
    fitter: &mut Fitter,
    way: Way,
    reference: &[[f64; 2]],
    left: &[bool],
    whole: &[[f64; 2]],
) -> Result<f64, PaperError> {
    let fit = if way == Way::NoWeight {
        let weights: Vec<f64> = left.iter().map(|&is| f64::from(u8::from(is))).collect();
        fitter.fit_weighted(reference, &weights)
    } else {
        let kept = reference.iter().zip(left).filter(|(_, is)| **is);
        let kept: Vec<[f64; 2]> = kept.map(|(p, _)| *p).collect();
        fitter.fit(&kept)
    };
    match fit {
        Ok(fit) => Ok(rms_from_line_px(whole, &sampled(fit, 2 * POINTS)?)),
        // A gap can leave too few points to determine the curve. Such a case is skipped.
        Err(_) => Ok(f64::NAN),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn missing(even: f64, measured: f64) -> Missing {
        let rows = Loss::ALL.into_iter().flat_map(|loss| {
            Way::ALL.map(|way| {
                let off = match way {
                    Way::EvenRho => even,
                    Way::MeasuredRho => measured,
                    Way::NoWeight => 1.0,
                };
                (loss, way, vec![Spread::of([off]); SHARES.len()])
            })
        });
        Missing {
            rows: rows.collect(),
            shapes: 1,
        }
    }

    #[test]
    fn the_sentence_follows_the_numbers() {
        let found = missing(9.0, 2.0).finding();
        assert!(
            found.starts_with("Arc length has to be measured"),
            "{found}"
        );
        assert!(found.contains("by 9.00 px") && found.contains("2.00 px with measured"));
        let found = missing(2.0, 2.0).finding();
        assert!(found.contains("makes no difference"), "{found}");
    }

    #[test]
    fn as_many_points_go_missing_as_are_asked_for_and_never_an_end() {
        let mut random = of_stream(1, 1);
        for loss in Loss::ALL {
            for missing in [0, 1, 60] {
                let left = loss.left(missing, &mut random);
                assert_eq!(left.iter().filter(|is| !**is).count(), missing);
                assert!(left[0] && left[POINTS - 1]);
            }
        }
    }
}
