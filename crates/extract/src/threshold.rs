//! Where the table ends and the rope begins, and the mask that follows.
//!
//! Ridler and Calvard, "Picture thresholding using an iterative selection method" (1978): the level
//! halfway between the means of what lies below and above it, found by iteration. The mask is cut
//! somewhat below that, so that the dimmer of several ropes stays whole (edges are placed at half of
//! each rope's own contrast later), and never below a multiple of the table's noise: an empty table
//! has no rope.

use crate::bits::BitPlane;
use crate::kernels::Kernels;
use crate::plane::Plane;

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

/// How often each level of difference occurs, those of the mere table taken together.
#[derive(Debug)]
pub(crate) struct Levels {
    /// The sum of all levels.
    pub(crate) total: u64,
    pixels: usize,
    /// Of the levels that are not the table's. Four counts, so that equal neighbors do not wait for each other's.
    counts: [[u32; 256]; 4],
}

impl Levels {
    /// Those of so many pixels, none of which is counted yet.
    pub(crate) fn new(pixels: usize) -> Self {
        Self {
            total: 0,
            pixels,
            counts: [[0; 256]; 4],
        }
    }

    /// Counts the pixels of a row that are set in `faint`.
    pub(crate) fn count(&mut self, row: &[u8], faint: &[u64]) {
        for (&word, pixels) in faint.iter().zip(row.chunks(64)) {
            let mut rest = word;
            while rest != 0 {
                let x = rest.trailing_zeros() as usize;
                rest &= rest - 1;
                self.counts[x % 4][usize::from(pixels[x])] += 1;
            }
        }
    }

    /// The share of the pixels from a level on.
    fn share(&self, histogram: &[u32; 256], from: u8) -> f32 {
        let above: u32 = histogram[usize::from(from)..].iter().sum();
        above as f32 / self.pixels.max(1) as f32
    }

    /// How often each level that is not the table's occurs.
    fn histogram(&self) -> [u32; 256] {
        std::array::from_fn(|level| self.counts.iter().map(|part| part[level]).sum())
    }
}

/// Finds the cut, given the levels of an image (those from [`faint`] on counted) and the table's noise.
pub(crate) fn choose(levels: &Levels, noise: f32) -> Cut {
    let histogram = levels.histogram();
    let means = |cut| means(levels, &histogram, cut);
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
        covered: levels.share(&histogram, whole(rope)),
    }
}

/// The least level that is not below `value`.
fn whole(value: f32) -> u8 {
    value.min(255.0).ceil() as u8
}

/// The mean level below `cut` and, if there is any, from `cut` on.
fn means(levels: &Levels, histogram: &[u32; 256], cut: f32) -> (f32, Option<f32>) {
    let from = (cut.ceil() as usize).min(256);
    let (mut count, mut sum) = (0u64, 0u64);
    for (level, &n) in histogram.iter().enumerate().skip(from) {
        count += u64::from(n);
        sum += u64::from(n) * level as u64;
    }
    let mean = |sum: u64, count: u64| (count > 0).then(|| sum as f32 / count as f32);
    let below = mean(levels.total - sum, levels.pixels as u64 - count);
    (below.unwrap_or(0.0), mean(sum, count))
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
    mask: &mut BitPlane,
) {
    mask.resize(difference.width(), difference.height());
    for y in 0..difference.height() {
        if faint.row(y).iter().any(|&word| word != 0) {
            (kernels.at_least)(difference.row(y), cut, mask.row_mut(y));
        }
    }
}
