//! Whether colours that were picked are enough: their mask, judged by what it was not made from.

use std::fmt;

use super::choose::ON;
use super::seen::{MaskCurves, see, see_in};
use super::snapped;
use crate::extractor::SURER;
use crate::image::Image;
use crate::mask::mask_of;
use crate::options::{HsvRange, Mask};
use crate::scene::Curve;
use crate::vec2::Vec2;

/// So much of a mask lies along ropes; and, where a rope was meant, along ropes of its width, and so sure they are. Of 265
/// masks for wires in photographs 18 of the 103 that are wrong keep to the last two, and so do 138 of the 162 right ones.
const LEAST_ALONG: f32 = 0.85;
const LEAST_ALIKE: f32 = 0.9;
const LEAST_SURE: f32 = 0.15;
/// A curve shorter than this many widths is a piece, and from so many pieces on the mask falls into them.
const PIECE_WIDTHS: f32 = 20.0;
const MOST_PIECES: usize = 5;
/// So many curves are pieces of a few ropes, whatever their lengths.
const MOST_ROPES: usize = 8;
/// A mask of a smaller share of the picture is a highlight or a print on the rope, not the rope.
const LEAST_COVERED: f32 = 0.0015;

/// Why a mask of picked colours may be wrong: its `Display` is a whole sentence.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum PickDoubt {
    /// Nothing in the mask is a rope.
    NoRope,
    /// This share of the mask, 0 to 1, lies where no rope like the picked one is.
    Elsewhere(f32),
    /// The mask is no more than this share of the picture.
    Little(f32),
    /// The mask falls into so many pieces.
    Pieces(usize),
    /// The ropes in the mask have only this confidence, 0 to 1.
    Unsure(f32),
    /// The ropes in the mask have the first confidence, those of the automatic mask the second.
    AutomaticIsSurer([f32; 2]),
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
            PickDoubt::Unsure(confidence) => write!(
                f,
                "what the mask of these colours shows is a whole rope by {:.0} % only",
                100.0 * confidence
            )?,
            PickDoubt::AutomaticIsSurer([picked, automatic]) => write!(
                f,
                "the automatic mask is better here: its ropes have a confidence of {automatic:.2}, those in the mask of these \
                 colours {picked:.2}"
            )?,
        }
        f.write_str(
            "; look at the mask before you use it, give two more points on other places of the rope, read only the region around \
             it (roi), leave it to the automatic mask (mask = \"auto\"), or take masks from elsewhere (mask = \"external\")",
        )
    }
}

/// The judgement of a mask of picked colours.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct PickJudgement {
    /// The reason to doubt it, if there is one.
    pub doubt: Option<PickDoubt>,
    /// The mean confidence of the ropes that are meant, in the mask of these colours and in the automatic one; `None` without a rope.
    pub confidences: [Option<f32>; 2],
}

/// Judges a mask of `ranges` that were picked from `image`, at `points` if any were given.
///
/// The mask is extracted as any picture's, and what comes of it is compared with the rope that was meant, and with what the automatic
/// mask gives. Allocates.
pub fn judge_pick(image: &Image, ranges: &[HsvRange], points: &[Vec2]) -> PickJudgement {
    let points = &snapped(image, points)[..];
    let seen = see(image, ranges, points);
    let automatic = see_in(image, Mask::Auto, points).filter(|seen| seen.beside <= ON);
    let confidences = [&seen, &automatic].map(|seen| seen.as_ref().map(|seen| seen.confidence));
    let doubt = match seen {
        None => Some(PickDoubt::NoRope),
        Some(seen) => doubt(image, ranges, points, &seen).or(match confidences {
            [Some(picked), Some(automatic)] if automatic > picked + SURER => {
                Some(PickDoubt::AutomaticIsSurer([picked, automatic]))
            }
            _ => None,
        }),
    };
    PickJudgement { doubt, confidences }
}

/// The reason to doubt a mask by itself, without a look at the automatic one.
fn doubt(
    image: &Image,
    ranges: &[HsvRange],
    points: &[Vec2],
    seen: &MaskCurves,
) -> Option<PickDoubt> {
    let mask = mask_of(image, &Mask::Hsv(ranges.to_vec()));
    let all = mask.iter().filter(|&&level| level > 0).count() as f32;
    if all < LEAST_COVERED * mask.len() as f32 {
        return Some(PickDoubt::Little(all / mask.len() as f32));
    }
    // Of all, with what extraction took out of it as no rope.
    let (along, alike) = (seen.along / all, seen.alike / all);
    if along < LEAST_ALONG {
        return Some(PickDoubt::Elsewhere(1.0 - along));
    }
    if !points.is_empty() && alike < LEAST_ALIKE {
        return Some(PickDoubt::Elsewhere(1.0 - alike));
    }
    let is_piece = |curve: &&Curve| curve.length_px < PIECE_WIDTHS * curve.width_px;
    let pieces = seen.curves.iter().filter(is_piece).count();
    if pieces >= MOST_PIECES || seen.curves.len() >= MOST_ROPES {
        return Some(PickDoubt::Pieces(seen.curves.len()));
    }
    let is_unsure = !points.is_empty() && seen.confidence < LEAST_SURE;
    is_unsure.then_some(PickDoubt::Unsure(seen.confidence))
}
