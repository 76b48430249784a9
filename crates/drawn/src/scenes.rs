//! Still pictures of ropes with known centerlines, by class: the reference for tests of an
//! extraction.
//!
//! A [`Class`], a seed and a size determine a picture and reproduce it. The rope's edge is
//! unbiased: at half the rope's width from the centerline, half of a pixel is covered, before a
//! camera's small blur and noise. [`score()`] measures curves against the truth.

mod camera;
mod class;
mod covering;
mod ground;
mod jpeg;
mod layout;
mod leaving;
mod line;
mod paint;
mod rules;
mod score;
mod shape;
mod style;
mod thing;
mod wound;

use thiserror::Error;

use lariat_portable::SplitMix64;
use line::Line;

pub use class::Class;
pub use score::{CrossingScore, Score, SeenCrossing, SeenCurve, score};

/// Number of points of a true centerline.
const TRUE_POINTS: usize = 2000;
/// JPEG quality of the pictures of [`Class::Jpeg`].
const JPEG_QUALITY: u16 = 30;
/// Range of picture sizes, in pixels per side.
const SIDES: std::ops::RangeInclusive<usize> = 160..=4096;

/// True position of one rope.
#[derive(Debug, Clone, PartialEq)]
pub struct TrueRope {
    /// 2000 points of its centerline at equal steps of arc length, [x, y] in pixels; (0, 0) is the
    /// center of the top-left pixel. The first and the last point of an open rope are its ends. The
    /// last point of a closed rope is one step before its first.
    pub points: Vec<[f64; 2]>,
    /// Arc length of the part in the image, in pixels.
    pub length_px: f64,
    /// Width in pixels.
    pub width_px: f64,
    /// True if the rope has no ends.
    pub closed: bool,
    /// True for the first and for the last point if the rope leaves the image there. Such a point
    /// is on a line through the centers of the outermost pixels.
    pub border: [bool; 2],
}

/// A crossing of one strand over another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrueCrossing {
    /// Intersection of the centerlines, in pixels.
    pub at: [f64; 2],
    /// Angle between the strands, 0 to 90 degrees.
    pub angle_deg: f64,
    /// Index of the upper rope, and the normalized arc length of the crossing on it.
    pub over: (usize, f64),
    /// Index of the lower rope, and the normalized arc length of the crossing on it.
    pub under: (usize, f64),
}

/// A place where two strands run side by side in contact without crossing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrueTouch {
    /// For each strand: index of its rope, normalized arc length of the middle of the contact, and
    /// half of the contact's length in pixels. At both ends of the contact, more than half a width
    /// of table is visible between the strands.
    pub strands: [(usize, f64, f64); 2],
}

/// Ground truth of a picture.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Truth {
    /// All ropes.
    pub ropes: Vec<TrueRope>,
    /// All crossings.
    pub crossings: Vec<TrueCrossing>,
    /// All places where strands touch without crossing; only in the class of touching strands.
    pub touches: Vec<TrueTouch>,
}

/// A drawn picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Still {
    /// Pixels per row.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// Red, green and blue of each pixel, row by row, without padding.
    pub rgb: Vec<u8>,
    /// Share of each pixel that visible rope covers, 0 to 255: the perfect mask.
    pub mask: Vec<u8>,
    /// Ground truth of the picture.
    pub truth: Truth,
}

/// Reason why a picture cannot be drawn.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum SceneError {
    /// The size is out of range.
    #[error("a picture of {0}×{1} pixels: choose 160 to 4096 a side")]
    Size(usize, usize),
    /// No rope of the class was found that fits into the picture.
    #[error(
        "no rope of the class '{class}' with seed {seed} fits into {width}×{height} pixels: ask for a larger picture"
    )]
    NoRoom {
        /// Class of the picture.
        class: Class,
        /// Seed of the picture.
        seed: u64,
        /// Width of the picture.
        width: usize,
        /// Height of the picture.
        height: usize,
    },
}

/// Draws the picture of a class and a seed.
///
/// # Errors
/// Returns an error if the size is out of range, or too small for the class.
pub fn draw(class: Class, seed: u64, width: usize, height: usize) -> Result<Still, SceneError> {
    if !SIDES.contains(&width) || !SIDES.contains(&height) {
        return Err(SceneError::Size(width, height));
    }
    // Two seeds share a drawing and differ only in their light.
    let drawn_seed = if class == Class::LightChange {
        seed / 2
    } else {
        seed
    };
    let stream = |part: u64| SplitMix64::of_stream(drawn_seed, 0x5CE0 + 16 * class as u64 + part);
    let layout = layout::lay(
        class,
        &mut stream(0),
        [width, height].map(|side| side as f64),
    );
    let layout = layout.ok_or(SceneError::NoRoom {
        class,
        seed,
        width,
        height,
    })?;
    let ropes = layout.lines.len();
    let look = style::Style::of(class, seed, ropes, layout.width_px, &mut stream(1));
    let mut painted = paint::paint(&layout, &look, width, height);
    let size = [width, height];
    let mut seen = painted.cover.clone();
    if let Some(covering) = &layout.covering {
        covering.paint(&mut painted, &mut seen, width, &look);
    }
    let size_px = size.map(|side| side as f64);
    let ground = ground::Ground::of(class, seed, size_px, &look, &mut stream(3));
    let mut rgb = camera::expose(&painted, &look, &ground, size, &mut stream(2));
    if class == Class::Jpeg {
        jpeg::keep(&mut rgb, size, JPEG_QUALITY);
    }
    Ok(Still {
        width,
        height,
        rgb,
        mask: seen.iter().map(|share| (255.0 * share) as u8).collect(),
        truth: truth(&layout),
    })
}

/// Surface of a composed picture without ropes, three bytes per pixel. Also returns a rope color
/// that differs from the table's color.
pub(crate) fn surface(class: Class, seed: u64, [width, height]: [usize; 2]) -> (Vec<u8>, [u8; 3]) {
    let stream = |part: u64| SplitMix64::of_stream(seed, 0x5CE0 + 16 * class as u64 + part);
    let mut look = style::Style::of(class, seed, 1, 1.0, &mut stream(1));
    // The camera that films the surface adds its own noise, and there is no rope yet to cast a
    // shadow.
    (look.noise, look.grain, look.shadow) = (0.0, 0.0, 0.0);
    let size_px = [width, height].map(|side| side as f64);
    let ground = ground::Ground::of(class, seed, size_px, &look, &mut stream(3));
    let nothing = paint::Painted {
        light: vec![[0.0; 3]; width * height],
        cover: vec![0.0; width * height],
    };
    let rgb = camera::expose(&nothing, &look, &ground, [width, height], &mut stream(2));
    (rgb, look.coats[0].rgb.map(|level| level as u8))
}

fn truth(layout: &layout::Layout) -> Truth {
    let rope = |i: usize| {
        let line: &Line = &layout.lines[i];
        let [from_px, to_px] = layout.seen_px[i];
        let length_px = to_px - from_px;
        let steps = if line.closed {
            TRUE_POINTS
        } else {
            TRUE_POINTS - 1
        };
        TrueRope {
            points: (0..TRUE_POINTS)
                .map(|k| line.at(from_px + length_px * k as f64 / steps as f64))
                .collect(),
            length_px,
            width_px: layout.width_px,
            closed: line.closed,
            border: layout.border[i],
        }
    };
    let place = |line: usize, along_px: f64| {
        let [from_px, to_px] = layout.seen_px[line];
        (line, (along_px - from_px) / (to_px - from_px))
    };
    Truth {
        ropes: (0..layout.lines.len()).map(rope).collect(),
        crossings: layout
            .tops
            .iter()
            .map(|top| TrueCrossing {
                at: top.at,
                angle_deg: top.angle_deg,
                over: place(top.lines[0], top.along_px[0]),
                under: place(top.lines[1], top.along_px[1]),
            })
            .collect(),
        touches: layout
            .touches
            .iter()
            .map(|touch| TrueTouch {
                strands: [0, 1].map(|k| {
                    let (line, rho) = place(touch.lines[k], touch.along_px[k]);
                    (line, rho, touch.reach_px[k])
                }),
            })
            .collect(),
    }
}
