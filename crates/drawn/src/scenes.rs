//! Still pictures of ropes whose centerlines are known, class by class: what an extraction is held against.
//!
//! A picture is a [`Class`], a seed and a size; the same three make the same picture again. The rope's edge is
//! unbiased: at half its width from the centerline half of a pixel is covered, before a camera's small blur and noise.
//! [`score()`] measures curves against the truth.

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

/// Points of a true centerline.
const TRUE_POINTS: usize = 2000;
/// What a picture of the class about it is kept with.
const JPEG_QUALITY: u16 = 30;
/// Sizes of pictures, in pixels a side.
const SIDES: std::ops::RangeInclusive<usize> = 160..=4096;

/// One rope as it truly lies.
#[derive(Debug, Clone, PartialEq)]
pub struct TrueRope {
    /// 2000 points of its centerline at equal steps of arc length, [x, y] in pixels; (0, 0) is the centre of the
    /// top-left pixel. An open rope's first and last are its ends; a closed one's last is one step before its first.
    pub points: Vec<[f64; 2]>,
    /// Arc length of what is in the image.
    pub length_px: f64,
    /// Width.
    pub width_px: f64,
    /// Whether it has no ends.
    pub closed: bool,
    /// Whether the first and the last point lie where the rope leaves the image: on the lines through the centres of
    /// its outermost pixels.
    pub border: [bool; 2],
}

/// A place where a strand lies over a strand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrueCrossing {
    /// Where the centerlines cross.
    pub at: [f64; 2],
    /// Angle between the strands, 0 to 90 degrees.
    pub angle_deg: f64,
    /// Index of the upper rope, and where along it as normalized arc length.
    pub over: (usize, f64),
    /// Index of the lower rope, likewise.
    pub under: (usize, f64),
}

/// A place where two strands run side by side in contact, and do not cross.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrueTouch {
    /// Of each strand: its rope, the middle of the stretch as normalized arc length, and half of the stretch's length
    /// in pixels. At its ends more than half a width of table shows between the strands.
    pub strands: [(usize, f64, f64); 2],
}

/// What is true of a picture.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Truth {
    /// Every rope.
    pub ropes: Vec<TrueRope>,
    /// Every crossing.
    pub crossings: Vec<TrueCrossing>,
    /// Every place where strands touch without crossing, in the class that is about it.
    pub touches: Vec<TrueTouch>,
}

/// A drawn picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Still {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Red, green and blue of each pixel, row by row, without padding.
    pub rgb: Vec<u8>,
    /// How much of each pixel is a rope that is seen, 0 to 255: what a mask would be that knows all.
    pub mask: Vec<u8>,
    /// What it shows.
    pub truth: Truth,
}

/// Why a picture cannot be drawn.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum SceneError {
    /// The size is out of range.
    #[error("a picture of {0}×{1} pixels: choose 160 to 4096 a side")]
    Size(usize, usize),
    /// No rope of the class was found that fits.
    #[error(
        "no rope of the class '{class}' with seed {seed} fits into {width}×{height} pixels: ask for a larger picture"
    )]
    NoRoom {
        /// Of the picture.
        class: Class,
        /// Of the picture.
        seed: u64,
        /// Of the picture.
        width: usize,
        /// Of the picture.
        height: usize,
    },
}

/// Draws the picture of a class and a seed.
///
/// # Errors
/// If the size is out of range, or too small for what the class asks.
pub fn draw(class: Class, seed: u64, width: usize, height: usize) -> Result<Still, SceneError> {
    if !SIDES.contains(&width) || !SIDES.contains(&height) {
        return Err(SceneError::Size(width, height));
    }
    // Of two seeds that differ in the light alone, one draws both.
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

/// The surface of a composed picture without its ropes, three bytes a pixel, and the color of a rope that is not the table's.
pub(crate) fn surface(class: Class, seed: u64, [width, height]: [usize; 2]) -> (Vec<u8>, [u8; 3]) {
    let stream = |part: u64| SplitMix64::of_stream(seed, 0x5CE0 + 16 * class as u64 + part);
    let mut look = style::Style::of(class, seed, 1, 1.0, &mut stream(1));
    // The camera that films it has its own, and no rope lies on it yet.
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
