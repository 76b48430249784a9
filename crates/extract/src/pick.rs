//! The color ranges of the ropes in a picture, for a mask by color. They are found without help, or
//! for the rope at given points.
//!
//! The rope's pixels are found first, by other means (`evidence`). The automatic mask gives one
//! class for each color, if it finds ropes. Otherwise, regions of similar color grow from the
//! points (`grow`). Then a box in hue, saturation and value is sought that contains the rope's
//! colors (`palette`) and excludes all others (`range`). For given points there are many such
//! boxes. The best one is chosen by the ropes traced in its mask (`choose`, `seen`).

mod choose;
mod evidence;
mod grow;
mod judge;
mod palette;
mod range;
mod seen;

use crate::image::Image;
use crate::image::unpack::Unpacker;
use crate::options::{HsvRange, Mask};
use evidence::{Evidence, Label};
use thiserror::Error;

pub use judge::{PickDoubt, PickJudgement, judge_pick};

/// Maximum distance of a point from the rope it means, in pixels. A mouse click is not exact.
const BESIDE_PX: f32 = 10.0;
/// Maximum distance from a rope at which a point has its class, in pixels: the width of an edge.
const EDGE_PX: f32 = 3.0;

/// The picked colors.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Picked {
    /// A range for each rope color, starting with the longest rope.
    pub ranges: Vec<HsvRange>,
    /// How well the ranges separate rope from table in the picture: rope pixels in range over
    /// pixels that are rope or in range (intersection over union), 0 to 1. Below about 0.7, a mask
    /// of these ranges has holes or includes table.
    pub agreement: f32,
}

/// The reason why no color was picked.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum PickError {
    /// The point is outside of the image.
    #[error(
        "the point ({}, {}) is outside of the image, whose last pixel is ({}, {})",
        .at[0], .at[1], .last[0], .last[1]
    )]
    Outside {
        /// The point.
        at: [f32; 2],
        /// The image's bottom right pixel.
        last: [usize; 2],
    },
    /// The point is on the table.
    #[error(
        "at ({}, {}) is the table, and no rope within {BESIDE_PX} pixels: give a point on the rope", .at[0], .at[1]
    )]
    Table {
        /// The point.
        at: [f32; 2],
    },
    /// The object with the point's color is not a rope.
    #[error(
        "what has the colour at ({}, {}) is no rope: give a point on the rope. If it is one, its colour does not tell \
         it from the rest: give two more points on it, try the automatic mask, or read only the region around it (roi)",
        .at[0], .at[1]
    )]
    NotARope {
        /// The point.
        at: [f32; 2],
    },
    /// Without a point, nothing stands out.
    #[error("no rope stands out from the table by itself: give a point on it")]
    NoRope,
}

/// Picks the colors of the ropes in `image`, or of the single rope under all `points` (in pixels),
/// if any are given.
///
/// One point is enough if color separates the rope from the rest. More points add what one cannot
/// show: the other colors of a twisted rope, or its color in light and in shade. The result depends
/// on the rope and not on the exact point, so nearby points give the same result.
///
/// A rope without hue gets a range that includes all hues: saturation and value identify black,
/// white and gray. Allocates, and takes a tenth of a second or more, so it is for setup, not for
/// every frame.
///
/// # Errors
/// If a point is outside of the image or on the table, or if no rope is found.
pub fn pick(image: &Image, points: &[[f32; 2]]) -> Result<Picked, PickError> {
    let mut unpacker = Unpacker::default();
    let image = &unpacker.unpack(image);
    let last = [image.width() - 1, image.height() - 1];
    // Half a pixel beyond the outermost centers still belongs to the outermost pixels. The test is
    // false for NaN.
    let is_inside = |c: f32, last: usize| c >= -0.5 && c <= last as f32 + 0.5;
    for &at in points {
        if !(is_inside(at[0], last[0]) && is_inside(at[1], last[1])) {
            return Err(PickError::Outside { at, last });
        }
    }
    let Some(&at) = points.first() else {
        return of_all(image).ok_or(PickError::NoRope);
    };
    let points = &snapped(image, points)[..];
    if let Some(choice) = choose::ranges(image, points) {
        return Ok(Picked {
            ranges: choice.ranges,
            agreement: choice.agreement,
        });
    }
    let on_table = points.iter().find(|&&at| grow::is_table(image, at));
    Err(match on_table {
        Some(&at) => PickError::Table { at },
        None => PickError::NotARope { at },
    })
}

/// Moves each point next to a rope onto it.
fn snapped(image: &Image, points: &[[f32; 2]]) -> Vec<[f32; 2]> {
    let points = points.iter();
    points
        .map(|&at| grow::snapped(image, at, BESIDE_PX))
        .collect()
}

/// The ranges of the ropes that stand out by themselves, one for each color.
fn of_all(image: &Image) -> Option<Picked> {
    let evidence = evidence::of_mask(image, Mask::Auto)?;
    let palette = palette::Palette::new(image);
    let fits: Vec<range::Fit> = (0..evidence.classes)
        .filter_map(|class| {
            let is_rope =
                |label: &Label| matches!(label, Label::Rope(c) if usize::from(*c) == class);
            range::fit(&palette, &range::counts(&palette, &evidence, is_rope))
        })
        .collect();
    let worst = fits.iter().map(|fit| fit.agreement).reduce(f32::min)?;
    Some(Picked {
        ranges: fits.iter().map(|fit| fit.range).collect(),
        agreement: worst,
    })
}

/// The class of the rope pixel nearest to `at`, if one is near.
fn class_near(evidence: &Evidence, at: [f32; 2]) -> Option<usize> {
    let reach = EDGE_PX.ceil() as i32;
    let (x0, y0) = (at[0].round() as i32, at[1].round() as i32);
    let mut nearest = None;
    for y in y0 - reach..=y0 + reach {
        for x in x0 - reach..=x0 + reach {
            let distance = libm::hypotf(x as f32 - at[0], y as f32 - at[1]);
            if let Some(Label::Rope(class)) = evidence.get(x, y)
                && distance <= nearest.map_or(EDGE_PX, |(nearest, _)| nearest)
            {
                nearest = Some((distance, usize::from(class)));
            }
        }
    }
    nearest.map(|(_, class)| class)
}
