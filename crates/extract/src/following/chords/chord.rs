//! A chord: where a row or a column of pixels runs through a rope.
//!
//! Across a straight rope the middle of any chord lies on its centerline, whatever the angle, so that pixels need not be
//! interpolated but along the row or column itself.

use super::profile::{Lanes, Stretch, WORD};
use crate::image::Image;
use crate::mask::background::Background;
use crate::vec2::Vec2;

/// The most pixels that are read across a rope.
pub(super) const MOST: usize = 2 * WORD;
/// The part of a chord, about its middle, that the rope's contrast is read from.
pub(super) const CORE: f32 = 0.4;

/// Where a chord is looked for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Where {
    /// Where the rope's middle is expected, in pixels.
    pub(super) at: Vec2,
    /// 0: along the row, 1: down the column.
    pub(super) axis: usize,
    /// Pixels that are read, a multiple of [`super::profile::BLOCK`].
    pub(super) span: usize,
    /// The difference at the rope's edges.
    pub(super) level: f32,
}

/// What was found.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chord {
    /// The middle.
    pub(super) at: Vec2,
    /// From edge to edge along the row or column.
    pub(super) length_px: f32,
    /// The mean difference in the middle of it.
    pub(super) contrast: f32,
}

/// What chords are read with and from.
pub(super) struct Reader<'a> {
    pub(super) image: &'a Image<'a>,
    pub(super) background: &'a Background,
}

impl Reader<'_> {
    /// The chord at a place; nothing where the rope does not begin and end within the span.
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
        // Between the last pixel without and the first within; both exist.
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

    /// Where along the axis the pixels about a place begin, and their row or column. Nothing where the image ends before.
    #[inline(always)]
    fn place(&self, of: &Where) -> Option<(usize, usize)> {
        let size = [self.image.width(), self.image.height()];
        // Rounded where they are not negative.
        let line = of.at[1 - of.axis] + 0.5;
        let from = of.at[of.axis] + 0.5 - (of.span / 2) as f32;
        let last = size[of.axis] as f32 - of.span as f32;
        let holds = line >= 0.0 && line < size[1 - of.axis] as f32 && from >= 0.0 && from <= last;
        // Two pixels share their color in some formats.
        holds.then_some((from as usize & !1, line as usize))
    }
}

/// The run of set bits that holds bit `at` or lies nearest to it, among the first `count` bits: its first, and the one
/// after its last. Nothing if it touches the ends.
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
