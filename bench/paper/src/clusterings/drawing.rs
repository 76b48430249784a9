//! The clusterings as a figure: panels over one picture and a table over all.

use lariat_plot::words::{digits, list, px, time};
use lariat_plot::{Spread, spread::mean};

use super::{Clusterings, SETTLING, SKELETON, WRONG_WIDTHS, short, title};
use crate::PaperError;
use crate::csv::Csv;
use crate::figure::{Figure, Table};
use crate::overlay::{self, Drawn, Panel, Stroke};
use crate::shapes::{POINTS, Shapes};

impl Clusterings {
    pub(crate) fn figure(&self, shapes: &Shapes) -> Result<Option<Figure>, PaperError> {
        let Some(shown) = self.shown(shapes) else {
            return Ok(None);
        };
        let picture = &shapes.pictures[shown];
        let ropes = || {
            shapes
                .all
                .iter()
                .filter(|shape| shape.picture == Some(shown))
        };
        let widest_px = ropes().map(|shape| shape.width_px).fold(0.0, f64::max);
        let view = overlay::close_up(
            picture,
            ropes().flat_map(|shape| &shape.dense),
            2.0 * widest_px,
        );
        let columns = if picture.height > picture.width { 4 } else { 3 };
        let panels = self.panels(shown, ropes().map(|shape| shape.dense.clone()));
        let names: Vec<String> = self
            .rows
            .iter()
            .map(|row| title(row.name).to_owned())
            .collect();
        Ok(Some(Figure {
            number: 1,
            title: "Centerlines by clustering, and by the skeleton".to_owned(),
            svg: overlay::draw("centerlines", &[picture], &panels, columns, view)?,
            shows: format!(
                "One picture ({}) of {}, and what is made of it by {}: {POINTS} points (dots), joined in the order they were \
                 given. In the table, over all pictures: distance of the points from {}, mean (the median of the \
                 pictures'), 95 % and the largest; the order is right if no point is more than {WRONG_WIDTHS} widths off that of the \
                 same ρ; time of the whole extraction without knowledge from before, and with that of the frame before.",
                picture.name,
                self.pictures,
                list(&names),
                shapes.measure()
            ),
            found: self.finding(),
            parameters: format!(
                "the first {} ropes; {SETTLING} frames before the warm ones; right order: {WRONG_WIDTHS} widths",
                self.pictures
            ),
            table: Some(self.table()),
            csv: self.csv(),
        }))
    }

    /// Returns panels of the picture with the true ropes and with each method's result.
    fn panels(&self, shown: usize, truths: impl Iterator<Item = Vec<[f64; 2]>>) -> Vec<Panel> {
        let line = |points: Vec<[f64; 2]>, color, width| Stroke {
            points,
            color,
            width,
            dashes: "",
            drawn: Drawn::Line,
        };
        let mut first = Panel {
            title: "the picture".to_owned(),
            picture: 0,
            strokes: Vec::new(),
        };
        if self.has_truth {
            first.title = "the truth".to_owned();
            first.strokes = truths.map(|points| line(points, "#000", 1.6)).collect();
        }
        let mut panels = vec![first];
        for row in &self.rows {
            let outcome = &row.outcomes[shown];
            let mut title = short(row.name);
            if row.name != SKELETON || self.has_truth {
                title += &format!(": {}", px(mean(outcome.distances_px.iter().copied())));
            }
            if !outcome.right_order {
                title += ", wrong order";
            }
            let mut strokes = Vec::new();
            for curve in &outcome.curves {
                strokes.push(line(curve.clone(), "#222", 0.9));
                strokes.push(Stroke {
                    drawn: Drawn::Dots,
                    ..line(curve.clone(), "#D55E00", 2.6)
                });
            }
            panels.push(Panel {
                title,
                picture: 0,
                strokes,
            });
        }
        panels
    }

    /// Returns the picture to show: the first one on which only some methods have the right order,
    /// otherwise the first one.
    fn shown(&self, shapes: &Shapes) -> Option<usize> {
        if shapes.pictures.is_empty() || self.rows.is_empty() {
            return None;
        }
        let differ = |k: &usize| {
            let right = self
                .rows
                .iter()
                .filter(|row| row.outcomes[*k].right_order)
                .count();
            right > 0 && right < self.rows.len()
        };
        Some((0..self.pictures).find(differ).unwrap_or(0))
    }

    fn table(&self) -> Table {
        let head = [
            "centerline by",
            "mean, px",
            "95 %",
            "largest",
            "right order",
            "cold",
            "warm",
        ];
        let mut table = Table::new(&head);
        for row in &self.rows {
            let [p95, most] = row.tail_px();
            table.row(vec![
                title(row.name).to_owned(),
                digits(row.off_px()),
                digits(p95),
                digits(most),
                format!("{} of {}", row.right(), self.pictures),
                time(row.cold_us()),
                time(row.warm_us()),
            ]);
        }
        table
    }

    fn csv(&self) -> Csv {
        let header = [
            "method",
            "picture",
            "mean_px",
            "p95_px",
            "max_px",
            "right_order",
            "cold_us",
            "warm_us",
        ];
        let mut csv = Csv::new("figure-1-clusterings.csv", &header);
        for row in &self.rows {
            for outcome in &row.outcomes {
                let all = || outcome.distances_px.iter().copied();
                csv.row(&[
                    row.name.into(),
                    outcome.picture.as_str().into(),
                    mean(all()).into(),
                    Spread::of(all()).p95.into(),
                    all().fold(f64::NAN, f64::max).into(),
                    usize::from(outcome.right_order).into(),
                    outcome.cold_us.into(),
                    outcome.warm_us.into(),
                ]);
            }
        }
        csv
    }
}
