//! How far the rope's pixels are from its edge.
//!
//! The exact distance to the nearest pixel that is not rope, found row by row from the nearest on: in a window of 64
//! pixels a row, eight rows at a time, the nearest bit to either side. Rows are left out once they are farther than what
//! was found. What is outside of the image does not count as unset: a rope that leaves the image is cut, not narrow.

use crate::bits::BitPlane;
use crate::skeleton::half_width;
use crate::strips::{BLOCK, Blocks, Shape, Strips, block};

/// Pixels to either side that a window shows.
const SEEN: u32 = 32;

/// Memory of the step.
#[derive(Debug, Default)]
pub(crate) struct Clearance {
    shape: Shape,
    /// The pixels of the image that are not set.
    bare: Vec<u64>,
    /// Blocks in which some pixel is set.
    used: Blocks,
}

impl Clearance {
    /// Takes a mask.
    pub(crate) fn take(&mut self, mask: &Strips) {
        let shape = mask.shape;
        if self.shape != shape {
            self.shape = shape;
            self.bare.clear();
            self.bare.resize(shape.words(), 0);
            for strip in 0..shape.strips() {
                let rows = &mut self.bare[shape.index(strip, 0)..][..shape.height()];
                rows.fill(shape.inside(strip));
            }
        } else {
            for (at, count) in self.used.runs(&shape) {
                let (strip, y) = shape.place(at);
                let rows = count.min(shape.height() - y);
                self.bare[at..][..rows].fill(shape.inside(strip));
            }
        }
        self.used.copy_from(&mask.used);
        for (at, count) in mask.used.runs(&shape) {
            let words = self.bare[at..][..count].iter_mut();
            words
                .zip(&mask.words[at..][..count])
                .for_each(|(bare, set)| *bare &= !set);
        }
    }

    /// Distance from the center of set pixel (x, y) of `mask`, the one that was taken, to the edge: to the nearest
    /// side of an unset pixel's center, less the half pixel that the edge lies before it.
    #[inline(always)]
    pub(crate) fn half_px(&self, mask: &BitPlane, x: u16, y: u16) -> f32 {
        let (stride, y) = (self.shape.stride, usize::from(y));
        // The window's first bit is `SEEN` pixels to the left: in the empty strip, for the leftmost pixels.
        let shifted = usize::from(x) + 64 - SEEN as usize;
        let (first, shift) = (shifted / 64 * stride + BLOCK, shifted % 64);
        let mut best = u32::MAX;
        let mut near = 0;
        // Nothing outside of the windows is nearer than what is found within these rows.
        while near < SEEN as usize {
            if y >= near {
                // Rows from `near` + 8 above to `near` + 1 above.
                best = best.min(self.nearest(first + y - near - BLOCK, stride, shift, |k| {
                    near + BLOCK - k
                }));
            }
            if y + near < self.shape.height() {
                best = best.min(self.nearest(first + y + near, stride, shift, |k| near + k));
            }
            near += BLOCK;
            if best as usize <= near * near {
                return (best as f32).sqrt() - 0.5;
            }
        }
        half_width(mask, i32::from(x), y as i32)
    }

    /// The least squared distance to an unset pixel in eight rows from `at` on, `away(k)` rows away.
    #[inline(always)]
    fn nearest(
        &self,
        at: usize,
        stride: usize,
        shift: usize,
        away: impl Fn(usize) -> usize,
    ) -> u32 {
        let (left, right) = (block(&self.bare, at), block(&self.bare, at + stride));
        let mut squares = [0u32; BLOCK];
        for k in 0..BLOCK {
            let window = left[k] >> shift | right[k] << 1 << (63 - shift);
            let (before, from) = (window as u32, (window >> SEEN) as u32);
            let across = from.trailing_zeros().min(before.leading_zeros() + 1);
            let away = away(k) as u32;
            squares[k] = across * across + away * away;
        }
        squares.into_iter().fold(u32::MAX, u32::min)
    }
}
