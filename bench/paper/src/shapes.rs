//! The ropes that the experiments are made on: drawn ones, whose centerlines are known, or those seen in pictures.

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
/// The kinds of drawn ropes, in turn. The gentle ones are those that `lariat` shows by itself; they bend by less than a
/// turn. The others wind.
const KINDS: [(Option<Class>, &str); 5] = [
    (None, GENTLE),
    (Some(Class::Crossings0), "no crossing"),
    (Some(Class::Crossings1), "one crossing"),
    (Some(Class::Crossings2), "two crossings"),
    (Some(Class::Crossings3), "three crossings"),
];
pub(crate) const GENTLE: &str = "gentle";
/// How often another seed is tried where no rope of a class fits into the picture, and which is the next.
const TRIALS: usize = 16;
const NEXT_SEED: u64 = 50_000;
/// Pictures of others are kept to be shown and compared up to so many bytes in all, but for the first.
const KEPT_BYTES: usize = 100_000_000;
/// A gentle rope's motion repeats after this many seconds: any moment of it is a shape.
const MOTION_S: f64 = 60.0;
/// A centerline this many widths off the truth, in the mean at the same ρ, went another way than the rope.
const ASTRAY_WIDTHS: f64 = 1.0;

/// One rope.
#[derive(Debug, Clone)]
pub(crate) struct Shape {
    /// Which it is, in words.
    pub(crate) name: String,
    /// The kind of rope: one of the drawn kinds, or `picture`.
    pub(crate) kind: &'static str,
    /// N points of the centerline that errors are measured against, at even steps of arc length.
    pub(crate) reference: Vec<[f64; 2]>,
    /// The same centerline in finer steps.
    pub(crate) dense: Vec<[f64; 2]>,
    /// N points as the extractor saw them, from the same end on; nothing if it saw another rope than there is.
    pub(crate) seen: Option<Vec<[f64; 2]>>,
    /// Its width, px.
    pub(crate) width_px: f64,
    /// Its picture, as an index.
    pub(crate) picture: Option<usize>,
}

impl Shape {
    /// The points to be fitted: as seen if they were.
    pub(crate) fn points(&self) -> &[[f64; 2]] {
        self.seen.as_deref().unwrap_or(&self.reference)
    }
}

/// All ropes of a run.
#[derive(Debug, Clone)]
pub(crate) struct Shapes {
    pub(crate) all: Vec<Shape>,
    /// The pictures that are kept, to be shown.
    pub(crate) pictures: Vec<Picture>,
    /// Whether `reference` is the truth; else it is what the extractor saw.
    pub(crate) has_truth: bool,
    /// Ropes or pictures in which the extractor did not see what there is, or no open rope that is wholly seen.
    pub(crate) unseen: usize,
    /// Median time of an extraction without any knowledge from before, µs.
    pub(crate) extraction_us: f64,
}

/// Draws ropes and looks at them.
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

/// A picture of one rope whose centerline is known.
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

/// A picture of a class and the seed that it has: that which was asked for, or the next that has a rope which fits.
pub(crate) fn still(
    class: Class,
    seed: u64,
    [width, height]: [usize; 2],
) -> Result<(Still, u64), PaperError> {
    let mut seed = seed;
    for _ in 0..TRIALS {
        match scenes::draw(class, seed, width, height) {
            // By an even number, as in one class two neighbouring seeds are of one rope.
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
        // Two steps for one of the N points.
        truth_points: 2 * POINTS as u32 - 1,
        ..RenderOptions::default()
    };
    let mut source = open(&Source::Rendered(options))?;
    // The first frame is of the moment 0, the second of the moment that was drawn.
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

/// Looks at pictures of ropes: every open one that is wholly seen.
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

    /// The kinds of ropes, in turn, each once.
    pub(crate) fn kinds(&self) -> Vec<&'static str> {
        let mut kinds: Vec<&'static str> = Vec::new();
        for shape in &self.all {
            if !kinds.contains(&shape.kind) {
                kinds.push(shape.kind);
            }
        }
        kinds
    }

    /// What errors are measured against, in words.
    pub(crate) fn measure(&self) -> &'static str {
        if self.has_truth {
            "the drawn rope's true centerline"
        } else {
            "the centerline that the skeleton gives (these pictures come without a truth)"
        }
    }
}

/// A rope as the extractor saw it.
pub(crate) struct ExtractedRope {
    pub(crate) points: Vec<[f64; 2]>,
    width_px: f64,
}

/// The extractor, looking at each picture as if it were the first.
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

    /// The points of every open rope in the picture that is wholly seen.
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

/// `seen` from the reference's first end on, if it goes the reference's way.
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
