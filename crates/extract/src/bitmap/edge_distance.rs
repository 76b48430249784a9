//! Distance of the rope's pixels from its edge.
//!
//! This is the exact distance to the nearest pixel that is not rope. The search goes row by row
//! from the nearest row, eight rows at a time, and stops at rows farther away than the best result.
//! In each row, a window of 64 pixels gives the nearest bit to either side. If the window shows
//! none, a window of 128 pixels follows.
//!
//! Pixels outside the image do not count as unset: a rope that leaves the image is cut, not narrow.
//!
//! Places too wide for both windows are hardly ropes, and a picture of something large has many of
//! them. Only some are measured, row by row. The others get the half-width that a window shows.

use super::bits::BitPlane;
use super::strips::{BLOCK, Strips};

/// Maximum half-width that is measured, in pixels.
const WIDEST_HALF: i32 = 160;
/// Number of pixels to either side that a window covers, and that a wide window covers.
const SEEN: u32 = 32;
const SEEN_WIDE: u32 = 64;
/// One in this many of the wider places is measured. The share is the same along any line at a
/// multiple of 45°.
const MEASURED: usize = 13;

/// Distances of the rows around a pixel, from eight above it.
const NEAR: [u32; 2 * BLOCK] = [8, 7, 6, 5, 4, 3, 2, 1, 0, 1, 2, 3, 4, 5, 6, 7];

/// Memory of the step.
#[derive(Debug)]
pub(crate) struct EdgeDistance {
    /// Unset pixels of the image.
    bare: Strips,
}

impl Default for EdgeDistance {
    fn default() -> Self {
        Self {
            bare: Strips::of_ground(),
        }
    }
}

impl EdgeDistance {
    /// Sets the mask.
    pub(crate) fn take(&mut self, mask: &Strips) {
        self.bare.complement(mask);
    }

    /// Distance from the center of set pixel (x, y) to the edge, in pixels: to the nearest unset
    /// pixel's center, less half a pixel. `mask` must be the mask that was taken.
    #[inline(always)]
    pub(crate) fn half_px(&self, mask: &BitPlane, x: u16, y: u16) -> f32 {
        let (stride, y) = (self.bare.shape.stride, usize::from(y));
        // The window's first bit is `SEEN` pixels to the left. For the leftmost pixels, that is in
        // the empty strip.
        let shifted = usize::from(x) + 64 - SEEN as usize;
        let (first, shift) = (shifted / 64 * stride + BLOCK, shifted % 64);
        // First the rows from eight above to seven below, which are enough on most ropes.
        let mut best = self.nearest(first + y - BLOCK, stride, shift, &NEAR);
        let mut far = BLOCK;
        // Then eight more above and eight more below. Nothing outside the windows is nearer than
        // what they show.
        while best as usize > far * far && far < SEEN as usize {
            if y >= far {
                let away: [u32; BLOCK] = std::array::from_fn(|k| (far + BLOCK - k) as u32);
                best = best.min(self.nearest(first + y - far - BLOCK, stride, shift, &away));
            }
            if y + far < self.bare.shape.height() {
                let away: [u32; BLOCK] = std::array::from_fn(|k| (far + k) as u32);
                best = best.min(self.nearest(first + y + far, stride, shift, &away));
            }
            far += BLOCK;
        }
        // A result as large as the window may be the window's end.
        if best as usize <= far * far && best < SEEN * SEEN {
            return (best as f32).sqrt() - 0.5;
        }
        self.half_px_wide(mask, x, y)
    }

    /// As [`half_px`](Self::half_px), for a pixel farther from the edge than the windows show.
    #[inline(always)]
    fn half_px_wide(&self, mask: &BitPlane, x: u16, y: usize) -> f32 {
        let stride = self.bare.shape.stride;
        // The strip to the left of the pixel's own.
        let (first, shift) = (usize::from(x) / 64 * stride + BLOCK, usize::from(x) % 64);
        let (mut best, mut far) = (u32::MAX, 0);
        while best as usize > far * far && far < SEEN_WIDE as usize {
            if y >= far {
                let away = std::array::from_fn(|k| (far + BLOCK - k) as u32);
                best = best.min(self.nearest_wide(first + y - far - BLOCK, shift, &away));
            }
            if y + far < self.bare.shape.height() {
                let away = std::array::from_fn(|k| (far + k) as u32);
                best = best.min(self.nearest_wide(first + y + far, shift, &away));
            }
            far += BLOCK;
        }
        if best as usize <= far * far && best < SEEN_WIDE * SEEN_WIDE {
            return (best as f32).sqrt() - 0.5;
        }
        match is_measured(x, y) {
            true => half_width(mask, i32::from(x), y as i32),
            false => SEEN_WIDE as f32 + 0.5,
        }
    }

    /// Smallest squared distance to an unset pixel in the rows from `at`. `away` gives the
    /// distances of these rows.
    #[inline(always)]
    fn nearest<const ROWS: usize>(
        &self,
        at: usize,
        stride: usize,
        shift: usize,
        away: &[u32; ROWS],
    ) -> u32 {
        let rows = |at: usize| -> &[u64; ROWS] {
            let rows = self.bare.words[at..].first_chunk();
            rows.expect("empty blocks lie all around the picture")
        };
        let (left, right) = (rows(at), rows(at + stride));
        let mut squares = [0u32; ROWS];
        for k in 0..ROWS {
            let window = left[k] >> shift | right[k] << 1 << (63 - shift);
            let across = nearest_bit(window as u32, (window >> SEEN) as u32);
            squares[k] = across * across + away[k] * away[k];
        }
        squares.into_iter().fold(u32::MAX, u32::min)
    }

    /// As [`nearest`](Self::nearest), for wide windows whose middle is `shift` bits into its strip.
    #[inline(always)]
    fn nearest_wide(&self, at: usize, shift: usize, away: &[u32; BLOCK]) -> u32 {
        let rows = |strip: usize| -> &[u64; BLOCK] {
            let rows = self.bare.words[at + strip * self.bare.shape.stride..].first_chunk();
            rows.expect("empty blocks lie all around the picture")
        };
        let (left, own, right) = (rows(0), rows(1), rows(2));
        let mut squares = [0u32; BLOCK];
        for k in 0..BLOCK {
            let upper = |low: u64, high: u64| low >> shift | high << 1 << (63 - shift);
            let (before, from) = (upper(left[k], own[k]), upper(own[k], right[k]));
            let across = from.trailing_zeros().min(before.leading_zeros() + 1);
            squares[k] = across * across + away[k] * away[k];
        }
        squares.into_iter().fold(u32::MAX, u32::min)
    }
}

/// Steps to the nearest set bit; 32 without one. The lowest bit of `from` is zero steps away, and
/// the highest of `before` is one step away.
///
/// Bits are counted through the exponents of floats, because few machines count bits in many lanes
/// at once.
#[inline(always)]
fn nearest_bit(before: u32, from: u32) -> u32 {
    const BIAS: u32 = 127;
    let exponent = |bits: u32| (bits.cast_signed() as f32).to_bits() << 1 >> 24;
    let after = exponent(from & from.wrapping_neg()).wrapping_sub(BIAS);
    // The shift keeps the sign bit clear. Clearing the bit below each set bit prevents rounding up
    // to the next exponent.
    let before = before >> 1;
    let before = BIAS + 31 - exponent(before & !(before >> 1));
    after.min(before).min(SEEN)
}

/// Returns whether a place too wide for the windows is measured.
fn is_measured(x: u16, y: usize) -> bool {
    (usize::from(x) + 5 * y).is_multiple_of(MEASURED)
}

/// Distance from the center of pixel (x, y) to the edge, in pixels: to the nearest unset pixel's
/// center, less half a pixel. Pixels outside the image do not count as unset: a rope that leaves
/// the image is cut, not narrow.
pub(crate) fn half_width(mask: &BitPlane, x: i32, y: i32) -> f32 {
    let mut best = WIDEST_HALF * WIDEST_HALF;
    let mut dy = 0;
    while dy * dy < best {
        for row in [y - dy, y + dy] {
            if row >= 0 && (row as usize) < mask.height() {
                let dx = nearest_unset(mask.row(row as usize), mask.width(), x);
                best = best.min(dx.saturating_mul(dx).saturating_add(dy * dy));
            }
        }
        dy += 1;
    }
    (best as f32).sqrt() - 0.5
}

/// Distance along the row from `x` to the nearest unset pixel; a large number without one.
fn nearest_unset(row: &[u64], width: usize, x: i32) -> i32 {
    const FAR: i32 = 1 << 12;
    let (start, bit) = (x as usize / 64, x as usize % 64);
    let mut right = FAR;
    for (i, &word) in row.iter().enumerate().skip(start) {
        let from = if i == start {
            u64::MAX << bit
        } else {
            u64::MAX
        };
        let unset = !word & from;
        if unset != 0 {
            let at = 64 * i + unset.trailing_zeros() as usize;
            if at < width {
                right = at as i32 - x;
            }
            break;
        }
        if i - start > WIDEST_HALF as usize / 64 {
            break;
        }
    }
    let mut left = FAR;
    for i in (0..=start).rev() {
        let to = if i == start {
            u64::MAX >> (63 - bit)
        } else {
            u64::MAX
        };
        let unset = !row[i] & to;
        if unset != 0 {
            left = x - (64 * i + 63 - unset.leading_zeros() as usize) as i32;
            break;
        }
        if start - i > WIDEST_HALF as usize / 64 {
            break;
        }
    }
    left.min(right)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_middle_of_a_bar_is_half_its_width_from_the_edge() {
        let mut mask = BitPlane::default();
        mask.resize(200, 40);
        (10..21).for_each(|y| mask.fill(y, 0, 200, true));
        assert_eq!(half_width(&mask, 100, 15), 5.5);
        assert_eq!(
            half_width(&mask, 0, 15),
            5.5,
            "the image's edge is not the rope's"
        );
        assert_eq!(half_width(&mask, 63, 12), 2.5);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]
        #[test]
        fn windows_find_what_a_search_row_by_row_finds(
            width in 1usize..160, height in 1usize..90, thick: bool,
            holes in proptest::collection::vec((0usize..160, 0usize..90), 1..40),
        ) {
            // All set except for some holes; only one hole if `thick`.
            let holes = if thick { &holes[..1] } else { &holes[..] };
            let mut rows = BitPlane::default();
            rows.resize(width, height);
            (0..height).for_each(|y| rows.fill(y, 0, width, true));
            for &(x, y) in holes.iter().filter(|&&(x, y)| x < width && y < height) {
                rows.fill(y, x, x + 1, false);
            }
            let mut mask = Strips::default();
            mask.take(&rows);
            let mut edge_distance = EdgeDistance::default();
            edge_distance.take(&mask);
            for y in (0..height).step_by(2) {
                for x in (0..width).step_by(3) {
                    let by_rows = half_width(&rows, x as i32, y as i32);
                    let found = edge_distance.half_px(&rows, x as u16, y as u16);
                    let is_seen = by_rows < SEEN_WIDE as f32 - 0.5 || is_measured(x as u16, y);
                    prop_assert_eq!(found, if is_seen { by_rows } else { SEEN_WIDE as f32 + 0.5 });
                }
            }
        }
    }
}
