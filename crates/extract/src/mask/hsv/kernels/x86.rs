//! The same in the registers of x86-64: 64 bytes (AVX-512 with VBMI) or 32 (AVX2) at a time.
//!
//! `unsafe` is needed to call what is compiled for registers that not every machine has, after asking whether this one
//! has them, and to load and store through pointers, which are taken from arrays of the length that is moved.
//!
//! Three interleaved channels A, B, C in three registers of 16 or 64 lanes: as both leave 1 when divided by 3, lane i
//! holds channel i, i + 1 and i + 2 (mod 3) of them, so that blending them by lanes gathers all of a channel's bytes in
//! one register, and one permutation puts them in order.
//!
//! The bands of 64 levels are one permutation of a register that holds them twice (its index is six bits, of which the
//! first is not the level's own), those of 32 two shuffles of 16 and a blend.
#![allow(unsafe_code)]

use super::{Kernels, PLAIN, among};
use crate::image::kernels::orders;
use crate::mask::hsv::cube::{Cube, STEPS};
use crate::mask::hsv::outline::Outline;
use std::arch::x86_64::*;

/// Pixels of 64 that are looked up one by one, faster than a gather of sixteen is set up.
const FEW: u32 = 8;

/// The fastest of this machine.
pub(super) fn detect() -> Option<Kernels> {
    all().next()
}

/// All that this machine can run, the fastest first.
pub(super) fn all() -> impl Iterator<Item = Kernels> {
    let wide = is_x86_feature_detected!("avx512bw") && is_x86_feature_detected!("avx512vbmi");
    let medium = is_x86_feature_detected!("avx2");
    let wide = wide.then_some(Kernels {
        // SAFETY: the machine has AVX-512BW and VBMI.
        split_three: |row, planes| unsafe { split_three_512(row, planes) },
        // SAFETY: as above.
        select: |cube, planes, inside, words| unsafe { select_512(cube, planes, inside, words) },
        ..PLAIN
    });
    let medium = medium.then_some(Kernels {
        // SAFETY: the machine has AVX2.
        split_three: |row, planes| unsafe { split_three_256(row, planes) },
        // SAFETY: as above.
        select: |cube, planes, inside, words| unsafe { select_256(cube, planes, inside, words) },
        ..PLAIN
    });
    wide.into_iter().chain(medium)
}

#[target_feature(enable = "avx512f,avx512bw,avx512vbmi")]
fn split_three_512(row: &[u8], [first, second, third]: [&mut [u8]; 3]) {
    const ORDERS: [[u8; 64]; 3] = orders();
    // Lanes that a register after the first gives to a channel.
    const LANES: u64 = 0x9249_2492_4924_9249;
    const ZERO_ONE_TWO: [u64; 3] = [LANES, LANES << 1, LANES << 2];
    let [zero, one, two] = ZERO_ONE_TWO;
    // SAFETY: the arrays are 64 bytes long.
    let orders = ORDERS.map(|order| unsafe { _mm512_loadu_si512(order.as_ptr().cast()) });
    let (blocks, rest) = row.as_chunks::<192>();
    let (firsts, first_rest) = first.as_chunks_mut::<64>();
    let (seconds, second_rest) = second.as_chunks_mut::<64>();
    let (thirds, third_rest) = third.as_chunks_mut::<64>();
    for (((block, first), second), third) in blocks.iter().zip(firsts).zip(seconds).zip(thirds) {
        // SAFETY: a block is 192 bytes long.
        let [a, b, c] =
            [0, 64, 128].map(|at| unsafe { _mm512_loadu_si512(block.as_ptr().add(at).cast()) });
        // Lane i holds channel 0 in a where i = 0 (mod 3), in b where i = 2, in c where i = 1.
        let blend = |from_b, from_c| {
            let ab = _mm512_mask_blend_epi8(from_b, a, b);
            _mm512_mask_blend_epi8(from_c, ab, c)
        };
        let channels = [blend(two, one), blend(zero, two), blend(one, zero)];
        for ((out, channel), order) in [first, second, third].into_iter().zip(channels).zip(orders)
        {
            let ordered = _mm512_permutexvar_epi8(order, channel);
            // SAFETY: `out` is 64 bytes long.
            unsafe { _mm512_storeu_si512(out.as_mut_ptr().cast(), ordered) };
        }
    }
    super::split_three(rest, [first_rest, second_rest, third_rest]);
}

#[target_feature(enable = "avx512f,avx512bw,avx512vbmi")]
fn select_512(cube: &Cube, planes: [&[u8]; 3], inside: &mut [u8], words: &mut [u64]) {
    let tables = cube.bands.each_ref().map(|bands| {
        // SAFETY: the bands of a channel are 32 bytes long.
        let half = unsafe { _mm256_loadu_si256(bands.as_ptr().cast()) };
        _mm512_broadcast_i64x4(half)
    });
    let Some(answers) = cube.words() else {
        return super::select(cube, planes, inside, words);
    };
    let blocks = inside.len() / 64;
    let [a, b, c] = planes.map(|plane| plane.as_chunks::<64>().0);
    let (bytes, rest) = inside.as_chunks_mut::<64>();
    for ((bytes, word), ((a, b), c)) in bytes
        .iter_mut()
        .zip(&mut *words)
        .zip(a.iter().zip(b).zip(c))
    {
        let bands = |channel: &[u8; 64], table| {
            // SAFETY: the array is 64 bytes long.
            let levels = unsafe { _mm512_loadu_si512(channel.as_ptr().cast()) };
            _mm512_permutexvar_epi8(_mm512_srli_epi16(levels, 3), table)
        };
        let common = _mm512_and_si512(bands(a, tables[0]), bands(b, tables[1]));
        let mut may = _mm512_test_epi8_mask(common, bands(c, tables[2]));
        if may != 0 {
            may &= outlined_512(&cube.outlines, [a, b, c]);
        }
        *word = if may.count_ones() <= FEW {
            among(may, cube, [a, b, c])
        } else {
            gather(may, answers, [a, b, c])
        };
        let whole = _mm512_movm_epi8(*word);
        // SAFETY: the array is 64 bytes long.
        unsafe { _mm512_storeu_si512(bytes.as_mut_ptr().cast(), whole) };
    }
    let planes = planes.map(|plane| &plane[64 * blocks..]);
    super::select(
        cube,
        planes,
        rest,
        words.get_mut(blocks..).unwrap_or(&mut []),
    );
}

/// Which of 64 pixels may be in ranges of these outlines.
#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512vbmi")]
fn outlined_512(outlines: &[Outline], channels: [&[u8; 64]; 3]) -> u64 {
    if outlines.is_empty() {
        return u64::MAX;
    }
    // SAFETY: the arrays are 64 bytes long.
    let [r, g, b] = channels.map(|channel| unsafe { _mm512_loadu_si512(channel.as_ptr().cast()) });
    let largest = _mm512_max_epu8(r, _mm512_max_epu8(g, b));
    let smallest = _mm512_min_epu8(r, _mm512_min_epu8(g, b));
    let steps = _mm512_srli_epi16(largest, 3);
    let down = [(r, g), (g, b), (b, r)].map(|(a, b)| _mm512_cmpge_epu8_mask(a, b));
    let up = [(r, g), (g, b), (b, r)].map(|(a, b)| _mm512_cmple_epu8_mask(a, b));
    let within = |levels, [least, most]: [__m512i; 2]| {
        _mm512_cmpge_epu8_mask(levels, least) & _mm512_cmple_epu8_mask(levels, most)
    };
    outlines.iter().fold(0, |may, outline| {
        let ends = outline
            .largest
            .map(|level| _mm512_set1_epi8(level.cast_signed()));
        let of_smallest = outline.smallest.each_ref().map(|table| {
            // SAFETY: the table is 32 bytes long.
            let half = unsafe { _mm256_loadu_si256(table.as_ptr().cast()) };
            _mm512_permutexvar_epi8(steps, _mm512_broadcast_i64x4(half))
        });
        let in_order = outline.in_order(down, up);
        may | within(largest, ends) & within(smallest, of_smallest) & in_order
    })
}

/// What [`among`] finds, sixteen pixels at a time.
#[target_feature(enable = "avx512f,avx512bw,avx512vbmi")]
fn gather(may: u64, answers: &[u64; 1 << 18], planes: [&[u8; 64]; 3]) -> u64 {
    let mut word = 0;
    for from in [0, 16, 32, 48] {
        let some = (may >> from) as u16;
        if some == 0 {
            continue;
        }
        let [a, b, c] = planes.map(|plane| {
            // SAFETY: the slice is 16 bytes long.
            _mm512_cvtepu8_epi32(unsafe { _mm_loadu_si128(plane[from..][..16].as_ptr().cast()) })
        });
        let row = _mm512_or_si512(_mm512_slli_epi32(a, 8), b);
        let place = _mm512_or_si512(_mm512_slli_epi32(row, 3), _mm512_srli_epi32(c, 5));
        let none = _mm512_setzero_si512();
        // SAFETY: a place is below 2¹⁹, and as many halves of words there are.
        let bits =
            unsafe { _mm512_mask_i32gather_epi32::<4>(none, some, place, answers.as_ptr().cast()) };
        let level = _mm512_and_si512(c, _mm512_set1_epi32(31));
        let is_in = _mm512_test_epi32_mask(bits, _mm512_sllv_epi32(_mm512_set1_epi32(1), level));
        word |= u64::from(is_in) << from;
    }
    word
}

#[target_feature(enable = "avx2")]
fn split_three_256(row: &[u8], [first, second, third]: [&mut [u8]; 3]) {
    const ORDERS: [[u8; 16]; 3] = orders();
    let twice = |bytes: &[u8; 16]| {
        // SAFETY: the array is 16 bytes long.
        _mm256_broadcastsi128_si256(unsafe { _mm_loadu_si128(bytes.as_ptr().cast()) })
    };
    let orders = ORDERS.each_ref().map(twice);
    let lanes =
        |rest: usize| -> [u8; 16] { std::array::from_fn(|i| if i % 3 == rest { 0xFF } else { 0 }) };
    let [zero, one, two] = [0, 1, 2].map(|rest| twice(&lanes(rest)));
    let (blocks, rest) = row.as_chunks::<96>();
    let (firsts, first_rest) = first.as_chunks_mut::<32>();
    let (seconds, second_rest) = second.as_chunks_mut::<32>();
    let (thirds, third_rest) = third.as_chunks_mut::<32>();
    for (((block, first), second), third) in blocks.iter().zip(firsts).zip(seconds).zip(thirds) {
        // Each half of a register is a block of 16 pixels of its own.
        let [a, b, c] = [0, 16, 32].map(|at| {
            let low = block.as_ptr().wrapping_add(at).cast();
            let high = block.as_ptr().wrapping_add(at + 48).cast();
            // SAFETY: a block is 96 bytes long, and 32 + 48 + 16 are as many.
            unsafe { _mm256_loadu2_m128i(high, low) }
        });
        let blend =
            |from_b, from_c| _mm256_blendv_epi8(_mm256_blendv_epi8(a, b, from_b), c, from_c);
        let channels = [blend(two, one), blend(zero, two), blend(one, zero)];
        for ((out, channel), order) in [first, second, third].into_iter().zip(channels).zip(orders)
        {
            let ordered = _mm256_shuffle_epi8(channel, order);
            // SAFETY: `out` is 32 bytes long.
            unsafe { _mm256_storeu_si256(out.as_mut_ptr().cast(), ordered) };
        }
    }
    super::split_three(rest, [first_rest, second_rest, third_rest]);
}

/// Both halves of a table of 32 bytes, each in either half of a register.
#[inline]
#[target_feature(enable = "avx2")]
fn halves(table: &[u8; STEPS]) -> [__m256i; 2] {
    [0, 16].map(|from| {
        // SAFETY: half of the table is 16 bytes long.
        let half = unsafe { _mm_loadu_si128(table[from..][..16].as_ptr().cast()) };
        _mm256_broadcastsi128_si256(half)
    })
}

/// Half of 64 levels.
#[inline]
#[target_feature(enable = "avx2")]
fn levels(channel: &[u8; 64], half: usize) -> __m256i {
    // SAFETY: half of the array is 32 bytes long.
    unsafe { _mm256_loadu_si256(channel[32 * half..][..32].as_ptr().cast()) }
}

/// What a table has for the steps of some levels.
#[inline]
#[target_feature(enable = "avx2")]
fn at_steps(levels: __m256i, table: [__m256i; 2]) -> __m256i {
    let steps = _mm256_and_si256(_mm256_srli_epi16(levels, 3), _mm256_set1_epi8(15));
    // A level's highest bit says in which half of the table its step is.
    let [low, high] = table.map(|half| _mm256_shuffle_epi8(half, steps));
    _mm256_blendv_epi8(low, high, levels)
}

/// As [`outlined_512`].
#[inline]
#[target_feature(enable = "avx2")]
fn outlined_256(outlines: &[Outline], channels: [&[u8; 64]; 3]) -> u64 {
    if outlines.is_empty() {
        return u64::MAX;
    }
    let mut all = 0;
    for half in 0..2 {
        let [r, g, b] = channels.map(|channel| levels(channel, half));
        let no_less = |a, b| {
            let equal = _mm256_cmpeq_epi8(_mm256_max_epu8(a, b), a);
            u64::from(_mm256_movemask_epi8(equal).cast_unsigned())
        };
        let largest = _mm256_max_epu8(r, _mm256_max_epu8(g, b));
        let smallest = _mm256_min_epu8(r, _mm256_min_epu8(g, b));
        let down = [no_less(r, g), no_less(g, b), no_less(b, r)];
        let up = [no_less(g, r), no_less(b, g), no_less(r, b)];
        let within =
            |levels, [least, most]: [__m256i; 2]| no_less(levels, least) & no_less(most, levels);
        let may = outlines.iter().fold(0, |may, outline| {
            let ends = outline
                .largest
                .map(|level| _mm256_set1_epi8(level.cast_signed()));
            let of_smallest =
                (outline.smallest.each_ref()).map(|table| at_steps(largest, halves(table)));
            let in_order = outline.in_order(down, up);
            may | within(largest, ends) & within(smallest, of_smallest) & in_order
        });
        all |= may << (32 * half);
    }
    all
}

#[target_feature(enable = "avx2")]
fn select_256(cube: &Cube, planes: [&[u8]; 3], inside: &mut [u8], words: &mut [u64]) {
    let tables = cube.bands.each_ref().map(|bands| halves(bands));
    let blocks = inside.len() / 64;
    let [a, b, c] = planes.map(|plane| plane.as_chunks::<64>().0);
    let (bytes, rest) = inside.as_chunks_mut::<64>();
    for ((bytes, word), ((a, b), c)) in bytes
        .iter_mut()
        .zip(&mut *words)
        .zip(a.iter().zip(b).zip(c))
    {
        let bands = |channel: &[u8; 64], half: usize, table| at_steps(levels(channel, half), table);
        let mut may = 0;
        for half in 0..2 {
            let common = _mm256_and_si256(bands(a, half, tables[0]), bands(b, half, tables[1]));
            let common = _mm256_and_si256(common, bands(c, half, tables[2]));
            let none = _mm256_cmpeq_epi8(common, _mm256_setzero_si256());
            let some = !_mm256_movemask_epi8(none).cast_unsigned();
            may |= u64::from(some) << (32 * half);
        }
        if may != 0 {
            may &= outlined_256(&cube.outlines, [a, b, c]);
        }
        *word = among(may, cube, [a, b, c]);
        bytes.fill(0);
        if *word != 0 {
            for (x, byte) in bytes.iter_mut().enumerate() {
                *byte = if *word >> x & 1 == 1 { 255 } else { 0 };
            }
        }
    }
    let planes = planes.map(|plane| &plane[64 * blocks..]);
    super::select(
        cube,
        planes,
        rest,
        words.get_mut(blocks..).unwrap_or(&mut []),
    );
}
