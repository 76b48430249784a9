//! A stretch of the skeleton that two strands share, on top of each other or side by side: where
//! they change sides, and how their arms lie if it were straight.
//!
//! Side by side, two strands are up to two ropes wide together. In a crossing, one is on top of the
//! other, and the mask narrows to one rope. So each change of sides
//! makes one neck. Strands wound around each other have several, and strands that only touch none.

use super::arm::Arm;
use crate::skeleton::Skeleton;
use crate::vec2::{self, Vec2};

/// Maximum half-width at which a stretch is one rope wide, in half-widths plus `DOUBT_PX`. Strands
/// that meet at up to 60° without crossing reach 1.33.
const NECK_HALVES: f32 = 1.22;
/// Minimum half-width of a stretch that is definitely wider than one rope, in half-widths plus
/// `DOUBT_PX`.
const WIDE_HALVES: f32 = 1.35;
/// Part of the stretch at each end that is ignored, in half-widths.
const RIM_HALVES: f32 = 0.4;
/// Tolerance for whole pixels.
const DOUBT_PX: f32 = 0.5;
/// Minimum half-width at which whole pixels can distinguish one strand from two.
const THINNEST_HALF_PX: f32 = 2.0;
/// Maximum number of necks. Strands that change sides more often are not resolved.
const MOST: usize = 6;
/// Minimum length of a stretch that is laid straight, in half-widths. In a shorter one, strands that
/// cross at more than 67° are as wide as strands side by side.
const SHORTEST_HALVES: f32 = 1.5;
/// Minimum length of a stretch whose sides are certain, in half-widths.
const SURE_HALVES: f32 = 6.0;

/// Necks of a stretch, in its order.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Necks {
    at: [u32; MOST],
    count: usize,
    /// True if the rope is wide enough, and the narrowest place either clearly is or clearly is not a
    /// neck.
    pub(crate) are_known: bool,
}

impl Necks {
    /// Finds the necks of a stretch, given by its pixels, whose wider rope has this half-width.
    pub(crate) fn of(pixels: &[u32], skeleton: &Skeleton, half_px: f32) -> Self {
        let radius = |k: usize| skeleton.pixels[pixels[k] as usize].half_px;
        let mut necks = Self {
            at: [0; MOST],
            count: 0,
            are_known: half_px >= THINNEST_HALF_PX,
        };
        // The skeleton bends at the junctions, and its radius changes with it.
        let rim = ((RIM_HALVES * half_px) as usize)
            .max(1)
            .min(pixels.len() / 3);
        let inner = rim..pixels.len() - rim;
        let narrowest = inner.clone().map(radius).fold(f32::INFINITY, f32::min);
        let wide_px = WIDE_HALVES * half_px + DOUBT_PX;
        let neck_px = NECK_HALVES * half_px + DOUBT_PX;
        necks.are_known &= narrowest <= neck_px || narrowest >= wide_px;
        // First and last pixel of the current neck, and the number of wide pixels since.
        let (mut passed, mut wide): (Option<[usize; 2]>, usize) = (None, 0);
        for k in inner {
            if radius(k) <= neck_px {
                if wide >= rim.max(2) {
                    passed.take().into_iter().for_each(|n| necks.push(n));
                }
                wide = 0;
                passed = Some([passed.map_or(k, |[first, _]| first), k]);
            } else if radius(k) >= wide_px {
                wide += 1;
            }
        }
        passed.into_iter().for_each(|n| necks.push(n));
        necks
    }

    /// Adds the middle of a neck. Whole pixels do not show where exactly it is narrowest. More than
    /// `MOST` necks make all of them unknown.
    fn push(&mut self, [first, last]: [usize; 2]) {
        if self.count == MOST {
            self.are_known = false;
        } else {
            self.at[self.count] = ((first + last) / 2) as u32;
            self.count += 1;
        }
    }

    /// Pixel indices in the stretch at which the strands change sides.
    pub(crate) fn at(&self) -> &[u32] {
        &self.at[..self.count]
    }
}

/// Returns two arms at the ends of a stretch as if it were straight, and how certainly one strand
/// would have to change sides to join both, from 0 to 1. `None` if the stretch is short.
pub(crate) fn lay_straight(
    [mut near, mut far]: [Arm; 2],
    (pixels, length_px): (&[u32], f32),
    skeleton: &Skeleton,
    half_px: f32,
) -> Option<([Arm; 2], f32)> {
    if length_px < SHORTEST_HALVES * half_px {
        return None;
    }
    let at = |i: usize| skeleton.pixels[pixels[i] as usize].at();
    let last = pixels.len() - 1;
    let reach = ((3.0 * half_px) as usize).clamp(3, last.max(3)).min(last);
    let from_along = vec2::unit_or(vec2::sub(at(reach), at(0)), [1.0, 0.0]);
    let to_along = vec2::unit_or(vec2::sub(at(last), at(last - reach)), [1.0, 0.0]);
    let turn = |v: Vec2| {
        let (ahead, aside) = (vec2::dot(v, to_along), vec2::cross(to_along, v));
        let ahead = vec2::scale(from_along, ahead);
        vec2::add(ahead, vec2::scale(vec2::normal(from_along), aside))
    };
    let end = vec2::along(at(0), from_along, length_px);
    far.at = vec2::add(end, turn(vec2::sub(far.at, at(last))));
    far.into = turn(far.into);
    let necks = Necks::of(pixels, skeleton, half_px);
    let side = |arm: &mut Arm| vec2::cross(from_along, vec2::sub(arm.at, at(0))).signum();
    let is_same = side(&mut near) == side(&mut far);
    let changes = match necks.are_known {
        true if necks.at().len().is_multiple_of(2) != is_same => {
            (length_px / (SURE_HALVES * half_px)).min(1.0)
        }
        _ => 0.0,
    };
    Some(([near, far], changes))
}
