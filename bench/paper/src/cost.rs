//! Computational efficiency, which the paper claims but does not show: the time of a fit by order
//! and solver.

use lariat_fit::{Basis, Fitter, Options, Rho, Solver};
use lariat_plot::spread::median;
use lariat_plot::words::{digits, list, percent, time};
use lariat_plot::{Axis, Chart, LineStyle};
use std::time::Instant;

use crate::csv::Csv;
use crate::figure::Figure;
use crate::shapes::{POINTS, Shapes};
use crate::{Effort, PaperError};

const ORDERS: [usize; 10] = [1, 2, 4, 6, 8, 10, 12, 16, 20, 24];
/// Minimum duration of a measurement, s, so that the clock's resolution does not matter.
const BATCH_S: f64 = 3e-4;

/// The way a fit is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Way {
    Solver(Solver),
    /// Measures ρ along the points, so that all algebra is repeated for each fit: the paper's "at
    /// every iteration".
    Recomputed,
}

impl Way {
    const ALL: [Self; 4] = [
        Self::Solver(Solver::Pinv),
        Self::Solver(Solver::Cholesky),
        Self::Solver(Solver::Qr),
        Self::Recomputed,
    ];

    fn name(self) -> &'static str {
        match self {
            Self::Solver(Solver::Pinv) => "pinv: (BᵀB)⁻¹Bᵀ kept",
            Self::Solver(Solver::Cholesky) => "cholesky of BᵀB kept",
            Self::Solver(Solver::Qr) => "QR of B kept",
            Self::Recomputed => "measured ρ: algebra again",
        }
    }

    /// Returns `None` for an order that the solver refuses.
    fn fitter(self, order: usize) -> Option<Fitter> {
        let options = Options::default()
            .basis(Basis::Bezier { order })
            .points(POINTS);
        let options = match self {
            Self::Solver(solver) => options.solver(solver),
            Self::Recomputed => options.rho(Rho::Measured),
        };
        Fitter::new(options).ok()
    }
}

/// Times of fits.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Cost {
    /// Times by way and order, µs. NaN if the solver refuses the order.
    fits_us: Vec<(Way, Vec<f64>)>,
    extraction_us: f64,
}

impl Cost {
    pub(crate) fn run(shapes: &Shapes, effort: &Effort) -> Result<Self, PaperError> {
        let points = shapes.all[0].points();
        let mut fits_us = Vec::new();
        for way in Way::ALL {
            let mut row = Vec::new();
            for order in ORDERS {
                row.push(match way.fitter(order) {
                    Some(mut fitter) => median_us(effort.rounds, || {
                        fitter.fit(points).map(|_| ()).map_err(PaperError::from)
                    })?,
                    None => f64::NAN,
                });
            }
            fits_us.push((way, row));
        }
        Ok(Self {
            fits_us,
            extraction_us: shapes.extraction_us,
        })
    }

    fn of(&self, way: Way, order: usize) -> f64 {
        let column = ORDERS.iter().position(|&n| n == order);
        let row = self.fits_us.iter().find(|(of, _)| *of == way);
        match (row, column) {
            (Some((_, row)), Some(column)) => row[column],
            _ => f64::NAN,
        }
    }

    fn finding(&self) -> String {
        let [two, eight] = [2, 8].map(|n| self.of(Way::Solver(Solver::Pinv), n));
        let share = eight / self.extraction_us;
        let growth = eight / two;
        let verdict = if share < 0.05 {
            "Higher orders are cheap, contrary to the paper's concern"
        } else {
            "Higher orders cost, as the paper fears"
        };
        let refused: Vec<String> = self
            .fits_us
            .iter()
            .filter_map(|(way, row)| {
                let first = row.iter().position(|us| us.is_nan())?;
                Some(format!("{} from n = {} on", way.name(), ORDERS[first]))
            })
            .collect();
        let mut sentence = format!(
            "{verdict}: with the algebra done beforehand a fit of order 8 takes {}, {} times that of order 2, and {} of an \
             extraction from the picture ({}). With all algebra again for each centerline it takes {}.",
            time(eight),
            digits(growth),
            percent(share),
            time(self.extraction_us),
            time(self.of(Way::Recomputed, 8)),
        );
        if !refused.is_empty() {
            sentence += &format!(
                " Refused, as rounding would show in the control points: {}.",
                list(&refused)
            );
        }
        sentence
    }

    pub(crate) fn figure(&self) -> Result<Figure, PaperError> {
        let all = self.fits_us.iter().flat_map(|(_, row)| row.iter().copied());
        let mut chart = Chart::new(
            Axis::linear("order n", [0.0, 25.0], 2.0),
            Axis::log_around("time of a fit, µs", all),
        );
        let mut csv = Csv::new("figure-8-cost.csv", &["way", "order", "fit_us"]);
        for (i, (way, row)) in self.fits_us.iter().enumerate() {
            let line = ORDERS.iter().zip(row);
            chart.line(
                way.name(),
                LineStyle::nth(i),
                line.map(|(&n, &us)| [n as f64, us]).collect(),
            );
            for (order, us) in ORDERS.iter().zip(row) {
                csv.row(&[way.name().into(), (*order).into(), (*us).into()]);
            }
        }
        csv.row(&[
            "extraction from the picture".into(),
            0.into(),
            self.extraction_us.into(),
        ]);
        Ok(Figure {
            number: 8,
            title: "Time against order".to_owned(),
            svg: lariat_plot::draw("figure 8", &[chart], 1)?,
            shows: format!(
                "Time of one fit of a Bezier curve to {POINTS} points on this machine, the residuals of all points included: \
                 medians."
            ),
            found: self.finding(),
            parameters: format!("n = {ORDERS:?}; batches of {} ms", 1e3 * BATCH_S),
            table: None,
            csv,
        })
    }
}

/// Returns the median time of one call over `rounds` rounds, µs.
pub(crate) fn median_us(
    rounds: usize,
    mut call: impl FnMut() -> Result<(), PaperError>,
) -> Result<f64, PaperError> {
    let mut calls = 1usize;
    let mut times = Vec::new();
    loop {
        let began = Instant::now();
        for _ in 0..calls {
            call()?;
        }
        let took_s = began.elapsed().as_secs_f64();
        if took_s < BATCH_S && calls < 1 << 20 {
            // The batch was too short: it serves as a warm-up.
            calls = if took_s * 8.0 < BATCH_S {
                4 * calls
            } else {
                2 * calls
            };
            times.clear();
            continue;
        }
        times.push(1e6 * took_s / calls as f64);
        if times.len() >= rounds {
            return Ok(median(times));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cost(eight_us: f64) -> Cost {
        let row = |us: f64| ORDERS.map(|n| if n == 8 { us } else { 0.5 }).to_vec();
        let mut refused = row(3.0);
        refused[8..].fill(f64::NAN);
        Cost {
            fits_us: vec![
                (Way::ALL[0], row(eight_us)),
                (Way::ALL[1], refused),
                (Way::ALL[3], row(40.0)),
            ],
            extraction_us: 500.0,
        }
    }

    #[test]
    fn the_sentence_follows_the_numbers() {
        let found = cost(1.0).finding();
        assert!(
            found.contains("are cheap, ") && found.contains("takes 1.00 µs, 2.00 times"),
            "{found}"
        );
        assert!(
            found.contains("cholesky of BᵀB kept from n = 20 on"),
            "{found}"
        );
        assert!(cost(200.0).finding().starts_with("Higher orders cost"));
    }

    #[test]
    fn an_order_that_a_solver_refuses_has_no_time() {
        assert!(Way::Solver(Solver::Cholesky).fitter(24).is_none());
        assert!(Way::Solver(Solver::Pinv).fitter(24).is_some());
    }
}
