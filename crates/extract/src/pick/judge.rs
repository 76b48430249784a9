//! Whether colours that were picked are enough: their mask, judged by what it was not made from.

use std::fmt;

use super::evidence;
use crate::extractor::Extractor;
use crate::image::Image;
use crate::mask::mask_of;
use crate::options::{HsvRange, Mask, Options};
use crate::scene::Curve;
use crate::vec2::{self, Vec2};

/// So much of a mask lies along ropes, and so much of it along ropes of the width of the one that was picked: a mask of 60
/// photographed wires that holds less is wrong nine times in ten.
const LEAST_ALONG: f32 = 0.85;
const LEAST_ALIKE: f32 = 0.4;
/// Ropes are of one width by so many times.
const ALIKE: f32 = 1.67;
/// A curve shorter than this many widths is a piece, and from so many pieces on the mask falls into them.
const PIECE_WIDTHS: f32 = 20.0;
const MOST_PIECES: usize = 5;
/// So many curves are pieces of a few ropes, whatever their lengths.
const MOST_ROPES: usize = 8;
/// A mask of a smaller share of the picture is a highlight or a print on the rope, not the rope.
const LEAST_COVERED: f32 = 0.0015;
/// The most curves that are looked at.
const MOST_CURVES: usize = 24;

/// Why a mask of picked colours may be wrong: its `Display` is a whole sentence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PickDoubt {
    /// Nothing in the mask is a rope.
    NoRope,
    /// This share of the mask, 0 to 1, lies where no rope like the picked one is.
    Elsewhere(f32),
    /// The mask is no more than this share of the picture.
    Little(f32),
    /// The mask falls into so many pieces.
    Pieces(usize),
}

impl fmt::Display for PickDoubt {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            PickDoubt::NoRope => f.write_str("nothing in the mask of these colours is a rope")?,
            PickDoubt::Elsewhere(share) => write!(
                f,
                "{:.0} % of the mask lies where no rope like this one is: other things have its colours",
                100.0 * share
            )?,
            PickDoubt::Little(share) => write!(
                f,
                "the mask is only {:.2} % of the picture: a part of the rope has these colours",
                100.0 * share
            )?,
            PickDoubt::Pieces(pieces) => write!(
                f,
                "the mask falls into {pieces} pieces: the rope has more colours than these, or other things have them"
            )?,
        }
        f.write_str(
            "; look at the mask before you use it, give a point on another place of the rope, read only the region around it \
             (roi), or take masks from elsewhere (mask = \"external\")",
        )
    }
}

/// What speaks against a mask of `ranges` that were picked from `image`, at `at` if a point was given.
///
/// The mask is extracted as any picture's, and what comes of it is compared with the rope that was meant. Allocates.
pub fn doubt_pick(image: &Image, ranges: &[HsvRange], at: Option<Vec2>) -> Option<PickDoubt> {
    let options = Options {
        mask: Mask::Hsv(ranges.to_vec()),
        ropes: MOST_CURVES,
        ..Options::default()
    };
    let mut extractor = Extractor::new(options).ok()?;
    let curves = extractor.extract(image).curves.to_vec();
    let Some(longest) = curves.first() else {
        return Some(PickDoubt::NoRope);
    };
    let far_px = |curve: &Curve, at: Vec2| {
        let each = (curve.points.iter()).map(|&point| vec2::distance(point, at));
        each.fold(f32::INFINITY, f32::min)
    };
    let nearest = |at| {
        let by_distance = |a: &&Curve, b: &&Curve| far_px(a, at).total_cmp(&far_px(b, at));
        curves.iter().min_by(by_distance)
    };
    let meant = at.and_then(nearest).unwrap_or(longest);
    let is_alike = |width_px: f32| {
        let times = width_px / meant.width_px;
        times.max(1.0 / times) <= ALIKE
    };
    // With what extraction took out of it as no rope.
    let mask = mask_of(image, &Mask::Hsv(ranges.to_vec()));
    let all = mask.iter().filter(|&&level| level > 0).count() as f32;
    if all < LEAST_COVERED * mask.len() as f32 {
        return Some(PickDoubt::Little(all / mask.len() as f32));
    }
    let (mut along, mut alike) = (0usize, 0usize);
    for (curve, _) in evidence::owners(&curves, extractor.mask())
        .into_iter()
        .flatten()
    {
        along += 1;
        alike += usize::from(is_alike(curves[usize::from(curve)].width_px));
    }
    let (along, alike) = (along as f32 / all, alike as f32 / all);
    if along < LEAST_ALONG {
        return Some(PickDoubt::Elsewhere(1.0 - along));
    }
    if at.is_some() && alike < LEAST_ALIKE {
        return Some(PickDoubt::Elsewhere(1.0 - alike));
    }
    let is_piece = |curve: &&Curve| curve.length_px < PIECE_WIDTHS * curve.width_px;
    let pieces = curves.iter().filter(is_piece).count();
    (pieces >= MOST_PIECES || curves.len() >= MOST_ROPES).then_some(PickDoubt::Pieces(curves.len()))
}
