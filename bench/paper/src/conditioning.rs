//! Condition number and noise gain by order, and the order at which noise exceeds the model's
//! error. This shows why to choose order 8 and not 20.

mod figures;

use lariat_fit::Basis;
use lariat_plot::spread::median;
use lariat_plot::words::{digits, list};

use crate::PaperError;
use crate::curves::{bspline, fitter};
use crate::random::of_stream;
use crate::shapes::{POINTS, Shapes};

const ORDERS: std::ops::RangeInclusive<usize> = 1..=24;
/// Standard deviations of the noise of each coordinate of each point, px.
const SIGMAS_PX: [f64; 3] = [0.1, 0.3, 1.0];
/// Index of the noise that the findings are about.
const MAIN: usize = 1;
/// Number of noise samples drawn to check the gain.
const DRAWS: usize = 400;

/// Effect of one order on noise and on the shapes.
#[derive(Debug, Clone, PartialEq)]
struct Row {
    order: usize,
    condition: f64,
    gain: f64,
    /// Condition number and noise gain of the cubic B-spline with the same number of control
    /// points.
    bspline: Option<[f64; 2]>,
    /// Median distance of the curve from exact points, px.
    model_px: f64,
    /// The same median for each kind of rope.
    kinds_px: Vec<f64>,
}

impl Row {
    /// Returns how far noise displaces the least certain control point, px.
    fn noise_px(&self, sigma_px: f64) -> f64 {
        std::f64::consts::SQRT_2 * self.gain * sigma_px
    }

    /// Returns how far noise displaces the curve on average, px: `σ √(2 (n + 1) / N)`.
    fn curve_noise_px(&self, sigma_px: f64) -> f64 {
        sigma_px * (2.0 * (self.order + 1) as f64 / POINTS as f64).sqrt()
    }
}

/// Returns the displacement that noise of the given standard deviation causes at a row's order.
/// Both are in px.
type NoiseOf = fn(&Row, f64) -> f64;

/// Condition numbers, gains and errors by order.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Conditioning {
    rows: Vec<Row>,
    /// Gain of order 8 measured with random noise.
    drawn_gain: f64,
    kinds: Vec<&'static str>,
    shapes: usize,
}

impl Conditioning {
    pub(crate) fn run(shapes: &Shapes, seed: u64) -> Result<Self, PaperError> {
        let kinds = shapes.kinds();
        let mut rows = Vec::new();
        for order in ORDERS {
            let mut bezier = fitter(Basis::Bezier { order })?;
            let mut off = Vec::new();
            for shape in &shapes.all {
                off.push(bezier.fit(&shape.reference)?.rms_px);
            }
            let fit = bezier.last();
            let (condition, gain) = (fit.condition, fit.noise_gain());
            let bspline = if order >= 3 {
                let fitter = fitter(bspline(order + 1))?;
                Some([fitter.last().condition, fitter.last().noise_gain()])
            } else {
                None
            };
            rows.push(Row {
                order,
                condition,
                gain,
                bspline,
                kinds_px: (kinds.iter())
                    .map(|kind| {
                        let of = shapes.all.iter().zip(&off);
                        median(of.filter(|(s, _)| s.kind == *kind).map(|(_, &px)| px))
                    })
                    .collect(),
                model_px: median(off),
            });
        }
        Ok(Self {
            rows,
            drawn_gain: drawn_gain(seed)?,
            kinds,
            shapes: shapes.all.len(),
        })
    }

    fn row(&self, order: usize) -> Option<&Row> {
        self.rows.iter().find(|row| row.order == order)
    }

    /// Returns the order with the least root sum of squares of the model's error and `noise`.
    fn best(&self, noise: impl Fn(&Row) -> f64) -> Option<usize> {
        self.best_of(|row| row.model_px.hypot(noise(row)))
    }

    fn best_of(&self, total: impl Fn(&Row) -> f64) -> Option<usize> {
        let rows = self.rows.iter();
        let best = rows.min_by(|a, b| total(a).total_cmp(&total(b)));
        best.map(|row| row.order)
    }

    /// Returns the first order at which noise exceeds the model's error.
    fn overtaken(&self, noise: impl Fn(&Row) -> f64) -> Option<usize> {
        let first = self.rows.iter().find(|row| noise(row) > row.model_px);
        first.map(|row| row.order)
    }

    fn conditioning_finding(&self) -> String {
        let told = |order| {
            self.row(order).map_or(String::new(), |row| {
                format!(
                    "{} and {} at n = {order}",
                    digits(row.condition),
                    digits(row.gain)
                )
            })
        };
        let splines = self.rows.iter().filter_map(|row| row.bspline);
        let most = splines.fold([0.0f64; 2], |most, b| {
            [most[0].max(b[0]), most[1].max(b[1])]
        });
        let [eight, twenty] = [8, 20].map(|n| self.row(n).map_or(f64::NAN, |row| row.gain));
        let verdict = if twenty > 100.0 * eight {
            "This is why 8 and not 20"
        } else {
            "High orders are no worse"
        };
        format!(
            "{verdict}: condition number and noise gain of the Bezier curve are {}, {} and {}; those of a cubic B-spline \
             stay below {} and {} at any size. Noise that was drawn moved the least certain control point of order 8 by {} px \
             a pixel; foretold were {}.",
            told(4),
            told(8),
            told(20),
            digits(most[0]),
            digits(most[1]),
            digits(self.drawn_gain),
            digits(eight),
        )
    }

    fn total_finding(&self) -> String {
        let sigma = SIGMAS_PX[MAIN];
        let crossing = |order: Option<usize>| match order {
            Some(order) => format!("from n = {order} on"),
            None => format!("at no order up to {}", ORDERS.end()),
        };
        let bests: Vec<String> = SIGMAS_PX
            .iter()
            .filter_map(|&s| {
                let best = self.best(|row| row.noise_px(s))?;
                Some(format!("n = {best} for {s} px"))
            })
            .collect();
        let least = match self.best(|row| row.curve_noise_px(sigma)) {
            Some(best) if best < *ORDERS.end() => format!("the sum is least at n = {best}"),
            _ => format!("up to n = {} the sum only falls", ORDERS.end()),
        };
        let verdict = match self.best(|row| row.noise_px(sigma)) {
            Some(best) if best < 8 => {
                "For control points as a feature the paper's 8 is already too much"
            }
            Some(best) if best > 8 => {
                "For control points as a feature the paper's 8 is not yet too much"
            }
            _ => "For control points as a feature the paper's 8 is the best",
        };
        format!(
            "{verdict}: at a noise of {sigma} px the noise in the control points is more than the model's error {}, and their sum is \
             least at {}. The curve itself hardly knows: along it noise overtakes {}, and {least}.",
            crossing(self.overtaken(|row| row.noise_px(sigma))),
            list(&bests),
            crossing(self.overtaken(|row| row.curve_noise_px(sigma))),
        )
    }
}

/// Measures the gain of order 8 with random noise.
fn drawn_gain(seed: u64) -> Result<f64, PaperError> {
    let mut fitter = fitter(Basis::Bezier { order: 8 })?;
    let mut random = of_stream(seed, 70_000);
    let mut squares = [0.0f64; 9];
    for _ in 0..DRAWS {
        let points = [(); POINTS].map(|()| [random.normal(), random.normal()]);
        for (sum, [x, y]) in squares.iter_mut().zip(&fitter.fit(&points)?.control_points) {
            *sum += 0.5 * (x * x + y * y);
        }
    }
    let most = squares.iter().copied().fold(0.0, f64::max);
    Ok((most / DRAWS as f64).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn conditioning(gain_growth: f64, fall: f64) -> Conditioning {
        let rows = ORDERS.map(|order| Row {
            order,
            condition: 10.0,
            gain: gain_growth.powi(order as i32) / 2.0,
            bspline: (order >= 3).then_some([5.0, 1.0]),
            model_px: 60.0 * fall.powi(order as i32 - 1),
            kinds_px: vec![60.0 * fall.powi(order as i32 - 1)],
        });
        Conditioning {
            rows: rows.collect(),
            drawn_gain: 25.0,
            kinds: vec!["drawn"],
            shapes: 1,
        }
    }

    #[test]
    fn the_sentences_follow_the_numbers() {
        let growing = conditioning(2.0, 0.6);
        assert!(
            growing
                .conditioning_finding()
                .starts_with("This is why 8 and not 20")
        );
        let found = growing.total_finding();
        assert!(found.contains("already too much"), "{found}");
        assert!(
            found.contains("more than the model's error from n = 6 on"),
            "{found}"
        );
        let level = conditioning(1.0, 0.6);
        assert!(
            level
                .conditioning_finding()
                .starts_with("High orders are no worse")
        );
        assert!(level.total_finding().contains("not yet too much"));
        // If the model does not improve with the order, noise never exceeds its error.
        assert!(
            conditioning(1.0, 1.0)
                .total_finding()
                .contains("at no order up to 24")
        );
    }

    #[test]
    fn drawn_noise_has_the_gain_that_the_covariance_foretells() {
        let foretold = fitter(Basis::Bezier { order: 8 })
            .unwrap()
            .last()
            .noise_gain();
        // The standard deviation is 2.5 %, from 400 draws of two coordinates. The tolerance is
        // wider because the gain is the largest of several values.
        assert!((drawn_gain(1).unwrap() / foretold - 1.0).abs() < 0.12);
    }
}
