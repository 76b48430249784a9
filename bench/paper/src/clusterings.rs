//! Figure 1 of the paper: four clusterings and the skeleton on the same pictures.

mod drawing;

use lariat_extract::{Extractor, Method, Options};
use lariat_plot::spread::{Spread, mean, median};
use lariat_plot::words::{count, digits, list, px, time};
use std::time::Instant;

use crate::polyline::{apart_px, from_line_px};
use crate::shapes::{POINTS, Shape, Shapes};
use crate::{PaperError, Picture};

/// Maximum distance between a curve's points and the true points of the same ρ, in rope widths.
/// Beyond this, the order counts as wrong.
const WRONG_WIDTHS: f64 = 2.0;
/// Ratio of two methods' distances below which they count as equal.
const ALIKE: f64 = 1.1;
/// Frames of the same picture before the warm time is measured: as many as tracking needs to start.
const SETTLING: usize = 4;
/// Number of frames whose warm time is measured, and the time limit for all of a picture's frames,
/// s.
const WARM_FRAMES: usize = 9;
const WARM_S: f64 = 0.4;

/// The result of one method on one picture.
#[derive(Debug, Clone, PartialEq)]
struct Outcome {
    picture: String,
    /// Distance of each point from the reference centerline, px. Empty if no rope was found.
    distances_px: Vec<f64>,
    right_order: bool,
    cold_us: f64,
    warm_us: f64,
    /// The curves to draw.
    curves: Vec<Vec<[f64; 2]>>,
}

/// One method on all pictures.
#[derive(Debug, Clone, PartialEq)]
struct Row {
    name: &'static str,
    outcomes: Vec<Outcome>,
}

/// The results of all methods.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Clusterings {
    rows: Vec<Row>,
    pictures: usize,
    has_truth: bool,
}

/// Returns the paper's name of a method.
fn title(name: &str) -> &str {
    match name {
        KMEANS => "k-means (KMS)",
        "som" => "self-organizing map (SOM)",
        "gmm" => "Gaussian mixture (GMM)",
        "fcm" => "fuzzy c-means (FCM)",
        _ => name,
    }
}

/// Returns a short name of a method.
fn short(name: &str) -> String {
    match name {
        KMEANS => "k-means".to_owned(),
        SKELETON => SKELETON.to_owned(),
        other => other.to_uppercase(),
    }
}

const SKELETON: &str = "skeleton";
const KMEANS: &str = "kmeans";

impl Row {
    /// Returns the mean distance, as the median over the pictures.
    fn off_px(&self) -> f64 {
        let means = self
            .outcomes
            .iter()
            .map(|o| mean(o.distances_px.iter().copied()));
        median(means)
    }

    /// Returns the 95th percentile and the maximum of all distances.
    fn tail_px(&self) -> [f64; 2] {
        let all = || {
            self.outcomes
                .iter()
                .flat_map(|o| o.distances_px.iter().copied())
        };
        [Spread::of(all()).p95, all().fold(f64::NAN, f64::max)]
    }

    fn right(&self) -> usize {
        self.outcomes.iter().filter(|o| o.right_order).count()
    }

    fn cold_us(&self) -> f64 {
        median(self.outcomes.iter().map(|o| o.cold_us))
    }

    fn warm_us(&self) -> f64 {
        median(self.outcomes.iter().map(|o| o.warm_us))
    }
}

impl Clusterings {
    pub(crate) fn run(shapes: &Shapes, progress: &mut dyn FnMut(&str)) -> Result<Self, PaperError> {
        let mut rows = Vec::new();
        for (name, method) in Method::ALL {
            progress(&format!("centerlines by {name}"));
            let mut extractor = Extractor::new(Options::default().points(POINTS).method(method))?;
            let mut outcomes = Vec::new();
            for (k, picture) in shapes.pictures.iter().enumerate() {
                let ropes: Vec<&Shape> = (shapes.all.iter())
                    .filter(|shape| shape.picture == Some(k))
                    .collect();
                outcomes.push(look(&mut extractor, picture, &ropes)?);
            }
            rows.push(Row { name, outcomes });
        }
        Ok(Self {
            rows,
            pictures: shapes.pictures.len(),
            has_truth: shapes.has_truth,
        })
    }

    fn of(&self, name: &str) -> Option<&Row> {
        self.rows.iter().find(|row| row.name == name)
    }

    fn clusterings(&self) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(|row| row.name != SKELETON)
    }

    /// States whether k-means is the best of the four, as the paper claims.
    fn finding(&self) -> String {
        let mut by_distance: Vec<&Row> = self.clusterings().collect();
        by_distance.sort_by(|a, b| a.off_px().total_cmp(&b.off_px()));
        let Some(best) = by_distance.first() else {
            return String::new();
        };
        let truth = if self.has_truth {
            "the truth"
        } else {
            "the skeleton"
        };
        let kmeans_px = self.of(KMEANS).map_or(f64::NAN, Row::off_px);
        let verdict = if best.name == KMEANS {
            format!("K-means is the closest of the clusterings to {truth}, as the paper says")
        } else if kmeans_px < ALIKE * best.off_px() {
            format!(
                "K-means is all but as close to {truth} as the best of the clusterings, which the paper says it is"
            )
        } else {
            format!(
                "K-means is not the closest of the clusterings to {truth}, as the paper says it is"
            )
        };
        let told: Vec<String> = by_distance
            .iter()
            .map(|row| format!("{} {}", title(row.name), px(row.off_px())))
            .collect();
        let mut text = format!("{verdict}: in the mean {} off.", list(&told));
        let orders: Vec<String> = self
            .clusterings()
            .map(|row| format!("{} {}", title(row.name), row.right()))
            .collect();
        text += &format!(
            " The order is right in this many of {}: {}",
            count(self.pictures, "picture", "pictures"),
            list(&orders)
        );
        let Some(skeleton) = self.of(SKELETON) else {
            return text + ".";
        };
        text += &format!(", skeleton {}.", skeleton.right());
        if self.has_truth {
            let ratio = best.off_px() / skeleton.off_px();
            let place = if ratio > 1.0 {
                format!("{} times closer than the best of them", digits(ratio))
            } else {
                format!("farther than {}", title(best.name))
            };
            text += &format!(" The skeleton is {} off, {place}", px(skeleton.off_px()));
            let rival = self.of(KMEANS).unwrap_or(best);
            text += &format!(
                "; it takes {} cold and {} warm, {} {} and {}.",
                time(skeleton.cold_us()),
                time(skeleton.warm_us()),
                title(rival.name),
                time(rival.cold_us()),
                time(rival.warm_us())
            );
        }
        text
    }
}

/// Extracts a picture cold and then warm, and compares the curves with the ropes.
fn look(
    extractor: &mut Extractor,
    picture: &Picture,
    ropes: &[&Shape],
) -> Result<Outcome, PaperError> {
    let image = picture.image()?;
    extractor.reset();
    let began = Instant::now();
    let scene = extractor.extract(&image);
    let cold_us = 1e6 * began.elapsed().as_secs_f64();
    let curves: Vec<Vec<[f64; 2]>> = scene
        .curves
        .iter()
        .map(|curve| curve.points.iter().map(|p| p.map(f64::from)).collect())
        .collect();
    let mut distances_px = Vec::new();
    let mut right_order = true;
    for rope in ropes {
        let apart = |curve: &[[f64; 2]]| {
            let turned: Vec<[f64; 2]> = curve.iter().rev().copied().collect();
            most_apart_px(curve, &rope.reference).min(most_apart_px(&turned, &rope.reference))
        };
        let nearest = curves.iter().min_by(|a, b| apart(a).total_cmp(&apart(b)));
        let Some(curve) = nearest else {
            right_order = false;
            continue;
        };
        right_order &= apart(curve) <= WRONG_WIDTHS * rope.width_px;
        distances_px.extend(curve.iter().map(|&p| from_line_px(p, &rope.dense)));
    }
    Ok(Outcome {
        picture: picture.name.clone(),
        distances_px,
        right_order,
        cold_us,
        warm_us: warm_us(extractor, picture)?,
        curves,
    })
}

fn warm_us(extractor: &mut Extractor, picture: &Picture) -> Result<f64, PaperError> {
    let image = picture.image()?;
    let mut times = Vec::new();
    let began = Instant::now();
    for frame in 0..SETTLING + WARM_FRAMES {
        let frame_began = Instant::now();
        extractor.extract(&image);
        if frame >= SETTLING || began.elapsed().as_secs_f64() > WARM_S {
            times.push(1e6 * frame_began.elapsed().as_secs_f64());
        }
        if began.elapsed().as_secs_f64() > WARM_S && !times.is_empty() {
            break;
        }
    }
    Ok(median(times))
}

fn most_apart_px(a: &[[f64; 2]], b: &[[f64; 2]]) -> f64 {
    a.iter()
        .zip(b)
        .map(|(&a, &b)| apart_px(a, b))
        .fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clusterings(kmeans_px: f64, som_px: f64, skeleton_px: f64) -> Clusterings {
        let row = |name, off_px: f64, right_order| Row {
            name,
            outcomes: vec![Outcome {
                picture: "a".to_owned(),
                distances_px: vec![off_px; 3],
                right_order,
                cold_us: 3000.0,
                warm_us: 1000.0,
                curves: Vec::new(),
            }],
        };
        Clusterings {
            rows: vec![
                row("skeleton", skeleton_px, true),
                row("kmeans", kmeans_px, true),
                row("som", som_px, false),
            ],
            pictures: 1,
            has_truth: true,
        }
    }

    #[test]
    fn the_sentence_follows_the_numbers() {
        let found = clusterings(0.5, 0.9, 0.1).finding();
        assert!(found.starts_with("K-means is the closest"), "{found}");
        assert!(found.contains("k-means (KMS) 1 and self-organizing map (SOM) 0, skeleton 1."));
        assert!(found.contains("0.100 px off, 5.00 times closer"), "{found}");
        let found = clusterings(0.52, 0.5, 0.1).finding();
        assert!(found.starts_with("K-means is all but as close"), "{found}");
        let found = clusterings(0.9, 0.5, 0.7).finding();
        assert!(found.starts_with("K-means is not the closest"), "{found}");
        assert!(
            found.contains("farther than self-organizing map"),
            "{found}"
        );
    }

    #[test]
    fn a_point_in_another_place_of_the_line_is_a_wrong_order() {
        let line: Vec<[f64; 2]> = (0..POINTS).map(|i| [4.0 * i as f64, 0.0]).collect();
        let mut swapped = line.clone();
        swapped.swap(10, 60);
        assert_eq!(most_apart_px(&line, &line), 0.0);
        assert_eq!(most_apart_px(&line, &swapped), 200.0);
    }
}
