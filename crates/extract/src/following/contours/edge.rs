//! One edge of a rope, in a window of sixteen pixels that runs outward from the rope.

use std::ops::Range;

/// Number of pixels of a window.
pub(super) const WINDOW: usize = 16;
/// Positions in a window at which an edge is sought. Two pixels on either side show what it
/// separates.
pub(super) const INNER: std::ops::RangeInclusive<u32> = 3..=13;
/// Minimum contrast of an edge, in levels. The noise of a camera and of coding stays below.
const LEAST_CONTRAST: i32 = 10;

/// Number of pixels at the end of a window that are ground.
const OUTER: usize = 4;
/// Minimum difference between these pixels and the rope, in levels, for the cut to be computed.
const LEAST_RISE: f32 = 14.0;

/// An edge that was found.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    /// Its position, in pixels of the window.
    pub(super) at: f32,
    /// Difference from the rope's color half-way between rope and ground.
    pub(super) level: f32,
}

/// Finds the edge nearest to its expected position. `differences` from the rope's color run from
/// the rope outward. The bits of `ground` mark pixels far from that color.
#[inline(always)]
pub(super) fn find(ground: u16, differences: &[u8; WINDOW], expected: f32) -> Option<Edge> {
    const WITHIN: u16 = (1 << (*INNER.end() + 1)) - (1 << *INNER.start());
    // Two pixels of rope before two of ground.
    let rises = ground & (ground >> 1) & !(ground << 1) & !(ground << 2) & WITHIN;
    let k = nearest(rises, expected + 0.5)?;
    let levels: [i32; 6] = std::array::from_fn(|i| differences[(k + i - 3) & 15].into());
    // On a thin rope, the farther one may be beyond its other edge.
    let inside = levels[0].min(levels[1]);
    // Doubled, to stay integers.
    let outside = levels[4] + levels[5];
    let contrast = outside - 2 * inside;
    if contrast < 2 * LEAST_CONTRAST {
        return None;
    }
    // Share of ground in the four pixels around the edge.
    let share = |level: i32| (2 * (level - inside)).max(0).min(contrast);
    let sum = share(levels[1]) + share(levels[2]) + share(levels[3]) + share(levels[4]);
    Some(Edge {
        at: k as f32 + 1.5 - sum as f32 / contrast as f32,
        level: 0.25 * (2 * inside + outside) as f32,
    })
}

/// Minimum difference that counts as ground. It is half-way between two means: that over the rope,
/// from its middle to the expected edge, and that over the end of the window. If these hardly
/// differ, it is `known`.
#[inline(always)]
pub(super) fn cut(differences: &[u8; WINDOW], [middle, expected]: [f32; 2], known: f32) -> f32 {
    let to = ((expected - 1.5).max(0.0) as usize + 1).min(WINDOW - OUTER);
    let from = (middle.max(0.0) as usize).min(to - 1);
    let inside = mean(differences, from..to);
    let outside = mean(differences, WINDOW - OUTER..WINDOW);
    if outside - inside >= LEAST_RISE {
        0.5 * (inside + outside)
    } else {
        known
    }
}

/// Mean of a range of the differences. It adds eight of them at once, as the bytes of a word.
#[inline(always)]
fn mean(differences: &[u8; WINDOW], range: Range<usize>) -> f32 {
    const EVEN: u64 = 0x00FF_00FF_00FF_00FF;
    let count = range.len();
    let some = u128::from_le_bytes(*differences) >> (8 * range.start) << (8 * (WINDOW - count));
    let pairs = [some as u64, (some >> 64) as u64].map(|word| (word & EVEN) + (word >> 8 & EVEN));
    let sum = (pairs[0] + pairs[1]).wrapping_mul(0x0001_0001_0001_0001) >> 48;
    sum as f32 / count as f32
}

/// A bit for each pixel, set if its difference is at least `cut`.
#[inline(always)]
pub(super) fn ground(differences: &[u8; WINDOW], cut: f32) -> u16 {
    const ONES: u64 = 0x0101_0101_0101_0101;
    const TOPS: u64 = 0x80 * ONES;
    let cut = u64::from(cut.clamp(1.0, 255.0).ceil() as u8) * ONES;
    let all = u128::from_le_bytes(*differences);
    let [low, high] = [all as u64, (all >> 64) as u64].map(|word| {
        // Top bit of each byte: what is left of it after subtracting the lower bits of the cut.
        let left = (word | TOPS) - (cut & !TOPS);
        let reaches = (word & !cut | !(word ^ cut) & left) & TOPS;
        ((reaches >> 7).wrapping_mul(0x0102_0408_1020_4080) >> 56) as u16
    });
    low | high << 8
}

/// Index of the set bit nearest to a position.
#[inline(always)]
fn nearest(bits: u16, place: f32) -> Option<usize> {
    if bits == 0 {
        return None;
    }
    let at = (place + 0.5).clamp(0.0, 15.0) as u32;
    let (above, below) = (bits >> at, bits << (15 - at));
    let (up, down) = (above.trailing_zeros(), below.leading_zeros());
    Some(if up <= down { at + up } else { at - down } as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn an_edge_is_found_where_it_lies(at in 4.0f32..12.0, inside in 0u8..20, contrast in 30u8..200, off in -1.5f32..1.5) {
            let share = |j: usize| (j as f32 + 0.5 - at).clamp(0.0, 1.0);
            let level = |j: usize| f32::from(inside) + f32::from(contrast) * share(j);
            let differences: [u8; WINDOW] = std::array::from_fn(|j| level(j).round() as u8);
            let half = inside + contrast / 2;
            let ground = (0..WINDOW).fold(0, |bits, j| bits | u16::from(differences[j] >= half) << j);
            let edge = find(ground, &differences, at + off).expect("there is one");
            prop_assert!((edge.at - at).abs() < 0.06, "{} {at}", edge.at);
        }

        #[test]
        fn differences_are_cut_and_averaged(differences: [u8; WINDOW], cut in 1.0f32..300.0, from in 0usize..8, count in 1usize..8) {
            let far = |i: &usize| f32::from(differences[*i]) >= cut.min(255.0).ceil();
            let expected = (0..WINDOW).filter(far).fold(0, |bits, i| bits | 1 << i);
            prop_assert_eq!(ground(&differences, cut), expected);
            let some = &differences[from..from + count];
            let sum: u32 = some.iter().map(|&d| u32::from(d)).sum();
            prop_assert_eq!(mean(&differences, from..from + count), sum as f32 / count as f32);
        }

        #[test]
        fn the_nearest_bit_is_found(bits: u16, place in -2.0f32..18.0) {
            let at = (place + 0.5).clamp(0.0, 15.0) as usize;
            let expected = (0..16).filter(|i| bits >> i & 1 == 1).min_by_key(|&i: &usize| (i.abs_diff(at), i < at));
            prop_assert_eq!(nearest(bits, place), expected);
        }
    }
}
