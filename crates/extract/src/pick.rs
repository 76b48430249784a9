//! The colour ranges of the ropes in a picture, for a mask by colour: proposed by itself, or for the rope at a point.
//!
//! Which pixels are rope is known first, from elsewhere (`evidence`): from the automatic mask where it finds ropes, one
//! class a colour; else from a region of like colour that grows from the point (`grow`). Then a box in hue, saturation and
//! value is sought that holds the rope's pixels and keeps all others out (`range`).

mod evidence;
mod grow;
mod judge;
mod range;

use crate::image::Image;
use crate::image::unpack::Unpacker;
use crate::options::{HsvRange, Mask};
use evidence::{Evidence, Label};
use thiserror::Error;

pub use judge::{PickDoubt, doubt_pick};

/// How far beside the rope a point may lie and still mean it, in pixels.
const BESIDE_PX: f32 = 3.0;

/// The colours that were picked.
#[derive(Clone, Debug, PartialEq)]
pub struct Picked {
    /// A range for each colour of rope, that of the longest rope first.
    pub ranges: Vec<HsvRange>,
    /// How well the ranges tell what they were picked from: pixels that are rope and in range over pixels that are
    /// either (intersection over union), 0 to 1. Below some 0.8 a mask of these ranges has holes, or takes table for
    /// rope.
    pub agreement: f32,
}

/// Why no colour was picked.
#[derive(Clone, Debug, PartialEq, Error)]
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
         it from the table", .at[0], .at[1]
    )]
    NotARope {
        /// The point.
        at: [f32; 2],
    },
    /// Without a point: nothing stands out.
    #[error("no rope stands out from the table by itself: give a point on it")]
    NoRope,
}

/// Picks the colours of the ropes in `image`, or of the one at `at` (in pixels).
///
/// A rope's hue is free where it has none: black, white and gray are told by saturation and value. Allocates: this is
/// for setting up, not for every frame.
///
/// # Errors
/// When the point is outside of the image or on the table, and when no rope is found.
pub fn pick(image: &Image, at: Option<[f32; 2]>) -> Result<Picked, PickError> {
    let mut unpacker = Unpacker::default();
    let image = &unpacker.unpack(image);
    let last = [image.width() - 1, image.height() - 1];
    if let Some(at) = at {
        // Half a pixel beyond the outermost centres is still the outermost pixels. False for what is no number.
        let is_inside = |c: f32, last: usize| c >= -0.5 && c <= last as f32 + 0.5;
        if !(is_inside(at[0], last[0]) && is_inside(at[1], last[1])) {
            return Err(PickError::Outside { at, last });
        }
    }
    let evidence = evidence::of_mask(image, Mask::Auto);
    let Some(at) = at else {
        let evidence = evidence.ok_or(PickError::NoRope)?;
        return picked(image, &evidence, 0..evidence.classes).ok_or(PickError::NoRope);
    };
    if let Some(evidence) = evidence
        && let Some(class) = class_near(&evidence, at)
        && let Some(picked) = picked(image, &evidence, class..class + 1)
    {
        return Ok(picked);
    }
    let region = grow::rope(image, at)?;
    let picked = picked(image, &region, 0..1).ok_or(PickError::NotARope { at })?;
    // The table has colours too. What counts is whether they make a rope where the point is.
    evidence::of_mask(image, Mask::Hsv(picked.ranges.clone()))
        .and_then(|seen| class_near(&seen, at))
        .map(|_| picked)
        .ok_or(PickError::NotARope { at })
}

/// The ranges of these classes; `None` if none has a pixel.
fn picked(image: &Image, evidence: &Evidence, classes: std::ops::Range<usize>) -> Option<Picked> {
    let fits: Vec<range::Fit> = classes
        .filter_map(|class| range::fit(image, evidence, class))
        .collect();
    let worst = fits.iter().map(|fit| fit.agreement).reduce(f32::min)?;
    Some(Picked {
        ranges: fits.iter().map(|fit| fit.range).collect(),
        agreement: worst,
    })
}

/// The class of the rope pixel nearest to `at`, if one is near.
fn class_near(evidence: &Evidence, at: [f32; 2]) -> Option<usize> {
    let reach = BESIDE_PX.ceil() as i32;
    let (x0, y0) = (at[0].round() as i32, at[1].round() as i32);
    let mut nearest = None;
    for y in y0 - reach..=y0 + reach {
        for x in x0 - reach..=x0 + reach {
            let distance = libm::hypotf(x as f32 - at[0], y as f32 - at[1]);
            if let Some(Label::Rope(class)) = evidence.get(x, y)
                && distance <= nearest.map_or(BESIDE_PX, |(nearest, _)| nearest)
            {
                nearest = Some((distance, usize::from(class)));
            }
        }
    }
    nearest.map(|(_, class)| class)
}
