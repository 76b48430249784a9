//! Chooses the level that separates ropes from the table, and makes the mask from it.
//!
//! Ridler and Calvard, "Picture thresholding using an iterative selection method" (1978): the level
//! halfway between the mean below it and the mean above it, found by iteration. The mask is cut
//! somewhat below that level, so that the dimmer of several ropes stays whole. Edges are later
//! placed at half of each rope's own contrast. A multiple of the table's noise is the minimum cut,
//! so that an empty table shows no rope.

use crate::bitmap::bits::BitPlane;
use crate::bitmap::strips::{BLOCK, Shape, Strips};
use crate::image::gray::GrayPlane;
use crate::image::kernels::{Kernels, Patch};
use lariat_portable::Arch;

/// Minimum difference of rope, in median residuals of the table. Gaussian noise exceeds this about
/// once in 10⁹ pixels: the median residual of three channels is about one standard deviation.
/// Single pixels are dropped anyway.
pub(crate) const NOISE_FLOOR: f32 = 6.0;
/// Minimum difference of rope, in median residuals, if the ropes have a mean that stands out. It is
/// five standard deviations, which noise exceeds about once in 10⁶ pixels.
const FAINT_FLOOR: f32 = 4.0;
/// Minimum difference of rope, in levels: compression artifacts of JPEG and video reach this far.
pub(crate) const LEVEL_FLOOR: f32 = 14.0;
/// Position of the cut between the mean of the table and the mean of the rope.
const SHARE: f32 = 0.42;

/// Minimum cut that the table's noise allows, in levels of difference.
pub(crate) fn floor(noise: f32) -> f32 {
    (NOISE_FLOOR * noise).max(LEVEL_FLOOR)
}

/// The cut between the ropes and the table, in levels of difference.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cut {
    /// Minimum level of a rope pixel.
    pub(crate) rope: u8,
    /// Mean level of the ropes.
    pub(crate) level: u8,
    /// Share of the image that is rope at this cut.
    pub(crate) covered: f32,
}

impl Cut {
    /// Returns whether the cut was set by the ropes' levels rather than by `floor`, the table's
    /// noise.
    pub(crate) fn is_sure(&self, floor: f32) -> bool {
        f32::from(self.rope) > floor.ceil()
    }
}

/// Minimum level that is not just the table's noise.
pub(crate) fn faint(noise: f32) -> u8 {
    whole((FAINT_FLOOR * noise).max(LEVEL_FLOOR))
}

/// Number of rows, evenly spread, whose levels are taken. An image of twice as many rows uses every
/// other row. The ropes' mean changes little from row to row.
const ROWS: usize = 240;
/// Step, among those rows, between the ones that also give the table's levels.
const TABLE_STEP: usize = 16;

/// Levels of difference in some rows. Those that are not just the table's are kept one by one, the
/// others as a mean.
#[derive(Debug, Default)]
pub(crate) struct Levels {
    /// Step between the rows that count, a power of two.
    step: usize,
    /// The first `count` are this image's, in no order; the rest is unused memory.
    levels: Vec<u8>,
    count: usize,
    sum: usize,
    /// Pixels in the rows that count.
    pixels: usize,
    /// Number of the table's levels that were taken, and their sum.
    table: (usize, usize),
}

impl Levels {
    /// Clears the levels for an image of this size.
    pub(crate) fn clear(&mut self, width: usize, height: usize) {
        self.step = 1 << (height / ROWS).max(1).ilog2();
        let rows = height.div_ceil(self.step);
        self.pixels = width * rows;
        (self.count, self.sum, self.table) = (0, 0, (0, 0));
        // A kernel writes 64 at a time.
        self.levels.resize(width * rows + 64, 0);
    }

    /// Adds the levels of row `y` where `bits` are set, because these are not just the table's. A
    /// row without set bits may be left out.
    pub(crate) fn add(&mut self, kernels: &Kernels, y: usize, row: &[u8], bits: &[u64]) {
        if y & (self.step - 1) != 0 {
            return;
        }
        self.count += (kernels.collect)(row, bits, &mut self.levels[self.count..]);
    }

    /// Returns whether the table's levels are needed from row `y`.
    pub(crate) fn asks_table(&self, y: usize) -> bool {
        y & (TABLE_STEP * self.step - 1) == 0
    }

    /// Adds the table's levels of a whole row: those below `least`.
    pub(crate) fn add_table(&mut self, row: &[u8], least: u8) {
        let above = Arch::new().dispatch(Above(row, least));
        let all = Arch::new().dispatch(Above(row, 0));
        self.table.0 += all.0 - above.0;
        self.table.1 += all.1 - above.1;
    }

    /// Finishes the collection.
    pub(crate) fn close(&mut self) {
        self.sum = self.above(0).1;
    }

    /// Number and sum of the levels that are at least `from`, which must be above the table's.
    fn above(&self, from: u8) -> (usize, usize) {
        Arch::new().dispatch(Above(&self.levels[..self.count], from))
    }
}

/// Counts and sums the bytes that are at least a level.
struct Above<'a>(&'a [u8], u8);

impl lariat_portable::NullaryFnOnce for Above<'_> {
    type Output = (usize, usize);

    #[inline(always)]
    fn call(self) -> (usize, usize) {
        let Self(bytes, from) = self;
        let (mut count, mut sum) = (0, 0);
        // In chunks short enough for sums of two bytes at a time to fit into 16 bits.
        for bytes in bytes.chunks(64 * 128) {
            let (mut counts, mut sums) = ([0u8; 64], [0u16; 32]);
            let (blocks, rest) = bytes.as_chunks::<64>();
            for block in blocks {
                let mut above = [0u8; 64];
                for k in 0..64 {
                    above[k] = if block[k] >= from { block[k] } else { 0 };
                    counts[k] += u8::from(block[k] >= from);
                }
                for k in 0..32 {
                    sums[k] += u16::from(above[k]) + u16::from(above[k + 32]);
                }
            }
            count += counts.iter().map(|&n| usize::from(n)).sum::<usize>();
            sum += sums.iter().map(|&n| usize::from(n)).sum::<usize>();
            for &level in rest.iter().filter(|&&level| level >= from) {
                (count, sum) = (count + 1, sum + usize::from(level));
            }
        }
        (count, sum)
    }
}

/// Finds the cut from the levels of an image (those from [`faint`] on one by one) and the table's
/// noise.
pub(crate) fn choose(levels: &Levels, noise: f32) -> Cut {
    let means = |cut| means(levels, cut);
    let floor = floor(noise);
    let mut cut = floor;
    for _ in 0..32 {
        let (below, above) = means(cut);
        let Some(above) = above else { break };
        let next = (0.5 * (below + above)).max(floor);
        if (next - cut).abs() < 0.25 {
            break;
        }
        cut = next;
    }
    let (below, above) = means(cut);
    let above = above.unwrap_or(floor);
    let share = below + SHARE * (above - below);
    // If ropes stand well out of the noise, `SHARE` decides.
    let rope = if share >= (FAINT_FLOOR * noise).max(LEVEL_FLOOR) {
        share
    } else {
        floor
    };
    Cut {
        rope: whole(rope),
        level: whole(above),
        covered: levels.above(whole(rope)).0 as f32 / levels.pixels.max(1) as f32,
    }
}

/// The smallest level that is not below `value`.
fn whole(value: f32) -> u8 {
    value.min(255.0).ceil() as u8
}

/// Mean level below `cut` and, if there is any, from `cut` on.
fn means(levels: &Levels, cut: f32) -> (f32, Option<f32>) {
    let (count, sum) = levels.above(whole(cut));
    let above = (count > 0).then(|| sum as f32 / count as f32);
    let (pixels, total) = levels.table;
    let table = total as f32 / pixels.max(1) as f32 * (levels.pixels - levels.count) as f32;
    let below = (table + (levels.sum - sum) as f32) / (levels.pixels - count).max(1) as f32;
    (below, above)
}

/// Sets the pixels with difference ≥ cut.
pub(crate) fn apply(kernels: &Kernels, difference: &GrayPlane, cut: u8, mask: &mut BitPlane) {
    mask.resize(difference.width(), difference.height());
    for y in 0..difference.height() {
        (kernels.at_least)(difference.row(y), cut, mask.row_mut(y));
    }
}

/// As [`apply`], if all pixels that can be rope are in `faint`.
pub(crate) fn apply_within(
    kernels: &Kernels,
    difference: &GrayPlane,
    cut: u8,
    faint: &BitPlane,
    mask: &mut Strips,
) {
    let width = difference.width();
    let shape = Shape::of(faint);
    mask.resize(&shape);
    let words = shape.strips();
    let bands = faint.words().chunks(BLOCK * words).enumerate();
    for (block, band) in bands {
        let (top, rows) = (BLOCK * block, band.len() / words);
        // Most blocks are empty, so a row of blocks is tested at once.
        if band.iter().fold(0, |all, word| all | word) == 0 {
            continue;
        }
        for strip in 0..words {
            let column = band[strip..].iter().step_by(words);
            if column.fold(0, |all, word| all | word) == 0 {
                continue;
            }
            let patch = Patch {
                bytes: &difference.bytes()[top * width + 64 * strip..],
                stride: width,
                width: (width - 64 * strip).min(64),
            };
            let at = shape.index(strip, top);
            (kernels.patch_at_least)(patch, cut, &mut mask.words[at..at + rows]);
            mask.used.add(&shape, strip, top);
        }
    }
}
