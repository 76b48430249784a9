//! Light, noise and blur in the picture itself, and their effect on the extracted curve.

use lariat_drawn::scenes::Class;
use lariat_fit::Basis;
use lariat_plot::words::{digits, px};
use lariat_plot::{Axis, Chart, LineStyle, Mark, Marker, Spread, Stroke, spread::median};

use crate::csv::Csv;
use crate::curves::{fitter, sampled};
use crate::figure::{Figure, Table};
use crate::polyline::{even, rms_apart_px, rms_from_line_px};
use crate::shapes::{POINTS, TimedExtractor, along, still};
use crate::{Effort, PaperError, Picture};

/// Kinds of pictures, the plain one first.
const KINDS: [(Class, &str); 9] = [
    (Class::Medium, "plain"),
    (Class::LightChange, "half the light"),
    (Class::UnevenLight, "uneven light"),
    (Class::Noise, "noise"),
    (Class::Blur, "out of focus"),
    (Class::MotionBlur, "motion blur"),
    (Class::Shine, "shine"),
    (Class::Texture, "texture"),
    (Class::Shadow, "shadow"),
];
/// Minimum distance at which a curve counts as following a path other than the rope's, in rope
/// widths.
const ASTRAY_WIDTHS: f64 = 1.0;

/// Effect of one kind of picture.
#[derive(Debug, Clone, PartialEq)]
struct Row {
    name: &'static str,
    /// Distance of the extracted points from the true centerline, one value per picture.
    points_px: Vec<f64>,
    /// Distance at the same ρ between the curve fitted to the extracted points and the one fitted
    /// to the true points.
    curve_px: Vec<f64>,
    pictures: usize,
}

/// Effect of each kind of picture.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lights {
    rows: Vec<Row>,
    /// Displacement of the same rope's curve when the light is halved, one value per pair of
    /// pictures.
    halved_px: Vec<f64>,
}

impl Lights {
    pub(crate) fn run(seed: u64, effort: &Effort) -> Result<Self, PaperError> {
        let mut extractor = TimedExtractor::new()?;
        let mut fit = fitter(Basis::Bezier { order: 8 })?;
        let [width, height] = effort.size_px;
        let (mut rows, mut halved_px) = (Vec::new(), Vec::new());
        for (class, name) in KINDS {
            let mut row = Row {
                name,
                points_px: Vec::new(),
                curve_px: Vec::new(),
                pictures: effort.lights,
            };
            for i in 0..effort.lights as u64 {
                // Even seeds of the class have full light. The odd seed after each shows the same
                // rope in half the light.
                let picture_seed = seed.wrapping_mul(100_000).wrapping_add(2 * i + 1);
                let mut look = |picture_seed| -> Result<_, PaperError> {
                    let (still, _) = still(class, picture_seed, effort.size_px)?;
                    let rope = &still.truth.ropes[0];
                    let truth = even(&rope.points, POINTS);
                    let picture = Picture {
                        name: name.to_owned(),
                        width,
                        height,
                        rgb: still.rgb,
                    };
                    let seen = extractor.look(&picture)?;
                    let astray_px = ASTRAY_WIDTHS * rope.width_px;
                    let seen = match &seen[..] {
                        [seen] => along(&seen.points, &truth, astray_px),
                        _ => None,
                    };
                    let Some(seen) = seen else {
                        return Ok(None);
                    };
                    let points_px = rms_from_line_px(&seen, &rope.points);
                    let true_curve = sampled(fit.fit(&truth)?, POINTS)?;
                    let curve = sampled(fit.fit(&seen)?, POINTS)?;
                    Ok(Some((points_px, rms_apart_px(&curve, &true_curve), curve)))
                };
                let Some((points_px, curve_px, curve)) = look(picture_seed)? else {
                    continue;
                };
                row.points_px.push(points_px);
                row.curve_px.push(curve_px);
                if class == Class::LightChange
                    && let Some((_, _, in_full_light)) = look(picture_seed - 1)?
                {
                    halved_px.push(rms_apart_px(&curve, &in_full_light));
                }
            }
            rows.push(row);
        }
        Ok(Self { rows, halved_px })
    }

    fn finding(&self) -> String {
        let plain = median(self.rows[0].curve_px.iter().copied());
        let worst = self.rows[1..].iter().max_by(|a, b| {
            let of = |row: &Row| median(row.curve_px.iter().copied());
            of(a).total_cmp(&of(b))
        });
        let (worst, worst_px) = worst.map_or(("none", f64::NAN), |row| {
            (row.name, median(row.curve_px.iter().copied()))
        });
        let verdict = if worst_px < 1.0 {
            "The curve holds"
        } else {
            "The curve does not hold under everything"
        };
        let lost: usize = self
            .rows
            .iter()
            .map(|row| row.pictures - row.curve_px.len())
            .sum();
        let all: usize = self.rows.iter().map(|row| row.pictures).sum();
        format!(
            "{verdict}: what the picture does to the curve is {} in a plain picture and {} in the worst kind ({worst}). \
             Halving the light moves it by {}. In {lost} of {all} pictures the rope was not seen as it lies.",
            px(plain),
            px(worst_px),
            px(median(self.halved_px.iter().copied())),
        )
    }

    pub(crate) fn figure(&self) -> Result<Figure, PaperError> {
        let names = self.rows.iter().map(|row| row.name.to_owned()).collect();
        let all = self
            .rows
            .iter()
            .flat_map(|row| row.points_px.iter().chain(&row.curve_px));
        let mut chart = Chart::new(
            Axis::log_around("off, px", all.copied()),
            Axis::names("", names),
        );
        chart.left_px = 112;
        chart.height_px = 320;
        let looks = [LineStyle::nth(0), LineStyle::nth(1)].map(|look| look.stroke(Stroke::Solid));
        let keys = [
            "points, from the true centerline",
            "curve of order 8, from that of the true points",
        ];
        for (name, look) in keys.into_iter().zip(looks) {
            let name = name.to_owned();
            chart.marks.push(Mark::Key { name, look });
        }
        let mut csv = Csv::new(
            "figure-7-light.csv",
            &["kind", "picture", "points_rms_px", "curve_rms_px"],
        );
        let mut table = Table::new(&["picture", "points off, px", "curve off, px", "not seen"]);
        for (i, row) in self.rows.iter().enumerate() {
            let of = [&row.points_px, &row.curve_px];
            for (k, numbers) in of.into_iter().enumerate() {
                chart.marks.push(Mark::Spread {
                    row: i,
                    shift: [-0.16, 0.16][k],
                    look: looks[k].marker([Marker::Circle, Marker::Square][k]),
                    spread: Spread::of(numbers.iter().copied()),
                });
            }
            for (k, (points, curve)) in row.points_px.iter().zip(&row.curve_px).enumerate() {
                csv.row(&[row.name.into(), k.into(), (*points).into(), (*curve).into()]);
            }
            table.row(vec![
                row.name.to_owned(),
                digits(median(row.points_px.iter().copied())),
                digits(median(row.curve_px.iter().copied())),
                format!("{} of {}", row.pictures - row.points_px.len(), row.pictures),
            ]);
        }
        Ok(Figure {
            number: 7,
            title: "Light, noise and blur in the picture".to_owned(),
            svg: lariat_plot::draw("figure 7", &[chart], 1)?,
            shows: "Drawn pictures of each kind through the extractor: how far its points are off the true centerline, and \
                    how far that moves the curve of order 8. Markers are medians, thick lines the middle half, thin ones 5 to \
                    95 % of the pictures."
                .to_owned(),
            found: self.finding(),
            parameters: format!("n = 8; {} pictures of a kind", self.rows[0].pictures),
            table: Some(table),
            csv,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sentence_follows_the_numbers() {
        let lights = |worst: f64, seen: usize| Lights {
            rows: KINDS
                .iter()
                .enumerate()
                .map(|(i, (_, name))| Row {
                    name,
                    points_px: vec![0.1; seen],
                    curve_px: vec![if i == 3 { worst } else { 0.1 }; seen],
                    pictures: 2,
                })
                .collect(),
            halved_px: vec![0.05],
        };
        let found = lights(0.5, 2).finding();
        assert!(found.starts_with("The curve holds"), "{found}");
        assert!(
            found.contains("worst kind (noise)") && found.contains("In 0 of 18"),
            "{found}"
        );
        let found = lights(7.0, 1).finding();
        assert!(found.starts_with("The curve does not hold"), "{found}");
        assert!(found.contains("In 9 of 18"), "{found}");
    }
}
