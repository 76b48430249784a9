//! Whether something thin lies on the table that is too faint for the mask: a rope of the table's colour.
//!
//! In the mean over a block of pixels noise shrinks and a rope does not. A block is held against the mean of the two
//! blocks a little way to either side of it, and of those above and below: what is wider than that (shadows, the light)
//! cancels, a strip stays. How far the blocks of the mere table spread is read from all of them, robustly.

use crate::bitmap::bits::BitPlane;
use crate::bitmap::components::Components;
use crate::image::gray::GrayPlane;
use crate::statistics::median;
use lariat_portable::{Arch, NullaryFnOnce};
use std::ops::Range;

/// Blocks along the shorter side of the image: some three across a rope of a fortieth of it.
const BLOCKS: usize = 120;
/// From a block to those it is held against, in blocks: farther than a rope is wide.
const REACH: usize = 6;
/// Spreads above the middle that noise does not reach: one block in some 10⁶.
const SPREADS: f32 = 5.0;
/// What stands out does so by a level at least: an image without noise is rounded to whole ones.
const LEAST: f32 = 1.0;
/// Blocks that stand out and touch, a piece of rope's worth: fewer are dirt, or noise after all.
const PIECE: u32 = 16;
/// The share of blocks that stand out when a rope is there: half of one that is as long as the image's longer side and
/// a hundredth of it wide.
const SHARE: f32 = 0.006;
/// The median of absolute deviations is this much less than the standard deviation (normal distribution).
const MAD_TO_DEVIATION: f32 = 1.4826;

/// Memory of the search.
#[derive(Debug, Default)]
pub(crate) struct Faint {
    /// A row of blocks, added up down the picture.
    sums: Vec<u32>,
    blocks: Vec<f32>,
    responses: Vec<f32>,
    sorted: Vec<f32>,
    /// The blocks that stand out.
    hot: BitPlane,
}

impl Faint {
    /// Whether more blocks stand out than the table's noise explains.
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
        // More runs than a picture of ropes has are no rope either.
        if components.drop_specks(&mut self.hot, PIECE).is_err() {
            return false;
        }
        self.hot.count() as f32 > SHARE * self.responses.len() as f32
    }

    /// The mean difference of each block; how many blocks there are each way.
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

    /// By how much each block exceeds its neighbors, those at the edges of the image left out.
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

/// The means of a row of blocks, each as wide as high.
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
