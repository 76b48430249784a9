//! A chord: where a row or a column of pixels runs through a rope.
//!
//! On a straight rope, the middle of any chord is on the centerline, at any angle. Pixels therefore
//! need interpolation along the row or column only.

use super::profile::{Lanes, Stretch, WORD};
use crate::image::Image;
use crate::mask::background::Background;
use crate::vec2::Vec2;

/// Maximum number of pixels read across a rope.
pub(super) const MOST: usize = 2 * WORD;
/// Share of a chord, around its middle, over which the contrast is measured.
pub(super) const CORE: f32 = 0.4;

/// Search range of a chord.
#[derive(Clone, Copy, Debug)]
pub(super) struct Where {
    /// Expected position of the rope's middle, in pixels.
    pub(super) at: Vec2,
    /// 0 along a row, 1 down a column.
    pub(super) axis: usize,
    /// Number of pixels to read, a multiple of [`super::profile::BLOCK`].
    pub(super) span: usize,
    /// Difference at the rope's edges.
    pub(super) level: f32,
}

/// A chord that was found.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chord {
    /// Its middle.
    pub(super) at: Vec2,
    /// Length from edge to edge along the row or column.
    pub(super) length_px: f32,
    /// Mean difference in its middle.
    pub(super) contrast: f32,
}

/// Inputs for reading chords.
pub(super) struct Reader<'a> {
    pub(super) image: &'a Image<'a>,
    pub(super) background: &'a Background,
}

impl Reader<'_> {
    /// The chord at a place, or `None` if the rope does not start and end within the span.
    #[inline(always)]
    pub(super) fn chord(&self, lanes: impl Lanes, of: &Where) -> Option<Chord> {
        let (from, line) = self.place(of)?;
        let mut first = [line; 2];
        first[of.axis] = from;
        let mut middle = first;
        middle[of.axis] += of.span / 2;
        let [x, y] = middle.map(|at| [at as f32]);
        let mut table = [0];
        self.background.at_all(&x, &y, &mut table);
        let mut stretch = Stretch {
            image: self.image,
            from: first,
            axis: of.axis,
            count: of.span.min(WORD),
            tables: [table[0]; _],
            cut: of.level.ceil().clamp(1.0, 255.0) as u8,
        };
        let mut profile = [[0u8; WORD]; 2];
        let mut set = u128::from(lanes.read(&stretch, &mut profile[0]));
        if of.span > WORD {
            stretch.from[of.axis] += WORD;
            stretch.count = of.span - WORD;
            set |= u128::from(lanes.read(&stretch, &mut profile[1])) << WORD;
        }
        let profile = profile.as_flattened();
        let middle = of.at[of.axis] - from as f32;
        let [first, end] = run(set, of.span, (middle + 0.5) as usize)?;
        // Interpolates between the last pixel outside and the first inside. Both exist.
        let edge = |without: usize, within: usize| {
            let [low, high] = [without, within].map(|i| f32::from(profile[i]));
            let part = (high - of.level) / (high - low).max(1.0);
            within as f32 + part * (without as f32 - within as f32)
        };
        let (left, right) = (edge(first - 1, first), edge(end, end - 1));
        let length_px = right - left;
        let rim = (0.5 * (1.0 - CORE) * length_px) as usize;
        let core = &profile[(first + rim).min(end - 1)..(end - rim).max(first + rim + 1).min(end)];
        let sum: u32 = core.iter().map(|&p| u32::from(p)).sum();
        let mut at = [line as f32; 2];
        at[of.axis] = from as f32 + 0.5 * (left + right);
        Some(Chord {
            at,
            length_px,
            contrast: sum as f32 / core.len().max(1) as f32,
        })
    }

    /// Start of the span along the axis, and its row or column. `None` if it exceeds the image.
    #[inline(always)]
    fn place(&self, of: &Where) -> Option<(usize, usize)> {
        let size = [self.image.width(), self.image.height()];
        // The casts below round to nearest, as `line` and `from` are not negative then.
        let line = of.at[1 - of.axis] + 0.5;
        let from = of.at[of.axis] + 0.5 - (of.span / 2) as f32;
        let last = size[of.axis] as f32 - of.span as f32;
        let holds = line >= 0.0 && line < size[1 - of.axis] as f32 && from >= 0.0 && from <= last;
        // Two pixels share their color in some formats.
        holds.then_some((from as usize & !1, line as usize))
    }
}

/// The run of set bits that includes bit `at` or is nearest to it, among the first `count` bits:
/// its first bit, and the one after its last. `None` if it touches either end.
#[inline(always)]
fn run(set: u128, count: usize, at: usize) -> Option<[usize; 2]> {
    let at = at.min(count - 1);
    let above = set >> at;
    let below = set << (127 - at);
    if above == 0 && below == 0 {
        return None;
    }
    let (up, down) = (above.trailing_zeros(), below.leading_zeros());
    let inside = if above != 0 && (below == 0 || up <= down) {
        at + up as usize
    } else {
        at - down as usize
    };
    let end = inside + (!(set >> inside)).trailing_zeros() as usize;
    let unset_below = !(set << (127 - inside));
    let first = inside + 1 - (unset_below.leading_zeros() as usize).min(inside + 1);
    (first > 0 && end < count).then_some([first, end])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_run_is_the_one_that_holds_the_bit_or_the_nearest(
            bits in prop::collection::vec(prop::bool::weighted(0.6), 8..=MOST), at in 0..MOST,
        ) {
            let at = at.min(bits.len() - 1);
            let set = bits.iter().rev().fold(0u128, |set, &bit| set << 1 | u128::from(bit));
            let nearest = (0..bits.len()).filter(|&i| bits[i]).min_by_key(|&i| (i.abs_diff(at), i < at));
            let expected = nearest.map(|inside| {
                let first = (0..inside).rev().take_while(|&i| bits[i]).last().unwrap_or(inside);
                let last = (inside..bits.len()).take_while(|&i| bits[i]).last().unwrap_or(inside);
                [first, last + 1]
            });
            let expected = expected.filter(|&[first, end]| first > 0 && end < bits.len());
            prop_assert_eq!(run(set, bits.len(), at), expected);
        }
    }
}
