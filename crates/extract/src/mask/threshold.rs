//! Where the table ends and the rope begins, and the mask that follows.
//!
//! Ridler and Calvard, "Picture thresholding using an iterative selection method" (1978): the level
//! halfway between the means of what lies below and above it, found by iteration. The mask is cut
//! somewhat below that, so that the dimmer of several ropes stays whole (edges are placed at half of
//! each rope's own contrast later), and never below a multiple of the table's noise: an empty table
//! has no rope.

use crate::bitmap::bits::BitPlane;
use crate::bitmap::strips::{BLOCK, Shape, Strips};
use crate::image::gray::GrayPlane;
use crate::image::kernels::{Kernels, Patch};
use lariat_portable::Arch;

/// Least difference taken for rope, in median residuals of the table: noise exceeds this once in
/// some 10⁹ pixels when it is Gaussian (the median residual of three channels is about one standard
/// deviation), and single pixels are dropped anyway.
pub(crate) const NOISE_FLOOR: f32 = 6.0;
/// The same where a mean of the ropes' is known that stands out: five standard deviations, once in some 10⁶ pixels.
const FAINT_FLOOR: f32 = 4.0;
/// Least difference taken for rope, in levels: coding artefacts of JPEG and video reach this far.
pub(crate) const LEVEL_FLOOR: f32 = 14.0;
/// Where the cut lies between the mean of the table and the mean of the rope.
const SHARE: f32 = 0.42;

/// The least cut that the table's noise allows, in levels of difference.
pub(crate) fn floor(noise: f32) -> f32 {
    (NOISE_FLOOR * noise).max(LEVEL_FLOOR)
}

/// What separates the ropes from the table, in levels of difference.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cut {
    /// From here on a pixel is rope.
    pub(crate) rope: u8,
    /// The ropes' mean.
    pub(crate) level: u8,
    /// The share of the image that is rope by that.
    pub(crate) covered: f32,
}

impl Cut {
    /// Whether the ropes' levels set the cut, and not the table's noise, which sets this floor.
    pub(crate) fn is_sure(&self, floor: f32) -> bool {
        f32::from(self.rope) > floor.ceil()
    }
}

/// The least level that is not just the table's noise.
pub(crate) fn faint(noise: f32) -> u8 {
    whole((FAINT_FLOOR * noise).max(LEVEL_FLOOR))
}

/// The levels of so many rows are looked at, evenly spread: of an image of twice as many every other row. The ropes'
/// mean changes little from row to row.
const ROWS: usize = 240;
/// Of those, the rows from one whose table is looked at to the next.
const TABLE_STEP: usize = 16;

/// The levels of difference in some rows: those that are not the mere table's one by one, the others in the mean.
#[derive(Debug, Default)]
pub(crate) struct Levels {
    /// Rows of the image from one that counts to the next, a power of two.
    step: usize,
    /// The first `count` are this image's, in no order; the rest is memory.
    levels: Vec<u8>,
    count: usize,
    sum: usize,
    /// Pixels of the rows that count.
    pixels: usize,
    /// How many of the table's were, and the sum of their levels.
    table: (usize, usize),
}

impl Levels {
    /// None of an image of this size, yet.
    pub(crate) fn clear(&mut self, width: usize, height: usize) {
        self.step = 1 << (height / ROWS).max(1).ilog2();
        let rows = height.div_ceil(self.step);
        self.pixels = width * rows;
        (self.count, self.sum, self.table) = (0, 0, (0, 0));
        // A kernel writes 64 at a time.
        self.levels.resize(width * rows + 64, 0);
    }

    /// Takes up those of row `y`, which are not just the table's where `bits` are set, and only looked at there: a row
    /// without any may be left out.
    pub(crate) fn add(&mut self, kernels: &Kernels, y: usize, row: &[u8], bits: &[u64]) {
        if y & (self.step - 1) != 0 {
            return;
        }
        self.count += (kernels.collect)(row, bits, &mut self.levels[self.count..]);
    }

    /// Whether the table's are asked for in row `y`.
    pub(crate) fn asks_table(&self, y: usize) -> bool {
        y & (TABLE_STEP * self.step - 1) == 0
    }

    /// Takes up those of a whole row that are the table's: below `least`.
    pub(crate) fn add_table(&mut self, row: &[u8], least: u8) {
        let above = Arch::new().dispatch(Above(row, least));
        let all = Arch::new().dispatch(Above(row, 0));
        self.table.0 += all.0 - above.0;
        self.table.1 += all.1 - above.1;
    }

    /// That were all.
    pub(crate) fn close(&mut self) {
        self.sum = self.above(0).1;
    }

    /// How many of the levels are not below `from`, which is not the table's, and their sum.
    fn above(&self, from: u8) -> (usize, usize) {
        Arch::new().dispatch(Above(&self.levels[..self.count], from))
    }
}

/// How many bytes are not below a level, and their sum.
struct Above<'a>(&'a [u8], u8);

impl lariat_portable::NullaryFnOnce for Above<'_> {
    type Output = (usize, usize);

    #[inline(always)]
    fn call(self) -> (usize, usize) {
        let Self(bytes, from) = self;
        let (mut count, mut sum) = (0, 0);
        // As long as sums of two bytes at a time fit into 16 bits.
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

/// Finds the cut, given the levels of an image (those from [`faint`] on one by one) and the table's noise.
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
    // Where ropes stand well out of the noise, their share decides.
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

/// The least level that is not below `value`.
fn whole(value: f32) -> u8 {
    value.min(255.0).ceil() as u8
}

/// The mean level below `cut` and, if there is any, from `cut` on.
fn means(levels: &Levels, cut: f32) -> (f32, Option<f32>) {
    let (count, sum) = levels.above(whole(cut));
    let above = (count > 0).then(|| sum as f32 / count as f32);
    let (pixels, total) = levels.table;
    let table = total as f32 / pixels.max(1) as f32 * (levels.pixels - levels.count) as f32;
    let below = (table + (levels.sum - sum) as f32) / (levels.pixels - count).max(1) as f32;
    (below, above)
}

/// One bit a pixel: difference ≥ cut.
pub(crate) fn apply(kernels: &Kernels, difference: &GrayPlane, cut: u8, mask: &mut BitPlane) {
    mask.resize(difference.width(), difference.height());
    for y in 0..difference.height() {
        (kernels.at_least)(difference.row(y), cut, mask.row_mut(y));
    }
}

/// The same, where all pixels that can be rope lie in `faint`.
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
        // Most blocks hold nothing: a row of them at a time is asked whether they do.
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
