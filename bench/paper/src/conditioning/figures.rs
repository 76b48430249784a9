//! Condition numbers, gains and total errors as figures.

use lariat_plot::{Axis, Chart, LineStyle, Mark, Marker, Stroke};

use super::{Conditioning, DRAWS, MAIN, NoiseOf, ORDERS, Row, SIGMAS_PX};
use crate::PaperError;
use crate::csv::Csv;
use crate::figure::{Figure, Table};
use crate::shapes::POINTS;

impl Conditioning {
    /// Returns the best orders for control points, by kind of rope and noise.
    fn table(&self) -> Table {
        let mut head = vec!["the best order n for control points".to_owned()];
        head.extend(SIGMAS_PX.map(|sigma_px| format!("noise {sigma_px} px")));
        let mut table = Table {
            head,
            rows: Vec::new(),
        };
        for (k, kind) in self.kinds.iter().enumerate() {
            let mut row = vec![(*kind).to_owned()];
            for sigma_px in SIGMAS_PX {
                let best = self.best_of(|row| row.kinds_px[k].hypot(row.noise_px(sigma_px)));
                row.push(best.map_or_else(String::new, |n| n.to_string()));
            }
            table.row(row);
        }
        table
    }

    pub(crate) fn figures(&self) -> Result<[Figure; 2], PaperError> {
        Ok([self.figure_10()?, self.figure_11()?])
    }

    fn figure_10(&self) -> Result<Figure, PaperError> {
        let all = self.rows.iter().flat_map(|row| {
            let [c, g] = row.bspline.unwrap_or([f64::NAN; 2]);
            [row.condition, row.gain, c, g]
        });
        let mut chart = Chart::new(
            Axis::linear("order n (control points less one)", [0.5, 24.5], 2.0),
            Axis::log_around("condition number, noise gain", all),
        );
        let line = |of: &dyn Fn(&Row) -> f64| {
            self.rows
                .iter()
                .map(|row| [row.order as f64, of(row)])
                .collect()
        };
        let of_spline = |k: usize| move |row: &Row| row.bspline.map_or(f64::NAN, |b| b[k]);
        chart.line(
            "Bezier: condition of B",
            LineStyle::nth(0),
            line(&|row| row.condition),
        );
        chart.line(
            "Bezier: noise gain",
            LineStyle::nth(1),
            line(&|row| row.gain),
        );
        chart.line(
            "B-spline: condition of B",
            LineStyle::nth(2),
            line(&of_spline(0)),
        );
        chart.line(
            "B-spline: noise gain",
            LineStyle::nth(3),
            line(&of_spline(1)),
        );
        Ok(Figure {
            number: 10,
            title: "Condition number and noise gain against order".to_owned(),
            svg: lariat_plot::draw("figure 10", &[chart], 1)?,
            shows: format!(
                "For {POINTS} points: the condition number of B in the 2-norm (that of BᵀB is its square), and the noise \
                 gain, the standard deviation of a coordinate of the least certain control point for noise of 1 in every \
                 coordinate of the points."
            ),
            found: self.conditioning_finding(),
            parameters: format!(
                "n = {} to {}; {DRAWS} draws of noise",
                ORDERS.start(),
                ORDERS.end()
            ),
            table: None,
            csv: self.csv_10(),
        })
    }

    fn csv_10(&self) -> Csv {
        let header = [
            "order",
            "condition",
            "noise_gain",
            "bspline_condition",
            "bspline_noise_gain",
        ];
        let mut csv = Csv::new("figure-10-conditioning.csv", &header);
        for row in &self.rows {
            let [condition, gain] = row.bspline.unwrap_or([f64::NAN; 2]);
            csv.row(&[
                row.order.into(),
                row.condition.into(),
                row.gain.into(),
                condition.into(),
                gain.into(),
            ]);
        }
        csv
    }

    fn figure_11(&self) -> Result<Figure, PaperError> {
        let panels: [(&str, NoiseOf); 2] = [
            ("control points", Row::noise_px),
            ("the curve", Row::curve_noise_px),
        ];
        let charts = panels.map(|(title, noise)| self.total_chart(title, noise));
        let mut csv = Csv::new(
            "figure-11-total-error.csv",
            &[
                "of", "order", "sigma_px", "model_px", "noise_px", "total_px",
            ],
        );
        for (title, noise) in panels {
            for sigma_px in SIGMAS_PX {
                for row in &self.rows {
                    let noise_px = noise(row, sigma_px);
                    csv.row(&[
                        title.into(),
                        row.order.into(),
                        sigma_px.into(),
                        row.model_px.into(),
                        noise_px.into(),
                        row.model_px.hypot(noise_px).into(),
                    ]);
                }
            }
        }
        Ok(Figure {
            number: 11,
            title: "The model's error and the noise's together".to_owned(),
            svg: lariat_plot::draw("figure 11", &charts, 2)?,
            shows: format!(
                "Median error of the Bezier curve over {} ropes, and its root sum of squares with what noise of the points \
                 does: left to the least certain control point, right to the curve. Rings: the least of each. Upright line: \
                 where noise of {} px overtakes the model's error.",
                self.shapes, SIGMAS_PX[MAIN]
            ),
            found: self.total_finding(),
            parameters: format!("noise {SIGMAS_PX:?} px, independent from point to point"),
            table: Some(self.table()),
            csv,
        })
    }

    /// Returns the model's error and its sums with the noise, by order.
    fn total_chart(&self, title: &str, noise: NoiseOf) -> Chart {
        let models = || self.rows.iter().map(|row| row.model_px);
        let top = 30.0 * models().fold(0.0, f64::max);
        let mut chart = Chart::new(
            Axis::linear("order n", [0.5, 24.5], 4.0),
            Axis::log_around("error, px", models().chain([top])),
        )
        .titled(title);
        let line = |of: &dyn Fn(&Row) -> f64| {
            self.rows
                .iter()
                .map(|row| [row.order as f64, of(row)])
                .collect()
        };
        let bare = |n: usize| LineStyle::nth(n).marker(Marker::None);
        chart.line(
            "no noise",
            bare(6).stroke(Stroke::Solid),
            line(&|row| row.model_px),
        );
        for (i, &sigma_px) in SIGMAS_PX.iter().enumerate() {
            let total = |row: &Row| row.model_px.hypot(noise(row, sigma_px));
            let name = format!("noise {sigma_px} px");
            chart.line(
                &name,
                bare(i).stroke([Stroke::Dotted, Stroke::Dashed, Stroke::LongDashed][i]),
                line(&total),
            );
            let best = self
                .best(|row| noise(row, sigma_px))
                .and_then(|n| self.row(n));
            if let Some(row) = best {
                let look = LineStyle::nth(i).marker(Marker::Circle);
                chart.line("", look, vec![[row.order as f64, total(row)]]);
            }
        }
        if let Some(n) = self.overtaken(|row| noise(row, SIGMAS_PX[MAIN])) {
            chart.marks.push(Mark::Rule {
                x: n as f64,
                text: format!("n = {n}"),
            });
        }
        chart
    }
}
