//! The kernels in the registers of x86-64.
//!
//! `unsafe` is needed to call code compiled for registers that not every machine has, after a check
//! that this one has them. It is also needed to load and store through pointers of the lengths that
//! [`Registers`] requires.
#![allow(unsafe_code)]

use std::arch::x86_64::*;

use super::kernels::{Block, ConvolutionKernels, Job, Spin};
use super::plain;
use super::registers::{self, Registers};
use crate::arch::Arch;

/// The fastest kernels for these registers, if there are any.
pub(super) fn of(arch: Arch) -> Option<ConvolutionKernels> {
    match arch {
        Arch::Plain => None,
        Arch::V3(_) => narrow().next(),
        Arch::V4(_) => wide().next().or_else(|| narrow().next()),
    }
}

/// All kernels that this machine can run.
pub(super) fn all() -> impl Iterator<Item = ConvolutionKernels> {
    wide().chain(narrow())
}

/// Kernels in 64-byte registers, the fastest first.
fn wide() -> impl Iterator<Item = ConvolutionKernels> {
    let has = is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512bw");
    let vnni = has && is_x86_feature_detected!("avx512vnni");
    let look_up = if has && is_x86_feature_detected!("avx512vbmi") {
        // SAFETY: the machine has AVX-512BW and VBMI.
        |table: &[u8; 256], bytes: &mut [u8]| unsafe { look_up_vbmi(table, bytes) }
    } else {
        plain::look_up
    };
    let vnni = vnni.then_some(ConvolutionKernels {
        name: "AVX-512 VNNI",
        // SAFETY: the machine has AVX-512BW and VNNI.
        row: |job, block| unsafe { row_512_vnni(job, block) },
        widen: widen_in_256,
        look_up,
        // SAFETY: as above.
        spin: |rounds| unsafe { spin_512_vnni(rounds) },
    });
    let bytes = has.then_some(ConvolutionKernels {
        name: "AVX-512BW",
        // SAFETY: the machine has AVX-512BW.
        row: |job, block| unsafe { row_512(job, block) },
        widen: widen_in_256,
        look_up,
        // SAFETY: as above.
        spin: |rounds| unsafe { spin_512(rounds) },
    });
    vnni.into_iter().chain(bytes)
}

/// Kernels in 32-byte registers, the fastest first.
fn narrow() -> impl Iterator<Item = ConvolutionKernels> {
    let has = is_x86_feature_detected!("avx2");
    let vnni = has && is_x86_feature_detected!("avxvnni");
    let vnni = vnni.then_some(ConvolutionKernels {
        name: "AVX-VNNI",
        // SAFETY: the machine has AVX2 and AVX-VNNI.
        row: |job, block| unsafe { row_256_vnni(job, block) },
        widen: widen_in_256,
        look_up: plain::look_up,
        // SAFETY: as above.
        spin: |rounds| unsafe { spin_256_vnni(rounds) },
    });
    let bytes = has.then_some(ConvolutionKernels {
        name: "AVX2",
        // SAFETY: the machine has AVX2.
        row: |job, block| unsafe { row_256(job, block) },
        widen: widen_in_256,
        look_up: plain::look_up,
        // SAFETY: as above.
        spin: |rounds| unsafe { spin_256(rounds) },
    });
    vnni.into_iter().chain(bytes)
}

/// Registers of 64 bytes, with VNNI or without.
struct Wide<const VNNI: bool>;

impl<const VNNI: bool> Registers for Wide<VNNI> {
    type Sums = __m512i;
    type Weights = __m512i;
    type Input = __m512i;
    type Scales = __m512;
    type Bytes = __m512i;

    // SAFETY, here and below: the requirements of the trait.
    #[inline(always)]
    unsafe fn sums(at: *const i32) -> __m512i {
        unsafe { _mm512_loadu_si512(at.cast()) }
    }

    #[inline(always)]
    unsafe fn weights(at: *const i8) -> __m512i {
        unsafe { _mm512_loadu_si512(at.cast()) }
    }

    #[inline(always)]
    unsafe fn input(at: *const u8) -> __m512i {
        unsafe { _mm512_set1_epi32(at.cast::<i32>().read_unaligned()) }
    }

    #[inline(always)]
    unsafe fn scales(at: *const f32) -> __m512 {
        unsafe { _mm512_loadu_ps(at) }
    }

    #[inline(always)]
    unsafe fn bytes(at: *const u8) -> __m512i {
        unsafe { _mm512_loadu_si512(at.cast()) }
    }

    #[inline(always)]
    unsafe fn store(bytes: __m512i, at: *mut u8) {
        unsafe { _mm512_storeu_si512(at.cast(), bytes) }
    }

    #[inline(always)]
    unsafe fn dot(sums: __m512i, input: __m512i, weights: __m512i) -> __m512i {
        unsafe {
            if VNNI {
                _mm512_dpbusd_epi32(sums, input, weights)
            } else {
                let pairs = _mm512_maddubs_epi16(input, weights);
                _mm512_add_epi32(sums, _mm512_madd_epi16(pairs, _mm512_set1_epi16(1)))
            }
        }
    }

    #[inline(always)]
    unsafe fn scaled(sums: __m512i, scales: __m512) -> __m512i {
        unsafe { _mm512_cvtps_epi32(_mm512_mul_ps(_mm512_cvtepi32_ps(sums), scales)) }
    }

    /// Within each of a register's four parts, the bytes of the four registers follow each other,
    /// so parts and registers are swapped.
    #[inline(always)]
    unsafe fn narrow(s: [__m512i; 4]) -> __m512i {
        unsafe {
            let low = _mm512_packs_epi32(s[0], s[1]);
            let high = _mm512_packs_epi32(s[2], s[3]);
            let order = _mm512_setr_epi32(0, 4, 8, 12, 1, 5, 9, 13, 2, 6, 10, 14, 3, 7, 11, 15);
            _mm512_permutexvar_epi32(order, _mm512_packs_epi16(low, high))
        }
    }

    #[inline(always)]
    unsafe fn add(a: __m512i, b: __m512i) -> __m512i {
        unsafe { _mm512_adds_epi8(a, b) }
    }

    #[inline(always)]
    unsafe fn not_negative(bytes: __m512i) -> __m512i {
        unsafe { _mm512_max_epi8(bytes, _mm512_setzero_si512()) }
    }
}

/// Registers of 32 bytes, with VNNI or without.
struct Narrow<const VNNI: bool>;

impl<const VNNI: bool> Narrow<VNNI> {
    // SAFETY, here and below: the requirements of the trait.
    #[inline(always)]
    unsafe fn dot_one(sums: __m256i, input: __m256i, weights: __m256i) -> __m256i {
        unsafe {
            if VNNI {
                _mm256_dpbusd_avx_epi32(sums, input, weights)
            } else {
                let pairs = _mm256_maddubs_epi16(input, weights);
                _mm256_add_epi32(sums, _mm256_madd_epi16(pairs, _mm256_set1_epi16(1)))
            }
        }
    }

    #[inline(always)]
    unsafe fn narrow_two(a: [__m256i; 2], b: [__m256i; 2]) -> __m256i {
        unsafe {
            let (low, high) = (
                _mm256_packs_epi32(a[0], a[1]),
                _mm256_packs_epi32(b[0], b[1]),
            );
            // Each half has four bytes of a[0], a[1], b[0] and b[1].
            let order = _mm256_setr_epi32(0, 4, 1, 5, 2, 6, 3, 7);
            _mm256_permutevar8x32_epi32(_mm256_packs_epi16(low, high), order)
        }
    }
}

impl<const VNNI: bool> Registers for Narrow<VNNI> {
    type Sums = [__m256i; 2];
    type Weights = [__m256i; 2];
    type Input = __m256i;
    type Scales = [__m256; 2];
    type Bytes = [__m256i; 2];

    #[inline(always)]
    unsafe fn sums(at: *const i32) -> [__m256i; 2] {
        unsafe { Self::bytes(at.cast()) }
    }

    #[inline(always)]
    unsafe fn weights(at: *const i8) -> [__m256i; 2] {
        unsafe { Self::bytes(at.cast()) }
    }

    #[inline(always)]
    unsafe fn input(at: *const u8) -> __m256i {
        unsafe { _mm256_set1_epi32(at.cast::<i32>().read_unaligned()) }
    }

    #[inline(always)]
    unsafe fn scales(at: *const f32) -> [__m256; 2] {
        unsafe { [_mm256_loadu_ps(at), _mm256_loadu_ps(at.add(8))] }
    }

    #[inline(always)]
    unsafe fn bytes(at: *const u8) -> [__m256i; 2] {
        unsafe {
            [
                _mm256_loadu_si256(at.cast()),
                _mm256_loadu_si256(at.add(32).cast()),
            ]
        }
    }

    #[inline(always)]
    unsafe fn store(bytes: [__m256i; 2], at: *mut u8) {
        unsafe {
            _mm256_storeu_si256(at.cast(), bytes[0]);
            _mm256_storeu_si256(at.add(32).cast(), bytes[1]);
        }
    }

    #[inline(always)]
    unsafe fn dot(sums: [__m256i; 2], input: __m256i, weights: [__m256i; 2]) -> [__m256i; 2] {
        unsafe {
            [
                Self::dot_one(sums[0], input, weights[0]),
                Self::dot_one(sums[1], input, weights[1]),
            ]
        }
    }

    #[inline(always)]
    unsafe fn scaled(sums: [__m256i; 2], scales: [__m256; 2]) -> [__m256i; 2] {
        unsafe {
            [
                _mm256_cvtps_epi32(_mm256_mul_ps(_mm256_cvtepi32_ps(sums[0]), scales[0])),
                _mm256_cvtps_epi32(_mm256_mul_ps(_mm256_cvtepi32_ps(sums[1]), scales[1])),
            ]
        }
    }

    #[inline(always)]
    unsafe fn narrow(s: [[__m256i; 2]; 4]) -> [__m256i; 2] {
        unsafe { [Self::narrow_two(s[0], s[1]), Self::narrow_two(s[2], s[3])] }
    }

    #[inline(always)]
    unsafe fn add(a: [__m256i; 2], b: [__m256i; 2]) -> [__m256i; 2] {
        unsafe { [_mm256_adds_epi8(a[0], b[0]), _mm256_adds_epi8(a[1], b[1])] }
    }

    #[inline(always)]
    unsafe fn not_negative(bytes: [__m256i; 2]) -> [__m256i; 2] {
        unsafe {
            let zero = _mm256_setzero_si256();
            [
                _mm256_max_epi8(bytes[0], zero),
                _mm256_max_epi8(bytes[1], zero),
            ]
        }
    }
}

/// Processes as many pixels at a time as possible while registers are left for the weights of `C`
/// groups and for the input. The steps of the mask network's layers are compile-time constants.
///
/// # Safety
///
/// The machine has the registers.
#[inline(always)]
unsafe fn in_512<R: Registers>(job: &mut Job, block: &Block) {
    // SAFETY: the caller's promise.
    unsafe {
        match (block.bias.len(), job.step()) {
            (1, 8) => registers::row::<R, 1, 16, 8, 8>(job, block, 0),
            (1, _) => registers::row::<R, 1, 8, 4, 0>(job, block, 0),
            (2, 32) => registers::row::<R, 2, 8, 4, 32>(job, block, 0),
            (2, 48) => registers::row::<R, 2, 8, 4, 48>(job, block, 0),
            (2, _) => registers::row::<R, 2, 8, 4, 0>(job, block, 0),
            (3, 48) => registers::row::<R, 3, 8, 4, 48>(job, block, 0),
            (3, 64) => registers::row::<R, 3, 8, 4, 64>(job, block, 0),
            (3, _) => registers::row::<R, 3, 8, 4, 0>(job, block, 0),
            (4, 64) => registers::row::<R, 4, 5, 3, 64>(job, block, 0),
            (4, 96) => registers::row::<R, 4, 5, 3, 96>(job, block, 0),
            (_, _) => registers::row::<R, 4, 5, 3, 0>(job, block, 0),
        }
    }
}

/// The 16 registers suffice for one group of channels and `P` pixels: six with VNNI, four without,
/// where pairs of products need registers too.
///
/// # Safety
///
/// The machine has the registers.
#[inline(always)]
unsafe fn in_256<R: Registers, const P: usize>(job: &mut Job, block: &Block) {
    for group in 0..block.bias.len() {
        // SAFETY: the caller's promise.
        unsafe { registers::row::<R, 1, P, 4, 0>(job, block, group) };
    }
}

#[target_feature(enable = "avx512f,avx512bw,avx512vnni")]
fn row_512_vnni(job: &mut Job, block: &Block) {
    // SAFETY: these are the registers.
    unsafe { in_512::<Wide<true>>(job, block) }
}

#[target_feature(enable = "avx512f,avx512bw")]
fn row_512(job: &mut Job, block: &Block) {
    // SAFETY: these are the registers.
    unsafe { in_512::<Wide<false>>(job, block) }
}

#[target_feature(enable = "avx2,avxvnni")]
fn row_256_vnni(job: &mut Job, block: &Block) {
    // SAFETY: these are the registers.
    unsafe { in_256::<Narrow<true>, 6>(job, block) }
}

#[target_feature(enable = "avx2")]
fn row_256(job: &mut Job, block: &Block) {
    // SAFETY: these are the registers.
    unsafe { in_256::<Narrow<false>, 4>(job, block) }
}

#[target_feature(enable = "avx512f,avx512bw,avx512vnni")]
fn spin_512_vnni(rounds: u64) -> Spin {
    // SAFETY: these are the registers.
    unsafe { registers::spin::<Wide<true>, 16>(rounds) }
}

#[target_feature(enable = "avx512f,avx512bw")]
fn spin_512(rounds: u64) -> Spin {
    // SAFETY: these are the registers.
    unsafe { registers::spin::<Wide<false>, 16>(rounds) }
}

#[target_feature(enable = "avx2,avxvnni")]
fn spin_256_vnni(rounds: u64) -> Spin {
    // SAFETY: these are the registers.
    unsafe { registers::spin::<Narrow<true>, 6>(rounds) }
}

#[target_feature(enable = "avx2")]
fn spin_256(rounds: u64) -> Spin {
    // SAFETY: these are the registers.
    unsafe { registers::spin::<Narrow<false>, 4>(rounds) }
}

fn widen_in_256(rgb: &[u8], out: &mut [u8]) {
    // SAFETY: every machine that uses kernels of this file has AVX2.
    unsafe { widen_256(rgb, out) }
}

/// Converts eight pixels at a time, as long as four bytes can be read after them.
#[target_feature(enable = "avx2")]
fn widen_256(rgb: &[u8], out: &mut [u8]) {
    let order = _mm256_broadcastsi128_si256(_mm_setr_epi8(
        0, 1, 2, -1, 3, 4, 5, -1, 6, 7, 8, -1, 9, 10, 11, -1,
    ));
    let low = _mm256_set1_epi8(127);
    let mut done = 0;
    for eight in out.as_chunks_mut::<32>().0 {
        let Some(bytes) = rgb.get(3 * done..3 * done + 28) else {
            break;
        };
        // SAFETY: the loads read 16 bytes each, from bytes 0 and 12 of 28; a chunk has 32 bytes.
        unsafe {
            let high = bytes[12..].as_ptr().cast();
            let pixels = _mm256_loadu2_m128i(high, bytes.as_ptr().cast());
            let pixels = _mm256_srli_epi16::<1>(_mm256_shuffle_epi8(pixels, order));
            _mm256_storeu_si256(eight.as_mut_ptr().cast(), _mm256_and_si256(pixels, low));
        }
        done += 8;
    }
    plain::widen(&rgb[3 * done..], &mut out[4 * done..]);
}

/// Looks up each half of the table in two registers.
#[target_feature(enable = "avx512f,avx512bw,avx512vbmi")]
fn look_up_vbmi(table: &[u8; 256], bytes: &mut [u8]) {
    let quarters = table.as_chunks::<64>().0;
    // SAFETY: a quarter has 64 bytes.
    let quarter = |k: usize| unsafe { _mm512_loadu_si512(quarters[k].as_ptr().cast()) };
    let [a, b, c, d] = [0, 1, 2, 3].map(quarter);
    let (chunks, rest) = bytes.as_chunks_mut::<64>();
    for chunk in chunks {
        // SAFETY: a chunk has 64 bytes.
        unsafe {
            let at = _mm512_loadu_si512(chunk.as_ptr().cast());
            let low = _mm512_permutex2var_epi8(a, at, b);
            let high = _mm512_permutex2var_epi8(c, at, d);
            let upper = _mm512_movepi8_mask(at);
            let found = _mm512_mask_blend_epi8(upper, low, high);
            _mm512_storeu_si512(chunk.as_mut_ptr().cast(), found);
        }
    }
    plain::look_up(table, rest);
}
