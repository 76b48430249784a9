//! The ropes of the experiments: drawn ropes with known centerlines, or ropes seen in pictures.

use lariat_capture::{RenderOptions, Source, open};
use lariat_drawn::scenes::{self, Class, SceneError, Still};
use lariat_extract::{Extractor, Options, Status};
use lariat_message::Centerlines;
use lariat_plot::spread::median;
use std::time::Instant;

use crate::polyline::{at, even, rms_apart_px};
use crate::random::of_stream;
use crate::{Effort, PaperError, Picture};

/// Points of a centerline: the paper's N.
pub(crate) const POINTS: usize = 120;
/// Kinds of drawn ropes, used in turn. The gentle ones are the ropes that `lariat` renders by
/// default; they bend by less than a full turn. The others wind.
const KINDS: [(Option<Class>, &str); 5] = [
    (None, GENTLE),
    (Some(Class::Crossings0), "no crossing"),
    (Some(Class::Crossings1), "one crossing"),
    (Some(Class::Crossings2), "two crossings"),
    (Some(Class::Crossings3), "three crossings"),
];
pub(crate) const GENTLE: &str = "gentle";
/// Number of seeds to try when no rope of a class fits the picture, and the increment between them.
const TRIALS: usize = 16;
const NEXT_SEED: u64 = 50_000;
/// Limit on the bytes of given pictures that are kept for display and comparison. The first is
/// always kept.
const KEPT_BYTES: usize = 100_000_000;
/// Period of a gentle rope's motion, s. Each moment of it gives a shape.
const MOTION_S: f64 = 60.0;
/// Minimum mean distance from the truth, in rope widths, for a centerline to count as following
/// another path. Distances are taken at the same ρ.
const ASTRAY_WIDTHS: f64 = 1.0;

/// A rope.
#[derive(Debug, Clone)]
pub(crate) struct Shape {
    /// Description of the rope.
    pub(crate) name: String,
    /// The kind of rope: one of the drawn kinds, or `picture`.
    pub(crate) kind: &'static str,
    /// N points of the reference centerline, which errors are measured against, at even steps of
    /// arc length.
    pub(crate) reference: Vec<[f64; 2]>,
    /// The same centerline in finer steps.
    pub(crate) dense: Vec<[f64; 2]>,
    /// N extracted points, in the direction of `reference`. `None` if the extractor found another
    /// rope than the true one.
    pub(crate) seen: Option<Vec<[f64; 2]>>,
    /// Width of the rope, px.
    pub(crate) width_px: f64,
    /// Index of the rope's picture, if it is kept.
    pub(crate) picture: Option<usize>,
}

impl Shape {
    /// Returns the points to fit: the extracted ones if there are any, otherwise the reference.
    pub(crate) fn points(&self) -> &[[f64; 2]] {
        self.seen.as_deref().unwrap_or(&self.reference)
    }
}

/// All ropes of a run.
#[derive(Debug, Clone)]
pub(crate) struct Shapes {
    pub(crate) all: Vec<Shape>,
    /// The pictures that are kept for display.
    pub(crate) pictures: Vec<Picture>,
    /// True if `reference` is the ground truth, false if it is the extractor's result.
    pub(crate) has_truth: bool,
    /// Number of drawn ropes that the extractor did not find correctly, or of pictures without a
    /// fully visible open rope.
    pub(crate) unseen: usize,
    /// Median time of an extraction without tracking, µs.
    pub(crate) extraction_us: f64,
}

/// Draws ropes and extracts them.
pub(crate) fn drawn(seed: u64, effort: &Effort) -> Result<Shapes, PaperError> {
    let mut shapes = Shapes::empty(true);
    let mut extractor = TimedExtractor::new()?;
    for i in 0..effort.shapes {
        let (class, kind) = KINDS[i % KINDS.len()];
        let rope_seed = seed.wrapping_mul(100_000).wrapping_add(i as u64);
        let drawing = match class {
            Some(class) => winding(class, kind, rope_seed, effort)?,
            None => gentle(kind, rope_seed, effort)?,
        };
        let reference = even(&drawing.dense, POINTS);
        let seen = extractor.look(&drawing.picture)?;
        let seen = match &seen[..] {
            [seen] => along(&seen.points, &reference, ASTRAY_WIDTHS * drawing.width_px),
            _ => None,
        };
        shapes.unseen += usize::from(seen.is_none());
        let is_kept = shapes.pictures.len() < effort.pictures;
        shapes.all.push(Shape {
            name: drawing.picture.name.clone(),
            kind,
            reference,
            dense: drawing.dense,
            seen,
            width_px: drawing.width_px,
            picture: is_kept.then_some(shapes.pictures.len()),
        });
        if is_kept {
            shapes.pictures.push(drawing.picture);
        }
    }
    shapes.extraction_us = extractor.median_us();
    Ok(shapes)
}

/// A picture of one rope with a known centerline.
struct Drawing {
    picture: Picture,
    dense: Vec<[f64; 2]>,
    width_px: f64,
}

fn winding(class: Class, kind: &str, seed: u64, effort: &Effort) -> Result<Drawing, PaperError> {
    let [width, height] = effort.size_px;
    let (mut still, seed) = still(class, seed, effort.size_px)?;
    // These classes show one rope.
    let rope = still.truth.ropes.swap_remove(0);
    Ok(Drawing {
        picture: Picture {
            name: format!("{kind}, seed {seed}"),
            width,
            height,
            rgb: still.rgb,
        },
        dense: rope.points,
        width_px: rope.width_px,
    })
}

/// Draws a picture of a class. Returns it with its seed: the given one, or the next whose rope fits
/// the picture.
pub(crate) fn still(
    class: Class,
    seed: u64,
    [width, height]: [usize; 2],
) -> Result<(Still, u64), PaperError> {
    let mut seed = seed;
    for _ in 0..TRIALS {
        match scenes::draw(class, seed, width, height) {
            // The increment is even because in one class two neighboring seeds show the same rope.
            Err(SceneError::NoRoom { .. }) => seed = seed.wrapping_add(NEXT_SEED),
            drawn => return Ok((drawn?, seed)),
        }
    }
    Ok((scenes::draw(class, seed, width, height)?, seed))
}

fn gentle(kind: &str, seed: u64, effort: &Effort) -> Result<Drawing, PaperError> {
    let [width, height] = effort.size_px;
    let options = RenderOptions {
        seed,
        width: width as u32,
        height: height as u32,
        rope_px: (height as f64 / 40.0).max(5.0),
        frame_interval_s: of_stream(seed, 0).uniform(0.0, MOTION_S),
        // Two steps for each of the N points' steps.
        truth_points: 2 * POINTS as u32 - 1,
        ..RenderOptions::default()
    };
    let mut source = open(&Source::Rendered(options))?;
    // The first frame shows time 0, the second the chosen moment.
    source.next()?;
    let mut rgb = vec![0; 3 * width * height];
    if source.next()?.is_some() {
        source.write(&mut rgb);
    }
    let mut truth = Box::new(Centerlines::EMPTY);
    source.truth(&mut truth);
    let dense: Vec<[f64; 2]> = truth
        .curves()
        .iter()
        .flat_map(|curve| &curve.points[..curve.count as usize])
        .map(|p| p.map(f64::from))
        .collect();
    Ok(Drawing {
        picture: Picture {
            name: format!("{kind}, seed {seed}"),
            width,
            height,
            rgb,
        },
        dense,
        width_px: options.rope_px,
    })
}

/// Extracts every fully visible open rope from given pictures.
pub(crate) fn pictured(
    pictures: &mut dyn Iterator<Item = Result<Picture, String>>,
    effort: &Effort,
) -> Result<Shapes, PaperError> {
    let mut shapes = Shapes::empty(false);
    let mut extractor = TimedExtractor::new()?;
    let mut count = 0;
    for picture in pictures {
        let picture = picture.map_err(PaperError::Picture)?;
        count += 1;
        let seen = extractor.look(&picture)?;
        shapes.unseen += usize::from(seen.is_empty());
        let bytes: usize = shapes.pictures.iter().map(|p| p.rgb.len()).sum();
        let fits = shapes.pictures.is_empty() || bytes + picture.rgb.len() <= KEPT_BYTES;
        let is_kept = fits && shapes.pictures.len() < effort.pictures && !seen.is_empty();
        let kept = is_kept.then_some(shapes.pictures.len());
        if kept.is_some() {
            shapes.pictures.push(picture.clone());
        }
        let several = seen.len() > 1;
        for (i, seen) in seen.into_iter().enumerate() {
            let points = seen.points;
            let dense = (0..2000).map(|k| at(&points, k as f64 / 1999.0)).collect();
            shapes.all.push(Shape {
                name: if several {
                    format!("{}, rope {}", picture.name, i + 1)
                } else {
                    picture.name.clone()
                },
                kind: "picture",
                reference: points.clone(),
                dense,
                seen: Some(points),
                width_px: seen.width_px,
                picture: kept,
            });
        }
    }
    if shapes.all.is_empty() {
        return Err(PaperError::NoRope { pictures: count });
    }
    shapes.extraction_us = extractor.median_us();
    Ok(shapes)
}

impl Shapes {
    fn empty(has_truth: bool) -> Self {
        Self {
            all: Vec::new(),
            pictures: Vec::new(),
            has_truth,
            unseen: 0,
            extraction_us: f64::NAN,
        }
    }

    /// Returns each kind of rope once, in order of appearance.
    pub(crate) fn kinds(&self) -> Vec<&'static str> {
        let mut kinds: Vec<&'static str> = Vec::new();
        for shape in &self.all {
            if !kinds.contains(&shape.kind) {
                kinds.push(shape.kind);
            }
        }
        kinds
    }

    /// Describes the reference that errors are measured against.
    pub(crate) fn measure(&self) -> &'static str {
        if self.has_truth {
            "the drawn rope's true centerline"
        } else {
            "the centerline that the skeleton gives (these pictures come without a truth)"
        }
    }
}

/// A rope as extracted.
pub(crate) struct ExtractedRope {
    pub(crate) points: Vec<[f64; 2]>,
    width_px: f64,
}

/// An extractor that treats each picture as the first, and measures the time.
pub(crate) struct TimedExtractor {
    extractor: Extractor,
    times_us: Vec<f64>,
}

impl TimedExtractor {
    pub(crate) fn new() -> Result<Self, PaperError> {
        let options = Options::default().points(POINTS);
        Ok(Self {
            extractor: Extractor::new(options)?,
            times_us: Vec::new(),
        })
    }

    /// Returns the points of every fully visible open rope in the picture.
    pub(crate) fn look(&mut self, picture: &Picture) -> Result<Vec<ExtractedRope>, PaperError> {
        let image = picture.image()?;
        self.extractor.reset();
        let began = Instant::now();
        let scene = self.extractor.extract(&image);
        self.times_us.push(1e6 * began.elapsed().as_secs_f64());
        let whole = scene
            .curves
            .iter()
            .filter(|curve| !curve.closed && curve.status == Status::Ok);
        Ok(whole
            .map(|curve| ExtractedRope {
                points: curve.points.iter().map(|p| p.map(f64::from)).collect(),
                width_px: f64::from(curve.width_px),
            })
            .collect())
    }

    fn median_us(&self) -> f64 {
        median(self.times_us.iter().copied())
    }
}

/// Returns `seen` in the direction of `reference`, or `None` if it is `astray_px` or more away.
pub(crate) fn along(
    seen: &[[f64; 2]],
    reference: &[[f64; 2]],
    astray_px: f64,
) -> Option<Vec<[f64; 2]>> {
    let reversed: Vec<[f64; 2]> = seen.iter().rev().copied().collect();
    [seen.to_vec(), reversed]
        .into_iter()
        .map(|points| (rms_apart_px(&points, reference), points))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .filter(|(apart_px, _)| *apart_px < astray_px)
        .map(|(_, points)| points)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drawn_ropes_are_seen_close_to_their_truth() {
        let shapes = drawn(5, &Effort::least()).unwrap();
        let seen: Vec<&Shape> = shapes.all.iter().filter(|s| s.seen.is_some()).collect();
        assert!(seen.len() * 4 >= shapes.all.len() * 3);
        for shape in seen {
            let off = rms_apart_px(shape.points(), &shape.reference);
            assert!(off < 1.0, "{}: {off}", shape.name);
        }
    }

    #[test]
    fn a_curve_seen_from_its_other_end_is_turned() {
        let reference: Vec<[f64; 2]> = (0..POINTS).map(|i| [i as f64, 0.0]).collect();
        let seen: Vec<[f64; 2]> = reference.iter().rev().copied().collect();
        assert_eq!(along(&seen, &reference, 1.0), Some(reference.clone()));
        let elsewhere: Vec<[f64; 2]> = reference.iter().map(|p| [p[0], 50.0]).collect();
        assert_eq!(along(&elsewhere, &reference, 1.0), None);
    }
}
