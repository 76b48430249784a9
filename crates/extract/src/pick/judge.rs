//! Judges a mask of picked colors by evidence that it was not made from.

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

/// Minimum share of a mask along ropes. If points are given, the next two constants also apply: the
/// minimum share along ropes of the chosen one's width, and their minimum confidence. In a test of
/// 265 masks for wires in photographs, 138 of the 162 right ones and 18 of the 103 wrong ones met
/// both.
const LEAST_ALONG: f32 = 0.85;
const LEAST_ALIKE: f32 = 0.9;
const LEAST_SURE: f32 = 0.15;
/// Length in widths below which a curve is a fragment, and the number of fragments at which a mask
/// is doubted.
const PIECE_WIDTHS: f32 = 20.0;
const MOST_PIECES: usize = 5;
/// Number of curves at which they are treated as fragments of a few ropes, whatever their lengths.
const MOST_ROPES: usize = 8;
/// Minimum share of the picture. A smaller mask is a highlight or print on the rope, not the rope.
const LEAST_COVERED: f32 = 0.0015;

/// The reason why a mask of picked colors may be wrong. `Display` prints a whole sentence.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum PickDoubt {
    /// The mask does not contain a rope.
    NoRope,
    /// This share of the mask, 0 to 1, is not on ropes like the picked one.
    Elsewhere(f32),
    /// The mask is no more than this share of the picture.
    Little(f32),
    /// The mask is split into this many fragments.
    Pieces(usize),
    /// The ropes in the mask have only this confidence, 0 to 1.
    Unsure(f32),
    /// The ropes in the mask have the first confidence, and those of the automatic mask have the
    /// second.
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

/// The judgement of a mask of picked colors.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct PickJudgement {
    /// The reason to doubt it, if there is one.
    pub doubt: Option<PickDoubt>,
    /// Mean confidence of the chosen ropes in the mask of these colors, and in the automatic mask;
    /// `None` without a rope.
    pub confidences: [Option<f32>; 2],
}

/// Judges a mask of `ranges` picked from `image`, at `points` if any were given.
///
/// Extraction runs on the mask as on any picture. Its result is compared with the chosen rope, and
/// with that of the automatic mask. Allocates.
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

/// The reason to doubt a mask by itself, without comparison with the automatic one.
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
    // Shares of the whole mask, including what extraction removed because it is not a rope.
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
