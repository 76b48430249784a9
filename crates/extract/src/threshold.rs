//! Where the table ends and the rope begins, and the mask that follows.
//!
//! Ridler and Calvard, "Picture thresholding using an iterative selection method" (1978): the level
//! halfway between the means of what lies below and above it, found by iteration. The mask is cut
//! somewhat below that, so that the dimmer of several ropes stays whole (edges are placed at half of
//! each rope's own contrast later), and never below a multiple of the table's noise: an empty table
//! has no rope.

use crate::bits::BitPlane;
use crate::kernels::{Kernels, Patch};
use crate::plane::Plane;
use crate::strips::{BLOCK, Shape, Strips};

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

/// The least level that is not just the table's noise.
pub(crate) fn faint(noise: f32) -> u8 {
    whole((FAINT_FLOOR * noise).max(LEVEL_FLOOR))
}

/// At most so many pixels that are not the table's are counted, and half as many if there are: their mean is then known to
/// a thirtieth of their spread.
const COUNTED: usize = 1 << 20;
/// Rows from one whose other pixels are summed to the next.
const TABLE_STEP: usize = 32;

/// How often each level of difference occurs, those of the mere table taken together.
#[derive(Debug)]
pub(crate) struct Levels {
    pixels: usize,
    /// The mean level of the table, and how many pixels it has.
    table: f32,
    table_pixels: usize,
    /// What each pixel counts of those that are not the table's.
    weight: usize,
    /// How many of those have each level or a higher one, and the sum of their levels.
    above: [[u32; 2]; 257],
}

impl Levels {
    /// The levels of `difference`, in which those that are not the table's are the ones in `faint`, from `least` on. Where these are many,
    /// every so-many-th word of them is counted, in each row others, so that a rope is counted however it lies.
    pub(crate) fn count(difference: &Plane, faint: &BitPlane, least: u8) -> Self {
        pulp::Arch::new().dispatch(Count {
            difference,
            faint,
            least,
        })
    }

    /// The share of the pixels from a level on.
    fn share(&self, from: u8) -> f32 {
        let above = self.weight * self.above[usize::from(from)][0] as usize;
        above as f32 / self.pixels.max(1) as f32
    }
}

/// The counting, to be compiled for each kind of machine.
struct Count<'a> {
    difference: &'a Plane,
    faint: &'a BitPlane,
    least: u8,
}

impl pulp::NullaryFnOnce for Count<'_> {
    type Output = Levels;

    #[inline(always)]
    fn call(self) -> Levels {
        let pixels = self.difference.width() * self.difference.height();
        let words = self.faint.words().iter();
        let faint = words.map(|word| u64::from(word.count_ones())).sum::<u64>() as usize;
        let weight = faint.div_ceil(COUNTED).max(1).next_power_of_two();
        // Four counts, so that equal neighbors do not wait for each other's.
        let mut counts = [[0u32; 256]; 4];
        let (mut sum, mut count) = (0, 0);
        for y in 0..self.difference.height() {
            let (row, words) = (self.difference.row(y), self.faint.row(y));
            for i in every(weight, y, words.len()) {
                let pixels = &row[64 * i..];
                let mut rest = words[i];
                while rest != 0 {
                    let x = rest.trailing_zeros() as usize;
                    rest &= rest - 1;
                    counts[x % 4][usize::from(pixels[x])] += 1;
                }
            }
        }
        for y in (0..self.difference.height()).step_by(TABLE_STEP) {
            let table = |&p: &u8| u32::from(if p < self.least { p } else { 0 });
            sum += self.difference.row(y).iter().map(table).sum::<u32>();
            let others = self.faint.row(y).iter().map(|word| word.count_ones());
            count += self.difference.width() - others.sum::<u32>() as usize;
        }
        let mut above = [[0; 2]; 257];
        for level in (0..256).rev() {
            let n: u32 = counts.iter().map(|part| part[level]).sum();
            let [count, sum] = above[level + 1];
            above[level] = [count + n, sum + n * level as u32];
        }
        Levels {
            pixels,
            table: sum as f32 / count.max(1) as f32,
            table_pixels: pixels - faint,
            weight,
            above,
        }
    }
}

/// Every `step`-th of the `count` words of row `y`, in each row others; `step` is a power of two.
#[inline(always)]
fn every(step: usize, y: usize, count: usize) -> impl Iterator<Item = usize> {
    (y.wrapping_neg() & (step - 1)..count).step_by(step)
}

/// Finds the cut, given the levels of an image (those from [`faint`] on counted) and the table's noise.
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
        covered: levels.share(whole(rope)),
    }
}

/// The least level that is not below `value`.
fn whole(value: f32) -> u8 {
    value.min(255.0).ceil() as u8
}

/// The mean level below `cut` and, if there is any, from `cut` on.
fn means(levels: &Levels, cut: f32) -> (f32, Option<f32>) {
    let from = (cut.ceil() as usize).min(256);
    let ([count, sum], [all, total]) = (levels.above[from], levels.above[0]);
    let above = (count > 0).then(|| sum as f32 / count as f32);
    let (weight, table_pixels) = (levels.weight as f32, levels.table_pixels as f32);
    let pixels = table_pixels + weight * (all - count) as f32;
    let below = table_pixels * levels.table + weight * (total - sum) as f32;
    (below / pixels.max(1.0), above)
}

/// One bit a pixel: difference ≥ cut.
pub(crate) fn apply(kernels: &Kernels, difference: &Plane, cut: u8, mask: &mut BitPlane) {
    mask.resize(difference.width(), difference.height());
    for y in 0..difference.height() {
        (kernels.at_least)(difference.row(y), cut, mask.row_mut(y));
    }
}

/// The same, where all pixels that can be rope lie in `faint`.
pub(crate) fn apply_within(
    kernels: &Kernels,
    difference: &Plane,
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
