//! Figure 3 of the paper: the error of fits of increasing order.

use lariat_fit::Basis;
use lariat_plot::words::{count, digits, list, percent, px};
use lariat_plot::{Axis, Chart, LineStyle, Mark, Marker, Spread, Stroke as Dash, spread::median};

use crate::PaperError;
use crate::csv::Csv;
use crate::curves::{PAPERS, fitter, off_at_rho_px};
use crate::figure::{Figure, Table};
use crate::shapes::{POINTS, Shape, Shapes};

/// The orders of figure 3.
const ORDERS: std::ops::RangeInclusive<usize> = 1..=12;
/// Share of the shapes for which a finding must hold.
const HOLDS: f64 = 0.95;

/// Errors of the fits of one shape, by order.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Row {
    shape: String,
    kind: &'static str,
    /// Distance of the curve from the fitted points at their ρ, by order from 1 on. The paper's
    /// `√(Q/N)`.
    residual_px: Vec<f64>,
    /// Distance from the reference centerline at the same ρ.
    off_px: Vec<f64>,
}

/// The errors of all shapes by order.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Orders {
    rows: Vec<Row>,
    kinds: Vec<&'static str>,
    has_truth: bool,
}

impl Orders {
    pub(crate) fn run(shapes: &Shapes) -> Result<Self, PaperError> {
        let mut rows: Vec<Row> = shapes.all.iter().map(Row::empty).collect();
        for order in ORDERS {
            let mut fitter = fitter(Basis::Bezier { order })?;
            for (row, shape) in rows.iter_mut().zip(&shapes.all) {
                let fit = fitter.fit(shape.points())?;
                row.residual_px.push(fit.rms_px);
                row.off_px.push(off_at_rho_px(fit, &shape.reference)?);
            }
        }
        Ok(Self {
            rows,
            kinds: shapes.kinds(),
            has_truth: shapes.has_truth,
        })
    }

    fn spread(&self, order: usize) -> Spread {
        Spread::of(self.rows.iter().map(|row| row.residual_px[order - 1]))
    }

    /// Returns the medians of one kind of rope, by order.
    fn of_kind(&self, kind: &str) -> Vec<[f64; 2]> {
        let of = |order: usize| {
            let rows = self.rows.iter().filter(|row| row.kind == kind);
            median(rows.map(|row| row.residual_px[order - 1]))
        };
        ORDERS.map(|order| [order as f64, of(order)]).collect()
    }

    fn median_off(&self, order: usize) -> f64 {
        median(self.rows.iter().map(|row| row.off_px[order - 1]))
    }

    /// Returns the pictured shape whose error at order 8 is closest to the median.
    pub(crate) fn typical(&self, shapes: &Shapes) -> Option<usize> {
        let middle = self.spread(8).median;
        let shown = (0..self.rows.len()).filter(|&i| shapes.all[i].picture.is_some());
        let off = |i: usize| (self.rows[i].residual_px[7] / middle).ln().abs();
        shown.min_by(|&a, &b| off(a).total_cmp(&off(b)))
    }

    /// Returns the paper's statement about figure 3 and whether it holds here.
    pub(crate) fn finding(&self) -> String {
        let medians = PAPERS.map(|order| self.spread(order).median);
        let falls = medians.windows(2).all(|pair| pair[1] < pair[0]);
        let share = |is_so: &dyn Fn(&[f64]) -> bool| {
            let so = self
                .rows
                .iter()
                .filter(|row| is_so(&row.residual_px))
                .count();
            so as f64 / self.rows.len() as f64
        };
        let best = share(&|r| PAPERS.iter().all(|&n| n == 8 || r[7] < r[n - 1]));
        let worst = share(&|r| PAPERS.iter().all(|&n| n == 2 || r[1] > r[n - 1]));
        let told: Vec<String> = PAPERS
            .iter()
            .zip(medians)
            .map(|(n, median)| format!("{} at n = {n}", px(median)))
            .collect();
        let verdict = if falls && best >= HOLDS && worst >= HOLDS {
            "The paper's finding is confirmed"
        } else if falls {
            "The paper's finding is confirmed for the median, but not for every shape"
        } else {
            "The paper's finding is not confirmed"
        };
        let mut sentence = format!(
            "{verdict}: of its four orders the median error is {}; n = 8 is the best of the four in {} of the {}, n = 2 \
             the worst in {}.",
            list(&told),
            percent(best),
            count(self.rows.len(), "shape", "shapes"),
            percent(worst),
        );
        let (last, eight) = (*ORDERS.end(), self.spread(8).median);
        let beyond = self.spread(last).median;
        if beyond < 0.9 * eight {
            sentence += &format!(
                " But 8 is not where it ends: at n = {last} the median is {}, {} of that at 8.",
                px(beyond),
                percent(beyond / eight)
            );
        } else {
            sentence += &format!(
                " From there on little is gained: at n = {last} the median is {}.",
                px(beyond)
            );
        }
        sentence
    }

    /// Says which part of the result is inevitable and which is a finding.
    fn caveat(&self) -> String {
        let eight = [self.spread(8).median, self.median_off(8)];
        let mut text = "Each order contains all lower ones, so that least squares cannot do worse with more of them: that \
                        the error falls is no finding, how fast is."
            .to_owned();
        if let [first, .., last] = self.kinds[..] {
            text += &format!(
                " How fast depends on the rope: at n = 8 the {first} ones are {} off, those of the kind “{last}” {}.",
                px(self.of_kind(first)[7][1]),
                px(self.of_kind(last)[7][1])
            );
        }
        if self.has_truth {
            text += &format!(
                " The distance from the true centerline might rise again where the curve begins to follow the points' own \
                 errors; at n = 8 it is {}, that from the points {}.",
                px(eight[1]),
                px(eight[0])
            );
        }
        text
    }

    pub(crate) fn figure_3(&self) -> Result<Figure, PaperError> {
        let spreads: Vec<(f64, Spread)> = ORDERS.map(|n| (n as f64, self.spread(n))).collect();
        let all = spreads.iter().flat_map(|(_, s)| [s.p5, s.p95]);
        let mut chart = Chart::new(
            Axis::linear("order n", [0.6, 12.4], 1.0),
            Axis::log_around("error, px", all),
        );
        let band =
            |name: &str, opacity, low: fn(&Spread) -> f64, high: fn(&Spread) -> f64| Mark::Band {
                name: name.to_owned(),
                color: 0,
                opacity,
                edges: spreads.iter().map(|(n, s)| [*n, low(s), high(s)]).collect(),
            };
        chart
            .marks
            .push(band("5 to 95 % of the shapes", 0.15, |s| s.p5, |s| s.p95));
        chart
            .marks
            .push(band("middle half", 0.25, |s| s.p25, |s| s.p75));
        let line = spreads.iter().map(|(n, s)| [*n, s.median]).collect();
        chart.line("median of all", LineStyle::nth(0), line);
        if self.kinds.len() > 1 {
            const STROKES: [Dash; 5] = [
                Dash::Dashed,
                Dash::Dotted,
                Dash::LongDashed,
                Dash::Solid,
                Dash::Dashed,
            ];
            for (i, kind) in self.kinds.iter().enumerate() {
                let look = LineStyle::nth(i + 1).marker(Marker::None);
                chart.line(
                    kind,
                    look.stroke(STROKES[i % STROKES.len()]),
                    self.of_kind(kind),
                );
            }
        }
        Ok(Figure {
            number: 3,
            title: "Error against order".to_owned(),
            svg: lariat_plot::draw("figure 3", &[chart], 1)?,
            shows: format!(
                "Root mean square distance √(Q/N) between the {POINTS} points of a centerline and the Bezier curve of order \
                 n fitted to them, over {}.",
                count(self.rows.len(), "rope", "ropes")
            ),
            found: format!("{} {}", self.finding(), self.caveat()),
            parameters: format!("n = {} to {}; points as seen", ORDERS.start(), ORDERS.end()),
            table: Some(self.table()),
            csv: self.csv(),
        })
    }

    fn table(&self) -> Table {
        let mut table = Table::new(&["order n", "5 %", "25 %", "median", "75 %", "95 %"]);
        for order in PAPERS.into_iter().chain([10, 12]) {
            let s = self.spread(order);
            let mut row = vec![order.to_string()];
            row.extend([s.p5, s.p25, s.median, s.p75, s.p95].map(digits));
            table.row(row);
        }
        table
    }

    fn csv(&self) -> Csv {
        let header = [
            "shape",
            "kind",
            "order",
            "residual_rms_px",
            "reference_rms_px",
        ];
        let mut csv = Csv::new("figure-3-orders.csv", &header);
        for row in &self.rows {
            for order in ORDERS {
                csv.row(&[
                    row.shape.as_str().into(),
                    row.kind.into(),
                    order.into(),
                    row.residual_px[order - 1].into(),
                    row.off_px[order - 1].into(),
                ]);
            }
        }
        csv
    }
}

impl Row {
    fn empty(shape: &Shape) -> Self {
        Self {
            shape: shape.name.clone(),
            kind: shape.kind,
            residual_px: Vec::new(),
            off_px: Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Makes one shape per row of `errors`. A row holds the error of each order.
    fn orders(errors: &[[f64; 12]]) -> Orders {
        Orders {
            rows: errors
                .iter()
                .map(|errors| Row {
                    shape: "a, \"rope\"".to_owned(),
                    kind: "drawn",
                    residual_px: errors.to_vec(),
                    off_px: errors.to_vec(),
                })
                .collect(),
            kinds: vec!["drawn"],
            has_truth: true,
        }
    }

    const FALLING: [f64; 12] = [
        50.0, 30.0, 20.0, 9.0, 6.0, 4.0, 3.0, 2.0, 1.5, 1.2, 1.0, 0.9,
    ];

    #[test]
    fn a_falling_error_confirms_the_paper() {
        let found = orders(&[FALLING; 3]).finding();
        assert!(
            found.starts_with("The paper's finding is confirmed: "),
            "{found}"
        );
        assert!(found.contains("30.0 px at n = 2") && found.contains("2.00 px at n = 8"));
        assert!(found.contains("in 100 % of the 3 shapes"), "{found}");
        assert!(found.contains("8 is not where it ends: at n = 12 the median is 0.900 px, 45 %"));
    }

    #[test]
    fn a_shape_that_differs_is_counted() {
        let mut other = FALLING;
        other[7] = 5.0;
        let found = orders(&[FALLING, FALLING, other]).finding();
        assert!(found.contains("not for every shape"), "{found}");
        assert!(found.contains("best of the four in 67 %"), "{found}");
    }

    #[test]
    fn an_error_that_does_not_fall_refutes_it() {
        let mut other = FALLING;
        other[7] = 40.0;
        other[11] = 39.0;
        let found = orders(&[other; 2]).finding();
        assert!(
            found.starts_with("The paper's finding is not confirmed"),
            "{found}"
        );
        assert!(found.contains("little is gained"), "{found}");
    }
}
