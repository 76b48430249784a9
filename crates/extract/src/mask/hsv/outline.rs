//! Coarse test for a range of colors: by the largest and the smallest of red, green and blue, and
//! by their order.
//!
//! It tells a table of another hue, or without hue, from ropes, 64 pixels at a time and without any
//! lookup.

use super::cube::STEPS;
use crate::options::HsvRange;

/// Levels in a step of the largest channel.
const STEP: usize = 256 / STEPS;
/// Span of hue in which the channels have one order, in degrees.
const SEXTANT_DEG: f32 = 60.0;
/// Margin larger than the rounding errors of a hue in degrees and of a channel in levels.
const OFF: f32 = 0.01;

/// A superset of a range that is faster to test.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outline {
    /// Minimum and maximum of the largest channel.
    pub(super) largest: [u8; 2],
    /// Minimum and maximum of the smallest channel, for each step of the largest.
    pub(super) smallest: [[u8; STEPS]; 2],
    /// Possible orders of the channels, one bit each: the sextants of hue from red on.
    pub(super) orders: u8,
}

impl Outline {
    pub(super) fn of(range: &HsvRange) -> Self {
        let [dark, light] = range.value;
        let is_of = |level: &u8| (dark..=light).contains(&(f32::from(*level) / 255.0));
        let least = (0..=u8::MAX).find(is_of).unwrap_or(u8::MAX);
        let most = (0..=u8::MAX).rev().find(is_of).unwrap_or(0);
        let [dull, bright] = range.saturation;
        let level = |step: usize, of: usize| (STEP * step + of) as f32;
        // The conversion of a float to a byte saturates.
        let smallest = [
            std::array::from_fn(|step| (level(step, 0) * (1.0 - bright) - OFF).ceil() as u8),
            std::array::from_fn(|step| (level(step, STEP - 1) * (1.0 - dull) + OFF).floor() as u8),
        ];
        let [from, to] = range.hue_deg;
        let mut orders = 0;
        for sextant in 0..6u8 {
            let first = SEXTANT_DEG * f32::from(sextant) - OFF;
            let last = first + SEXTANT_DEG + 2.0 * OFF;
            let meets = if from <= to {
                from <= last && to >= first
            } else {
                from <= last || to >= first
            };
            orders |= u8::from(meets) << sextant;
        }
        Self {
            largest: [least, most],
            smallest,
            orders,
        }
    }

    /// Returns which pixels may be in the range, one bit each. The first three masks tell where red
    /// ≥ green, green ≥ blue, and blue ≥ red. The other three tell where ≤ holds instead.
    #[inline(always)]
    #[cfg_attr(
        not(target_arch = "x86_64"),
        allow(dead_code, reason = "only there is a kernel that asks")
    )]
    pub(super) fn in_order(&self, [rg, gb, br]: [u64; 3], [gr, bg, rb]: [u64; 3]) -> u64 {
        let sextants = [rg & gb, gr & rb, gb & br, bg & gr, br & rg, rb & bg];
        let allowed = |k: usize| u64::from(self.orders >> k & 1).wrapping_neg();
        (0..6).fold(0, |all, k| all | sextants[k] & allowed(k))
    }
}

#[cfg(test)]
mod tests {
    use super::super::{contains, cube::tests::range};
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn no_color_of_a_range_lies_outside_of_its_outline(range in range(), wraps: bool, colors in prop::collection::vec(any::<[u8; 3]>(), 200)) {
            let mut range = range;
            if wraps {
                range.hue_deg.reverse();
            }
            let outline = Outline::of(&range);
            for rgb in colors.into_iter().filter(|&rgb| contains(&[range], rgb)) {
                let [r, g, b] = rgb;
                let (largest, smallest) = (r.max(g).max(b), r.min(g).min(b));
                let step = usize::from(largest) / STEP;
                prop_assert!((outline.largest[0]..=outline.largest[1]).contains(&largest), "{:?}", rgb);
                prop_assert!((outline.smallest[0][step]..=outline.smallest[1][step]).contains(&smallest), "{:?}", rgb);
                let [up, down] = [[r >= g, g >= b, b >= r], [g >= r, b >= g, r >= b]];
                prop_assert_eq!(outline.in_order(up.map(u64::from), down.map(u64::from)), 1, "{:?}", rgb);
            }
        }
    }
}
