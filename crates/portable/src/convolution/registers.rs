//! The loop over a row, written once for every kind of registers.
//!
//! `unsafe` is needed to call code compiled for registers that not every machine has, and to read
//! and write through pointers, whose bounds are stated where they are created. Everything is
//! `#[inline(always)]`, and nothing is a closure; only then is it compiled for the registers of the
//! function that calls [`row`].
#![allow(unsafe_code)]

use std::mem::MaybeUninit;

use super::Finish;
use super::kernels::{Block, Job, Spin};

/// Operations of a kind of registers.
///
/// # Safety
///
/// Every function requires a machine with these registers. A pointer must be valid for the stated
/// number of bytes.
pub(super) trait Registers {
    /// A sum for each of 16 output channels.
    type Sums: Copy;
    /// Four weights for each of 16 output channels.
    type Weights: Copy;
    /// Four bytes of input, repeated for every channel.
    type Input: Copy;
    /// A float for each of 16 output channels.
    type Scales: Copy;
    /// 64 signed bytes.
    type Bytes: Copy;

    /// Loads 64 bytes.
    unsafe fn sums(at: *const i32) -> Self::Sums;
    /// Loads 64 bytes.
    unsafe fn weights(at: *const i8) -> Self::Weights;
    /// Loads four bytes.
    unsafe fn input(at: *const u8) -> Self::Input;
    /// Loads 64 bytes.
    unsafe fn scales(at: *const f32) -> Self::Scales;
    /// Loads 64 bytes.
    unsafe fn bytes(at: *const u8) -> Self::Bytes;
    /// Stores 64 bytes.
    unsafe fn store(bytes: Self::Bytes, at: *mut u8);

    /// Adds to each sum its four products.
    unsafe fn dot(sums: Self::Sums, input: Self::Input, weights: Self::Weights) -> Self::Sums;
    /// `round(float(sum) · scale)`.
    unsafe fn scaled(sums: Self::Sums, scales: Self::Scales) -> Self::Sums;
    /// Converts the sums to bytes in order, with saturation.
    unsafe fn narrow(sums: [Self::Sums; 4]) -> Self::Bytes;
    /// Adds with saturation.
    unsafe fn add(a: Self::Bytes, b: Self::Bytes) -> Self::Bytes;
    /// The maximum of each byte and 0.
    unsafe fn not_negative(bytes: Self::Bytes) -> Self::Bytes;
}

/// Maximum number of bytes that a block of pixels produces.
const MOST: usize = 512;

/// Computes the channels of `C` groups of a block, from `group` on, along a row. It processes `P`
/// pixels at a time, or `REST` if no more than that are left. `STEP` is the job's step, or 0 if it
/// is unknown at compile time.
///
/// # Safety
///
/// The machine has the registers.
#[inline(always)]
pub(super) unsafe fn row<
    R: Registers,
    const C: usize,
    const P: usize,
    const REST: usize,
    const STEP: usize,
>(
    job: &mut Job,
    block: &Block,
    group: usize,
) {
    debug_assert!(STEP == 0 || STEP == job.step());
    assert!(group + C <= block.bias.len());
    let mut x = 0;
    while x < job.width {
        // SAFETY: the caller's promise.
        x = unsafe {
            if job.width - x > REST {
                pixels::<R, C, P, STEP>(job, block, group, x)
            } else {
                pixels::<R, C, REST, STEP>(job, block, group, x)
            }
        };
    }
}

/// Computes `P` pixels from `x` on and returns where they end. If the row ends before that, the
/// pixels are moved back to end with it, and some are computed again.
///
/// # Safety
///
/// The machine has the registers, and the block has the groups.
#[inline(always)]
unsafe fn pixels<R: Registers, const C: usize, const P: usize, const STEP: usize>(
    job: &mut Job,
    block: &Block,
    group: usize,
    x: usize,
) -> usize {
    const { assert!(C * P >= 4 && 16 * C * P <= MOST && P <= Job::PIXELS) };
    let first = x.min(job.width.saturating_sub(P));
    // SAFETY: the caller's promise; an input row has at least 16 windows, and `P` of them from
    // `first` on.
    unsafe {
        let sums = sums::<R, C, P, STEP>(job, block, group, first);
        finish::<R, C, P>(job, block, group, first, sums);
    }
    first + P
}

/// # Safety
///
/// The machine has the registers, the block has the groups, and the rows have `P` windows from
/// `first` on.
#[inline(always)]
unsafe fn sums<R: Registers, const C: usize, const P: usize, const STEP: usize>(
    job: &Job,
    block: &Block,
    group: usize,
    first: usize,
) -> [[R::Sums; C]; P] {
    let step = if STEP == 0 { job.step() } else { STEP };
    let (runs, apart, bytes) = job.runs();
    let groups = block.bias.len();
    assert!(block.weights.len() >= job.rows.len() * runs * (bytes / 4) * groups);
    let bias: &[_; C] = block.bias[group..]
        .first_chunk()
        .expect("the caller's promise");
    // SAFETY: the caller's promise. A bias has 16 numbers; the assertion checks the number of
    // weights; a run is within its window, and `input_bytes` covers whole windows.
    unsafe {
        let mut biases = [R::sums(bias[0].0.as_ptr()); C];
        for (biases, bias) in biases.iter_mut().zip(bias) {
            *biases = R::sums(bias.0.as_ptr());
        }
        let mut sums = [biases; P];
        let mut weights: *const i8 = block.weights.as_ptr().add(group).cast();
        for row in job.rows {
            let window = row.as_ptr().add(first * step);
            for run in 0..runs {
                let mut at = window.add(run * apart);
                for _ in 0..bytes / 4 {
                    let mut w = [R::weights(weights); C];
                    for (c, w) in w.iter_mut().enumerate() {
                        *w = R::weights(weights.add(64 * c));
                    }
                    for (p, sums) in sums.iter_mut().enumerate() {
                        let input = R::input(at.add(p * step));
                        for c in 0..C {
                            sums[c] = R::dot(sums[c], input, w[c]);
                        }
                    }
                    at = at.add(4);
                    weights = weights.wrapping_add(64 * groups);
                }
            }
        }
        sums
    }
}

/// # Safety
///
/// The machine has the registers, and the block has the groups.
#[inline(always)]
unsafe fn finish<R: Registers, const C: usize, const P: usize>(
    job: &mut Job,
    block: &Block,
    group: usize,
    first: usize,
    sums: [[R::Sums; C]; P],
) {
    let channels = job.shape.out_channels;
    let pixels = P.min(job.width - first);
    let range = first * channels..(first + pixels) * channels;
    // The 16·C bytes of each pixel; the block's channels are among those of the shape.
    let start = block.first + 16 * group;
    assert!(start + 16 * C <= channels);
    // The output is contiguous if it is `P` pixels with all their channels; otherwise it goes
    // through an array.
    let whole = pixels == P && channels == 16 * C;
    let out = job.out[range.clone()].as_mut_ptr();
    let residual = job.residual.map(|r| r[range].as_ptr());
    let mut made = MaybeUninit::<[u8; MOST]>::uninit();
    let mut kept = MaybeUninit::<[u8; MOST]>::uninit();
    let (made, kept) = (
        made.as_mut_ptr().cast::<u8>(),
        kept.as_mut_ptr().cast::<u8>(),
    );
    let scale: &[_; C] = block.scale[group..]
        .first_chunk()
        .expect("the caller's promise");
    // SAFETY: the caller's promise. A scale has 16 floats. `out` and `residual` have `pixels` times
    // `channels` bytes, by their range. The arrays have at least 16·C·P bytes and are filled before
    // they are read.
    unsafe {
        let residual = match residual {
            Some(residual) if !whole => {
                kept.write_bytes(0, 16 * C * P);
                for p in 0..pixels {
                    let from = residual.add(p * channels + start);
                    kept.add(16 * C * p).copy_from_nonoverlapping(from, 16 * C);
                }
                Some(kept.cast_const())
            }
            residual => residual,
        };
        let to = if whole { out } else { made };
        let mut scales = [R::scales(scale[0].0.as_ptr()); C];
        for (scales, scale) in scales.iter_mut().zip(scale) {
            *scales = R::scales(scale.0.as_ptr());
        }
        for four in 0..(C * P).div_ceil(4) {
            // The last four may overlap the previous ones.
            let at = (4 * four).min(C * P - 4);
            let mut values = [sums[0][0]; 4];
            for (k, value) in values.iter_mut().enumerate() {
                let (p, c) = ((at + k) / C, (at + k) % C);
                *value = R::scaled(sums[p][c], scales[c]);
            }
            let mut bytes = R::narrow(values);
            if let Some(residual) = residual {
                bytes = R::add(bytes, R::bytes(residual.add(16 * at)));
            }
            if job.finish == Finish::Relu {
                bytes = R::not_negative(bytes);
            }
            R::store(bytes, to.add(16 * at));
        }
        if !whole {
            for p in 0..pixels {
                let to = out.add(p * channels + start);
                to.copy_from_nonoverlapping(made.add(16 * C * p), 16 * C);
            }
        }
    }
}

/// Runs one `dot` for each of `N` registers of sums, `rounds` times. Each has its own weights, and
/// the inputs change, so that all products are computed.
///
/// # Safety
///
/// The machine has the registers.
#[inline(always)]
pub(super) unsafe fn spin<R: Registers, const N: usize>(rounds: u64) -> Spin {
    let inputs = std::hint::black_box([[3u8; 4]; 64]);
    let weights = std::hint::black_box([[2i8; 64]; N]);
    let zeros = std::hint::black_box([0i32; 16]);
    let mut out = [0u8; 64];
    // SAFETY: the caller's promise; the arrays are as long as the accesses.
    unsafe {
        let mut kept = [R::weights(weights[0].as_ptr()); N];
        for (kept, weights) in kept.iter_mut().zip(&weights) {
            *kept = R::weights(weights.as_ptr());
        }
        let mut sums = [R::sums(zeros.as_ptr()); N];
        for round in 0..rounds {
            let input = R::input(inputs[(round % 64) as usize].as_ptr());
            for (sum, weights) in sums.iter_mut().zip(kept) {
                *sum = R::dot(*sum, input, weights);
            }
        }
        for four in sums.windows(4) {
            R::store(
                R::narrow(std::array::from_fn(|k| four[k])),
                out.as_mut_ptr(),
            );
            std::hint::black_box(&mut out);
        }
    }
    Spin {
        multiply_adds: rounds * 64 * N as u64,
        sum: out.iter().map(|b| i32::from(*b)).sum(),
    }
}
