//! Uneven steps and wrong orders as figures.

use lariat_plot::words::px;
use lariat_plot::{Axis, Chart, LineStyle, Mark, Marker, Stroke};

use super::{Disorder, Ordering, RATIOS, RHOS};
use crate::PaperError;
use crate::csv::Csv;
use crate::figure::{Figure, Table};
use crate::shapes::POINTS;

impl Ordering {
    pub(crate) fn figures(&self) -> Result<[Figure; 2], PaperError> {
        Ok([self.figure_12()?, self.figure_13()?])
    }

    fn figure_12(&self) -> Result<Figure, PaperError> {
        let all = self
            .steps
            .iter()
            .flat_map(|row| row.2.iter().map(|s| s.median));
        let mut chart = Chart::new(
            Axis::linear("largest step by least step", [1.0, 10.3], 1.0),
            Axis::log_around("distance, px", all),
        );
        let mut csv = Csv::new(
            "figure-12-arc-length.csv",
            &[
                "steps",
                "rho",
                "ratio",
                "p25_px",
                "median_px",
                "p75_px",
                "p95_px",
            ],
        );
        for (i, (unevenness, rho, spreads)) in self.steps.iter().enumerate() {
            let name = format!("{}, {}", unevenness.name(), RHOS[*rho].1);
            let line = RATIOS.iter().zip(spreads);
            chart.line(
                &name,
                LineStyle::nth(i),
                line.map(|(r, s)| [*r, s.median]).collect(),
            );
            for (ratio, s) in RATIOS.iter().zip(spreads) {
                csv.row(&[
                    unevenness.name().into(),
                    RHOS[*rho].1.into(),
                    (*ratio).into(),
                    s.p25.into(),
                    s.median.into(),
                    s.p75.into(),
                    s.p95.into(),
                ]);
            }
        }
        Ok(Figure {
            number: 12,
            title: "Arc length: even or measured".to_owned(),
            svg: lariat_plot::draw("figure 12", &[chart], 1)?,
            shows: format!(
                "Bezier curves of order 8 fitted to {POINTS} exact points that are not evenly spaced, taken for evenly spaced \
                 or with ρ measured along them: median distance, over {} ropes, from the curve fitted to points in even steps.",
                self.shapes
            ),
            found: self.steps_finding(),
            parameters: format!("n = 8; ratios {RATIOS:?}"),
            table: None,
            csv,
        })
    }

    fn figure_13(&self) -> Result<Figure, PaperError> {
        let names = Disorder::ALL.map(|d| d.name().to_owned()).to_vec();
        let all = self.orders.iter().flat_map(|row| [row.2.p5, row.2.p95]);
        let mut chart = Chart::new(
            Axis::log_around("distance from the rope, px", all),
            Axis::names("", names),
        );
        chart.left_px = 160;
        chart.height_px = 260;
        let looks = [0, 1].map(|k| {
            let marker = [Marker::Circle, Marker::Square][k];
            LineStyle::nth(k).stroke(Stroke::Solid).marker(marker)
        });
        for ((_, name), look) in RHOS.into_iter().zip(looks) {
            let name = name.to_owned();
            chart.marks.push(Mark::Key { name, look });
        }
        let rows = |of: Disorder| Disorder::ALL.iter().position(|d| *d == of).unwrap_or(0);
        for (disorder, rho, off, _) in &self.orders {
            chart.marks.push(Mark::Spread {
                row: rows(*disorder),
                shift: [-0.15, 0.15][*rho],
                look: looks[*rho],
                spread: *off,
            });
        }
        Ok(Figure {
            number: 13,
            title: "Points in a wrong order".to_owned(),
            svg: lariat_plot::draw("figure 13", &[chart], 1)?,
            shows: format!(
                "Distance between the rope and the Bezier curve of order 8 fitted to its exact points in another order, over \
                 {} ropes: markers are medians, thick lines the middle half, thin ones 5 to 95 %.",
                self.shapes
            ),
            found: self.orders_finding(),
            parameters: "n = 8; every tenth point with its neighbour; points 40 to 79 backwards"
                .to_owned(),
            table: Some(self.orders_table()),
            csv: self.orders_csv(),
        })
    }

    fn orders_table(&self) -> Table {
        let mut table = Table::new(&[
            "order of the points",
            "off, ρ even",
            "off, ρ measured",
            "control points moved, ρ even",
        ]);
        for disorder in Disorder::ALL {
            let of = || self.orders.iter().filter(|(of, ..)| *of == disorder);
            let mut cells = vec![disorder.name().to_owned()];
            cells.extend(of().map(|(_, _, off, _)| px(off.median)));
            cells.extend(of().take(1).map(|(_, _, _, moved)| px(*moved)));
            table.row(cells);
        }
        table
    }

    fn orders_csv(&self) -> Csv {
        let header = [
            "order",
            "rho",
            "p25_px",
            "median_px",
            "p75_px",
            "p95_px",
            "control_points_moved_px",
        ];
        let mut csv = Csv::new("figure-13-order.csv", &header);
        for (disorder, rho, off, moved) in &self.orders {
            csv.row(&[
                disorder.name().into(),
                RHOS[*rho].1.into(),
                off.p25.into(),
                off.median.into(),
                off.p75.into(),
                off.p95.into(),
                (*moved).into(),
            ]);
        }
        csv
    }
}
