//! Where the table ends and the rope begins, and the mask that follows.
//!
//! Ridler and Calvard, "Picture thresholding using an iterative selection method" (1978): the level
//! halfway between the means of what lies below and above it, found by iteration. The mask is cut
//! somewhat below that, so that the dimmer of several ropes stays whole (edges are placed at half of
//! each rope's own contrast later), and never below a multiple of the table's noise: an empty table
//! has no rope.

use crate::bits::BitPlane;
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

/// What separates the ropes from the table, in levels of difference.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cut {
    /// From here on a pixel is rope.
    pub(crate) rope: u8,
    /// From here on a pixel is not just the table's noise: rope, if there is rope around it.
    pub(crate) faint: u8,
    /// The ropes' mean.
    pub(crate) level: u8,
}

/// The least cut that the table's noise allows, in levels of difference.
pub(crate) fn floor(noise: f32) -> f32 {
    (NOISE_FLOOR * noise).max(LEVEL_FLOOR)
}

/// Finds the cut, given the table's noise.
pub(crate) fn choose(difference: &Plane, noise: f32) -> Cut {
    let histogram = histogram(difference);
    let floor = floor(noise);
    let mut cut = floor;
    for _ in 0..32 {
        let (below, above) = means(&histogram, cut);
        let Some(above) = above else { break };
        let next = (0.5 * (below + above)).max(floor);
        if (next - cut).abs() < 0.25 {
            break;
        }
        cut = next;
    }
    let (below, above) = means(&histogram, cut);
    let above = above.unwrap_or(floor);
    let share = below + SHARE * (above - below);
    let faint = (FAINT_FLOOR * noise).max(LEVEL_FLOOR);
    // Where ropes stand well out of the noise, their share decides.
    let rope = if share >= faint { share } else { floor };
    let level = |value: f32| value.min(255.0).ceil() as u8;
    Cut {
        rope: level(rope),
        faint: level(faint),
        level: level(above),
    }
}

/// One bit a pixel: difference ≥ cut.
pub(crate) fn apply(difference: &Plane, cut: u8, mask: &mut BitPlane) {
    mask.resize(difference.width(), difference.height());
    let arch = pulp::Arch::new();
    for y in 0..difference.height() {
        let (row, words) = (difference.row(y), mask.row_mut(y));
        arch.dispatch(|| pack(row, cut, words));
    }
}

/// Eight comparisons at a time become eight bits by one multiplication.
#[inline(always)]
fn pack(row: &[u8], cut: u8, words: &mut [u64]) {
    for (word, pixels) in words.iter_mut().zip(row.chunks(64)) {
        let mut ones = [0u8; 64];
        for (one, &pixel) in ones.iter_mut().zip(pixels) {
            *one = u8::from(pixel >= cut);
        }
        *word = 0;
        for (i, eight) in ones.chunks_exact(8).enumerate() {
            let mut bytes = [0; 8];
            bytes.copy_from_slice(eight);
            let bits = u64::from_le_bytes(bytes).wrapping_mul(0x0102_0408_1020_4080) >> 56;
            *word |= bits << (8 * i);
        }
    }
}

fn histogram(difference: &Plane) -> [u32; 256] {
    // Four histograms, so that equal neighbors do not wait for each other's count.
    let mut parts = [[0u32; 256]; 4];
    for y in 0..difference.height() {
        for four in difference.row(y).chunks(4) {
            for (part, &level) in parts.iter_mut().zip(four) {
                part[usize::from(level)] += 1;
            }
        }
    }
    std::array::from_fn(|level| parts.iter().map(|p| p[level]).sum())
}

/// The mean level below `cut` and, if there is any, from `cut` on.
fn means(histogram: &[u32; 256], cut: f32) -> (f32, Option<f32>) {
    let split = (cut.ceil() as usize).min(256);
    let mean = |from: usize, to: usize| {
        let (mut count, mut sum) = (0u64, 0u64);
        for (level, &n) in histogram.iter().enumerate().take(to).skip(from) {
            count += u64::from(n);
            sum += u64::from(n) * level as u64;
        }
        (count > 0).then(|| sum as f32 / count as f32)
    };
    (mean(0, split).unwrap_or(0.0), mean(split, 256))
}
