//! Outliers, with and without Huber weights.

use lariat_fit::{Basis, Fitter, Options, Weights};
use lariat_plot::Spread;
use lariat_plot::words::px;
use lariat_plot::{Axis, Chart, LineStyle};

use crate::PaperError;
use crate::csv::Csv;
use crate::curves::{bspline, sampled};
use crate::figure::Figure;
use crate::polyline::{apart_px, rms_apart_px};
use crate::random::{of_stream, shuffle};
use crate::shapes::{POINTS, Shapes};
use lariat_portable::SplitMix64;

use super::medians;

const SHARES: [f64; 8] = [0.0, 0.01, 0.02, 0.05, 0.1, 0.15, 0.2, 0.3];
/// Index of the share that the findings are about: a tenth are outliers.
const A_TENTH: usize = 4;
/// Distance range of outliers, as shares of the rope's length.
const FAR: [f64; 2] = [0.02, 0.06];
/// Standard deviation of the noise of all points, px.
const SIGMA_PX: f64 = 0.3;

/// Ways to fit: true for a B-spline, true for Huber weights, and a name.
const WAYS: [(bool, bool, &str); 4] = [
    (false, false, "Bezier, least squares"),
    (false, true, "Bezier, Huber"),
    (true, false, "B-spline, least squares"),
    (true, true, "B-spline, Huber"),
];

/// Errors by share of outliers.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Outliers {
    /// Spreads in the order of `WAYS`.
    rows: Vec<Vec<Spread>>,
    shapes: usize,
}

impl Outliers {
    pub(crate) fn run(shapes: &Shapes, seed: u64) -> Result<Self, PaperError> {
        let mut rows = Vec::new();
        for (is_bspline, is_robust, _) in WAYS {
            let mut fitter = Fitter::new(
                Options::default()
                    .basis(if is_bspline {
                        bspline(9)
                    } else {
                        Basis::Bezier { order: 8 }
                    })
                    .weights(if is_robust {
                        Weights::Robust
                    } else {
                        Weights::Even
                    }),
            )?;
            let mut clean = Vec::new();
            for shape in &shapes.all {
                clean.push(sampled(fitter.fit(&shape.reference)?, POINTS)?);
            }
            let mut spreads = Vec::new();
            for (k, share) in SHARES.into_iter().enumerate() {
                let mut off = Vec::new();
                for (i, shape) in shapes.all.iter().enumerate() {
                    let mut random = of_stream(seed, (40_000 + 1000 * k + i) as u64);
                    let points = spoiled(&shape.reference, share, &mut random);
                    let curve = sampled(fitter.fit(&points)?, POINTS)?;
                    off.push(rms_apart_px(&curve, &clean[i]));
                }
                spreads.push(Spread::of(off));
            }
            rows.push(spreads);
        }
        Ok(Self {
            rows,
            shapes: shapes.all.len(),
        })
    }

    fn finding(&self) -> String {
        let [plain, robust] = [0, 1].map(|way| self.rows[way][A_TENTH].median);
        let [clean_plain, clean_robust] = [0, 1].map(|way| self.rows[way][0].median);
        let verdict = if robust < 0.3 * plain {
            "Least squares, the paper's method, is not robust against outliers; Huber's weights make it so"
        } else if robust < 0.9 * plain {
            "Least squares, the paper's method, is not robust against outliers; Huber's weights help, but where the curve \
             does not fit the rope its own error hides them"
        } else {
            "Huber's weights change little here"
        };
        format!(
            "{verdict}: a tenth of the points far off moves the curve of order 8 by {} with least squares and by {} with \
             Huber's weights; without any the noise alone moves it by {} and {}.",
            px(plain),
            px(robust),
            px(clean_plain),
            px(clean_robust),
        )
    }

    pub(crate) fn figure(&self) -> Result<Figure, PaperError> {
        let all = self.rows.iter().flat_map(|spreads| medians(spreads));
        let mut chart = Chart::new(
            Axis::linear("outliers, %", [-1.0, 31.0], 5.0),
            Axis::log_around("distance, px", all),
        );
        let mut csv = Csv::new(
            "figure-6-outliers.csv",
            &["way", "share", "p25_px", "median_px", "p75_px", "p95_px"],
        );
        for (i, ((_, _, name), spreads)) in WAYS.iter().zip(&self.rows).enumerate() {
            let line = SHARES.iter().zip(spreads);
            let line = line.map(|(share, s)| [100.0 * share, s.median]);
            chart.line(name, LineStyle::nth(i), line.collect());
            for (share, s) in SHARES.iter().zip(spreads) {
                csv.row(&[
                    (*name).into(),
                    (*share).into(),
                    s.p25.into(),
                    s.median.into(),
                    s.p75.into(),
                    s.p95.into(),
                ]);
            }
        }
        Ok(Figure {
            number: 6,
            title: "Outliers".to_owned(),
            svg: lariat_plot::draw("figure 6", &[chart], 1)?,
            shows: format!(
                "Of the {POINTS} points of each of {} ropes a share was moved by {:.0} to {:.0} % of the rope's length in any \
                 direction, the others have noise of {}: median distance, at the same ρ, between the curve of nine control \
                 points fitted to them and the one fitted to the exact points.",
                self.shapes,
                100.0 * FAR[0],
                100.0 * FAR[1],
                format_args!("{SIGMA_PX} px")
            ),
            found: self.finding(),
            parameters: format!(
                "nine control points; shares {SHARES:?}; {FAR:?} of the length away; noise {SIGMA_PX} px"
            ),
            table: None,
            csv,
        })
    }
}

/// Returns the noisy points with a share of them turned into outliers.
fn spoiled(points: &[[f64; 2]], share: f64, random: &mut SplitMix64) -> Vec<[f64; 2]> {
    let steps = points.windows(2);
    let length_px: f64 = steps.map(|s| apart_px(s[0], s[1])).sum();
    let mut spoiled: Vec<[f64; 2]> = points
        .iter()
        .map(|p| p.map(|c| c + SIGMA_PX * random.normal()))
        .collect();
    let mut order: Vec<usize> = (0..points.len()).collect();
    shuffle(&mut order, random);
    let count = (share * points.len() as f64).round() as usize;
    for &i in order.iter().take(count) {
        let (sin, cos) = random.uniform(0.0, std::f64::consts::TAU).sin_cos();
        let far_px = length_px * random.uniform(FAR[0], FAR[1]);
        spoiled[i] = [points[i][0] + far_px * cos, points[i][1] + far_px * sin];
    }
    spoiled
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sentence_follows_the_numbers() {
        let outliers = |plain: f64, robust: f64| Outliers {
            rows: [plain, robust, plain, robust]
                .map(|off| vec![Spread::of([off]); SHARES.len()])
                .to_vec(),
            shapes: 1,
        };
        let found = outliers(5.0, 0.5).finding();
        assert!(found.starts_with("Least squares, the paper's method, is not robust"));
        assert!(
            found.contains("by 5.00 px with least squares and by 0.500 px"),
            "{found}"
        );
        assert!(outliers(5.0, 3.0).finding().contains("weights help, but"));
        assert!(
            outliers(0.5, 0.5)
                .finding()
                .starts_with("Huber's weights change little")
        );
    }

    #[test]
    fn as_many_points_are_moved_as_are_asked_for() {
        let line: Vec<[f64; 2]> = (0..POINTS).map(|i| [5.0 * i as f64, 0.0]).collect();
        let moved = spoiled(&line, 0.1, &mut of_stream(2, 2));
        let far = line.iter().zip(&moved);
        let far = far.filter(|(a, b)| apart_px(**a, **b) > 5.0);
        assert_eq!(far.count(), 12);
    }
}
