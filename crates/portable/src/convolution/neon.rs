//! The kernels in the 16-byte registers of 64-bit ARM.
//!
//! `unsafe` is needed to call code compiled for instructions that not every machine has, after a
//! check that this one has them. It is also needed to name an instruction that lacks a function,
//! and to load and store through pointers of the lengths that [`Registers`] requires.
#![allow(unsafe_code)]

use std::arch::aarch64::*;
use std::arch::{asm, is_aarch64_feature_detected};

use super::kernels::{Block, ConvolutionKernels, Job, Spin};
use super::plain;
use super::registers::{self, Registers};

/// The fastest kernels of this machine.
pub(super) fn fastest() -> ConvolutionKernels {
    dotprod().unwrap_or_else(neon)
}

/// All kernels of this machine.
pub(super) fn all() -> impl Iterator<Item = ConvolutionKernels> {
    dotprod().into_iter().chain([neon()])
}

fn dotprod() -> Option<ConvolutionKernels> {
    is_aarch64_feature_detected!("dotprod").then_some(ConvolutionKernels {
        name: "NEON with sdot",
        // SAFETY: the machine has the instruction.
        row: |job, block| unsafe { row_dotprod(job, block) },
        widen: plain::widen,
        look_up: plain::look_up,
        // SAFETY: as above.
        spin: |rounds| unsafe { spin_dotprod(rounds) },
    })
}

fn neon() -> ConvolutionKernels {
    ConvolutionKernels {
        name: "NEON",
        // SAFETY: every 64-bit ARM that Rust supports has NEON.
        row: |job, block| unsafe { row_neon(job, block) },
        widen: plain::widen,
        look_up: plain::look_up,
        // SAFETY: as above.
        spin: |rounds| unsafe { spin_neon(rounds) },
    }
}

/// Four registers, with `sdot` or without. An activation is at most 127, so it fits a signed byte.
struct Neon<const DOT: bool>;

impl<const DOT: bool> Neon<DOT> {
    #[inline(always)]
    unsafe fn dot_one(sums: int32x4_t, input: int8x16_t, weights: int8x16_t) -> int32x4_t {
        // SAFETY: the requirements of the trait; the instruction accesses only its registers.
        unsafe {
            if DOT {
                let mut sums = sums;
                asm!(
                    "sdot {0:v}.4s, {1:v}.16b, {2:v}.16b",
                    inout(vreg) sums, in(vreg) input, in(vreg) weights,
                    options(pure, nomem, nostack, preserves_flags),
                );
                sums
            } else {
                let low = vmull_s8(vget_low_s8(input), vget_low_s8(weights));
                let high = vmull_high_s8(input, weights);
                vpadalq_s16(sums, vpaddq_s16(low, high))
            }
        }
    }
}

impl<const DOT: bool> Registers for Neon<DOT> {
    type Sums = [int32x4_t; 4];
    type Weights = [int8x16_t; 4];
    type Input = int8x16_t;
    type Scales = [float32x4_t; 4];
    type Bytes = [int8x16_t; 4];

    // SAFETY, here and below: the requirements of the trait.
    #[inline(always)]
    unsafe fn sums(at: *const i32) -> [int32x4_t; 4] {
        unsafe {
            [
                vld1q_s32(at),
                vld1q_s32(at.add(4)),
                vld1q_s32(at.add(8)),
                vld1q_s32(at.add(12)),
            ]
        }
    }

    #[inline(always)]
    unsafe fn weights(at: *const i8) -> [int8x16_t; 4] {
        unsafe {
            [
                vld1q_s8(at),
                vld1q_s8(at.add(16)),
                vld1q_s8(at.add(32)),
                vld1q_s8(at.add(48)),
            ]
        }
    }

    #[inline(always)]
    unsafe fn input(at: *const u8) -> int8x16_t {
        unsafe { vreinterpretq_s8_s32(vdupq_n_s32(at.cast::<i32>().read_unaligned())) }
    }

    #[inline(always)]
    unsafe fn scales(at: *const f32) -> [float32x4_t; 4] {
        unsafe {
            [
                vld1q_f32(at),
                vld1q_f32(at.add(4)),
                vld1q_f32(at.add(8)),
                vld1q_f32(at.add(12)),
            ]
        }
    }

    #[inline(always)]
    unsafe fn bytes(at: *const u8) -> [int8x16_t; 4] {
        unsafe { Self::weights(at.cast()) }
    }

    #[inline(always)]
    unsafe fn store(bytes: [int8x16_t; 4], at: *mut u8) {
        for (k, bytes) in bytes.into_iter().enumerate() {
            unsafe { vst1q_s8(at.cast::<i8>().add(16 * k), bytes) };
        }
    }

    #[inline(always)]
    unsafe fn dot(
        mut sums: [int32x4_t; 4],
        input: int8x16_t,
        weights: [int8x16_t; 4],
    ) -> [int32x4_t; 4] {
        for k in 0..4 {
            sums[k] = unsafe { Self::dot_one(sums[k], input, weights[k]) };
        }
        sums
    }

    #[inline(always)]
    unsafe fn scaled(mut sums: [int32x4_t; 4], scales: [float32x4_t; 4]) -> [int32x4_t; 4] {
        for k in 0..4 {
            sums[k] = unsafe { vcvtnq_s32_f32(vmulq_f32(vcvtq_f32_s32(sums[k]), scales[k])) };
        }
        sums
    }

    #[inline(always)]
    unsafe fn narrow(sums: [[int32x4_t; 4]; 4]) -> [int8x16_t; 4] {
        unsafe {
            [
                narrow(sums[0]),
                narrow(sums[1]),
                narrow(sums[2]),
                narrow(sums[3]),
            ]
        }
    }

    #[inline(always)]
    unsafe fn add(mut a: [int8x16_t; 4], b: [int8x16_t; 4]) -> [int8x16_t; 4] {
        for k in 0..4 {
            a[k] = unsafe { vqaddq_s8(a[k], b[k]) };
        }
        a
    }

    #[inline(always)]
    unsafe fn not_negative(mut bytes: [int8x16_t; 4]) -> [int8x16_t; 4] {
        for bytes in &mut bytes {
            *bytes = unsafe { vmaxq_s8(*bytes, vdupq_n_s8(0)) };
        }
        bytes
    }
}

/// # Safety
///
/// The machine has NEON.
#[inline(always)]
unsafe fn narrow(sums: [int32x4_t; 4]) -> int8x16_t {
    // SAFETY: the caller's promise.
    unsafe {
        let low = vqmovn_high_s32(vqmovn_s32(sums[0]), sums[1]);
        let high = vqmovn_high_s32(vqmovn_s32(sums[2]), sums[3]);
        vqmovn_high_s16(vqmovn_s16(low), high)
    }
}

/// The 32 registers suffice for one group of channels and four pixels.
///
/// # Safety
///
/// The machine has the instructions.
#[inline(always)]
unsafe fn in_128<R: Registers>(job: &mut Job, block: &Block) {
    for group in 0..block.bias.len() {
        // SAFETY: the caller's promise.
        unsafe { registers::row::<R, 1, 4, 4, 0>(job, block, group) };
    }
}

#[target_feature(enable = "neon,dotprod")]
fn row_dotprod(job: &mut Job, block: &Block) {
    // SAFETY: these are the instructions.
    unsafe { in_128::<Neon<true>>(job, block) }
}

#[target_feature(enable = "neon")]
fn row_neon(job: &mut Job, block: &Block) {
    // SAFETY: these are the instructions.
    unsafe { in_128::<Neon<false>>(job, block) }
}

#[target_feature(enable = "neon,dotprod")]
fn spin_dotprod(rounds: u64) -> Spin {
    // SAFETY: these are the instructions.
    unsafe { registers::spin::<Neon<true>, 4>(rounds) }
}

#[target_feature(enable = "neon")]
fn spin_neon(rounds: u64) -> Spin {
    // SAFETY: these are the instructions.
    unsafe { registers::spin::<Neon<false>, 4>(rounds) }
}
