//! The loop over a row, written once for every kind of registers.
//!
//! `unsafe` is needed to call what is compiled for registers that not every machine has, and to read and write through
//! pointers, whose bounds are told where they are made. All is `#[inline(always)]`, and nothing is a closure: only so is it
//! compiled for the registers of the function that calls [`row`].
#![allow(unsafe_code)]

use std::mem::MaybeUninit;

use super::Finish;
use super::kernels::{Block, Job, Spin};

/// What a kind of registers can do.
///
/// # Safety
///
/// Every function needs a machine with these registers; those that take a pointer, that as many bytes are there as they say.
pub(super) trait Registers {
    /// A sum for each of 16 output channels.
    type Sums: Copy;
    /// Four weights for each of 16 output channels.
    type Weights: Copy;
    /// Four bytes of input, as every channel needs them.
    type Input: Copy;
    /// A float for each of 16 output channels.
    type Scales: Copy;
    /// 64 signed bytes.
    type Bytes: Copy;

    /// From 64 bytes.
    unsafe fn sums(at: *const i32) -> Self::Sums;
    /// From 64 bytes.
    unsafe fn weights(at: *const i8) -> Self::Weights;
    /// From four bytes.
    unsafe fn input(at: *const u8) -> Self::Input;
    /// From 64 bytes.
    unsafe fn scales(at: *const f32) -> Self::Scales;
    /// From 64 bytes.
    unsafe fn bytes(at: *const u8) -> Self::Bytes;
    /// To 64 bytes.
    unsafe fn store(bytes: Self::Bytes, at: *mut u8);

    /// To each sum its four products.
    unsafe fn dot(sums: Self::Sums, input: Self::Input, weights: Self::Weights) -> Self::Sums;
    /// `round(float(sum) · scale)`.
    unsafe fn scaled(sums: Self::Sums, scales: Self::Scales) -> Self::Sums;
    /// The sums as bytes, in order; those that are too large or too small as the largest and smallest byte.
    unsafe fn narrow(sums: [Self::Sums; 4]) -> Self::Bytes;
    /// Sums that are no larger than the largest byte and no smaller than the smallest.
    unsafe fn add(a: Self::Bytes, b: Self::Bytes) -> Self::Bytes;
    /// The larger of each and 0.
    unsafe fn not_negative(bytes: Self::Bytes) -> Self::Bytes;
}

/// The most bytes that a block of pixels makes.
const MOST: usize = 512;

/// Makes the channels of `C` groups of a block, from `group` on, along a row, `P` pixels at a time, and `REST` where no more
/// are left. `STEP` is the job's step, or 0 where that is not known before.
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

/// Makes `P` pixels from `x` on, and says where they end. If the row ends before, they are moved back so that they end with
/// it, and some of them are made again.
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
    // SAFETY: the caller's promise; an input row has at least 16 windows, and P of them from `first` on.
    unsafe {
        let sums = sums::<R, C, P, STEP>(job, block, group, first);
        finish::<R, C, P>(job, block, group, first, sums);
    }
    first + P
}

/// # Safety
///
/// The machine has the registers, the block has the groups, and the rows have `P` windows from `first` on.
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
    // SAFETY: the caller's promise. A bias is 16 numbers; the weights are as many as are read, by the assertion; a run is
    // within its window, and `input_bytes` counts all of a window.
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
    // Of each pixel, and 16·C bytes of it: the block's channels are among those of the shape.
    let start = block.first + 16 * group;
    assert!(start + 16 * C <= channels);
    // Where these are all channels of P pixels, they lie in one piece; else they go by way of an array.
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
    // SAFETY: the caller's promise. A scale is 16 floats. `out` and `residual` are of `pixels` times `channels` bytes, by
    // their range; the arrays are of 16·C·P bytes or more, and filled before they are read.
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
            // The last four may have some of those before.
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

/// `rounds` times a `dot` for each of `N` registers of sums, each with weights of its own and inputs that change, so that all products are made.
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
    // SAFETY: the caller's promise; the arrays are as long as is read and written.
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
