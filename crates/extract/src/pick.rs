//! The colour ranges of the ropes in a picture, for a mask by colour: proposed by itself, or for the rope at a point.
//!
//! Which pixels are rope is known first, from elsewhere (`evidence`): from the automatic mask where it finds ropes, one
//! class a colour; or from regions of like colour that grow from the points (`grow`). Then a box in hue, saturation and
//! value is sought that holds the rope's colours (`palette`) and keeps all others out (`range`). At points there are many such
//! boxes, of which the best is chosen by what is traced in its mask (`choose`, `seen`).

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

/// Distance from a rope at which a point still means it, in pixels: a mouse is not a needle.
const BESIDE_PX: f32 = 10.0;
/// Distance from a rope at which its class is the point's, in pixels: the width of an edge.
const EDGE_PX: f32 = 3.0;

/// The colours that were picked.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Picked {
    /// A range for each colour of rope, that of the longest rope first.
    pub ranges: Vec<HsvRange>,
    /// How well the ranges tell what they were picked from: pixels that are rope and in range over pixels that are
    /// either (intersection over union), 0 to 1. Below some 0.7 a mask of these ranges has holes, or takes table for
    /// rope.
    pub agreement: f32,
}

/// Why no colour was picked.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum PickError {
    /// The point is no place in the image.
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
    /// The point shows the table.
    #[error(
        "at ({}, {}) is the table, and no rope within {BESIDE_PX} pixels: give a point on the rope", .at[0], .at[1]
    )]
    Table {
        /// The point.
        at: [f32; 2],
    },
    /// What has the point's colour is no rope.
    #[error(
        "what has the colour at ({}, {}) is no rope: give a point on the rope. If it is one, its colour does not tell \
         it from the rest: give two more points on it, try the automatic mask, or read only the region around it (roi)",
        .at[0], .at[1]
    )]
    NotARope {
        /// The point.
        at: [f32; 2],
    },
    /// Without a point: nothing stands out.
    #[error("no rope stands out from the table by itself: give a point on it")]
    NoRope,
}

/// Picks the colours of the ropes in `image`, or of the one that all `points` (in pixels) lie on, if there are any.
///
/// One point is enough where colour tells the rope from the rest; more say what one cannot: the other colours of a twisted
/// rope, or its colour in light and in shade. The answer is that of the rope, not of the point: neighbours get the same.
///
/// A rope's hue is free where it has none: black, white and gray are told by saturation and value. Allocates, and takes
/// from a tenth of a second to some: this is for setting up, not for every frame.
///
/// # Errors
/// When a point is outside of the image or on the table, and when no rope is found.
pub fn pick(image: &Image, points: &[[f32; 2]]) -> Result<Picked, PickError> {
    let mut unpacker = Unpacker::default();
    let image = &unpacker.unpack(image);
    let last = [image.width() - 1, image.height() - 1];
    // Half a pixel beyond the outermost centres is still the outermost pixels. False for what is no number.
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

/// Moves each point that lies next to a rope onto it.
fn snapped(image: &Image, points: &[[f32; 2]]) -> Vec<[f32; 2]> {
    let points = points.iter();
    points
        .map(|&at| grow::snapped(image, at, BESIDE_PX))
        .collect()
}

/// The ranges of the ropes that stand out by themselves, one for each colour.
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
