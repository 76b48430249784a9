//! The colour ranges of the ropes in a picture, for a mask by colour: proposed by itself, or for the rope at a point.
//!
//! Which pixels are rope is known first, from elsewhere (`evidence`): from the automatic mask where it finds ropes, one
//! class a colour; else from a region of like colour that grows from the point. Then a box in hue, saturation and
//! value is sought that holds the rope's pixels and keeps all others out (`range`).

mod evidence;
mod grow;
mod range;

use crate::{HsvRange, Image};
use evidence::{Evidence, Label};
use thiserror::Error;

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
        "the colour at ({}, {}) goes on over {:.0} % of the image: that is no rope's. Give a point on the rope, and if \
         it is one, its colour does not tell it from the table",
        .at[0], .at[1], 100.0 * .share
    )]
    Everywhere {
        /// The point.
        at: [f32; 2],
        /// How much of the image has its colour, 0 to 1.
        share: f32,
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
    let last = [image.width() - 1, image.height() - 1];
    if let Some(at) = at {
        // Half a pixel beyond the outermost centres is still the outermost pixels. False for what is no number.
        let is_inside = |c: f32, last: usize| c >= -0.5 && c <= last as f32 + 0.5;
        if !(is_inside(at[0], last[0]) && is_inside(at[1], last[1])) {
            return Err(PickError::Outside { at, last });
        }
    }
    let evidence = evidence::automatic(image);
    let Some(at) = at else {
        let evidence = evidence.ok_or(PickError::NoRope)?;
        return Ok(ranges(image, &evidence, 0..evidence.classes));
    };
    if let Some(evidence) = &evidence
        && let Some(class) = class_near(evidence, at)
    {
        return Ok(ranges(image, evidence, class..class + 1));
    }
    let evidence = grow::region(image, at)?;
    // The rope goes on where the region does not reach: what the first range finds beside it is no table.
    let first = range::fit(image, &evidence, 0);
    let evidence = evidence.with_all_in(image, &first.range);
    Ok(ranges(image, &evidence, 0..1))
}

fn ranges(image: &Image, evidence: &Evidence, classes: std::ops::Range<usize>) -> Picked {
    let fits = classes.map(|class| range::fit(image, evidence, class));
    let fits: Vec<range::Fit> = fits.collect();
    let worst = fits.iter().map(|fit| fit.agreement).fold(1.0, f32::min);
    Picked {
        ranges: fits.iter().map(|fit| fit.range).collect(),
        agreement: worst,
    }
}

/// The class of the rope pixel nearest to `at`, if one is near.
fn class_near(evidence: &Evidence, at: [f32; 2]) -> Option<usize> {
    let reach = BESIDE_PX.ceil() as i32;
    let (x0, y0) = (at[0].round() as i32, at[1].round() as i32);
    let mut nearest = None;
    for y in y0 - reach..=y0 + reach {
        for x in x0 - reach..=x0 + reach {
            let distance = (x as f32 - at[0]).hypot(y as f32 - at[1]);
            if let Some(Label::Rope(class)) = evidence.get(x, y)
                && distance <= nearest.map_or(BESIDE_PX, |(nearest, _)| nearest)
            {
                nearest = Some((distance, usize::from(class)));
            }
        }
    }
    nearest.map(|(_, class)| class)
}
