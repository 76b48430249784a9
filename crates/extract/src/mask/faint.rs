//! Detects a thin object on the table that is too faint for the mask: a rope of the table's color.
//!
//! In the mean over a block of pixels, noise shrinks and a rope does not. Each block is compared
//! with the mean of two blocks at some distance to its left and right, and with that of two above
//! and below. Anything wider than this distance, such as shadows or uneven light, cancels; a strip
//! remains. The spread of the bare table's blocks is estimated robustly from all blocks.

use crate::bitmap::bits::BitPlane;
use crate::bitmap::components::Components;
use crate::image::gray::GrayPlane;
use crate::statistics::median;
use lariat_portable::{Arch, NullaryFnOnce};
use std::ops::Range;

/// Blocks along the shorter side of the image: about three across a rope of a fortieth of that
/// side.
const BLOCKS: usize = 120;
/// Distance to the blocks that a block is compared with, in blocks: more than the width of a rope.
const REACH: usize = 6;
/// Minimum excess of a block over the median, in standard deviations. Noise exceeds it in about one
/// block in 10⁶.
const SPREADS: f32 = 5.0;
/// Minimum excess of a block, in levels: an image without noise is rounded to whole ones.
const LEAST: f32 = 1.0;
/// Minimum number of touching blocks that stand out, about a piece of rope. Fewer are dirt or
/// noise.
const PIECE: u32 = 16;
/// Minimum share of blocks that stand out if there is a rope. It is half the share of a rope as
/// long as the image's longer side and a hundredth of it wide.
const SHARE: f32 = 0.006;
/// Ratio of the standard deviation to the median of absolute deviations (normal distribution).
const MAD_TO_DEVIATION: f32 = 1.4826;

/// Memory of the search.
#[derive(Debug, Default)]
pub(crate) struct Faint {
    /// A row of blocks, summed down the picture.
    sums: Vec<u32>,
    blocks: Vec<f32>,
    responses: Vec<f32>,
    sorted: Vec<f32>,
    /// Blocks that stand out.
    hot: BitPlane,
}

impl Faint {
    /// Returns whether more blocks stand out than the table's noise explains.
    pub(crate) fn is_there(&mut self, difference: &GrayPlane, components: &mut Components) -> bool {
        let (columns, rows) = self.average(difference);
        self.respond(columns, rows);
        if self.responses.is_empty() {
            return false;
        }
        self.sorted.clear();
        self.sorted.extend_from_slice(&self.responses);
        let middle = median(&mut self.sorted);
        self.sorted
            .iter_mut()
            .for_each(|r| *r = (*r - middle).abs());
        let spread = MAD_TO_DEVIATION * median(&mut self.sorted);
        let least = middle + (SPREADS * spread).max(LEAST);
        let width = columns - 2 * REACH;
        self.hot.resize(width, self.responses.len() / width);
        for (i, _) in self
            .responses
            .iter()
            .enumerate()
            .filter(|&(_, &r)| r > least)
        {
            self.hot.fill(i / width, i % width, i % width + 1, true);
        }
        // With too many runs for a picture of ropes, it is not a rope either.
        if components.drop_specks(&mut self.hot, PIECE).is_err() {
            return false;
        }
        self.hot.count() as f32 > SHARE * self.responses.len() as f32
    }

    /// Computes the mean difference of each block. Returns the number of columns and rows of
    /// blocks.
    fn average(&mut self, difference: &GrayPlane) -> (usize, usize) {
        let side = (difference.width().min(difference.height()) / BLOCKS).max(2);
        let (columns, rows) = (difference.width() / side, difference.height() / side);
        self.blocks.clear();
        self.blocks.resize(columns * rows, 0.0);
        if self.blocks.is_empty() {
            return (0, 0);
        }
        self.sums.resize(columns * side, 0);
        for (j, blocks) in self.blocks.chunks_exact_mut(columns).enumerate() {
            let (rows, sums) = (j * side..(j + 1) * side, &mut self.sums[..]);
            Arch::new().dispatch(Average {
                difference,
                rows,
                sums,
                blocks,
            });
        }
        (columns, rows)
    }

    /// Computes the excess of each block over its neighbors, except for blocks at the image's
    /// edges.
    fn respond(&mut self, columns: usize, rows: usize) {
        self.responses.clear();
        let blocks = &self.blocks;
        let row = |y: usize| &blocks[y * columns..][..columns];
        for y in REACH..rows.saturating_sub(REACH) {
            let Some(inner) = columns.checked_sub(2 * REACH) else {
                return;
            };
            let (row, above, below) = (row(y), row(y - REACH), row(y + REACH));
            let (left, right) = (&row[..inner], &row[2 * REACH..]);
            let beside = left.iter().zip(right);
            let above = above[REACH..][..inner].iter().zip(&below[REACH..]);
            let places = row[REACH..].iter().zip(beside).zip(above);
            self.responses.extend(places.map(|((own, beside), above)| {
                let mean = |(a, b): (&f32, &f32)| 0.5 * (a + b);
                own - mean(beside).min(mean(above))
            }));
        }
    }
}

/// Means of a row of square blocks.
struct Average<'a> {
    difference: &'a GrayPlane,
    rows: Range<usize>,
    sums: &'a mut [u32],
    blocks: &'a mut [f32],
}

impl NullaryFnOnce for Average<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let side = self.rows.len();
        self.sums.fill(0);
        for y in self.rows {
            for (sum, &level) in self.sums.iter_mut().zip(self.difference.row(y)) {
                *sum += u32::from(level);
            }
        }
        let area = (side * side) as f32;
        for (mean, sums) in self.blocks.iter_mut().zip(self.sums.chunks_exact(side)) {
            *mean = sums.iter().sum::<u32>() as f32 / area;
        }
    }
}
