//! Kernels for the registers of x86-64: 64 bytes (AVX-512 with VBMI) or 32 (AVX2) at a time.
//!
//! `unsafe` is needed to call functions compiled for registers that not every machine has, after
//! checking that this one has them. It is also needed to load and store through pointers, which
//! come from arrays as long as the data moved.
//!
//! Three interleaved channels A, B, C fill three registers of 16 or 64 lanes. Both numbers leave 1
//! when divided by 3. Lane i of the three registers therefore holds channels i, i + 1 and i + 2
//! (mod 3). Blending them by lanes gathers all bytes of a channel in one register, and one
//! permutation puts them in order.
//!
//! Looking up the bands of 64 levels takes one permutation of a register that holds the table
//! twice. The permutation's index has six bits, and the highest is not part of the level. Looking
//! up the bands of 32 levels takes two shuffles of 16 and a blend.
#![allow(unsafe_code)]

use super::{Kernels, PLAIN, among};
use crate::image::kernels::{channels_256, orders, pixels_256, twice};
use crate::mask::hsv::cube::{BANDS, Cube, STEPS};
use crate::mask::hsv::outline::Outline;
use std::arch::x86_64::*;

/// Maximum number of pixels, of 64, that are looked up one by one. This is faster than setting up a
/// gather of sixteen.
const FEW: u32 = 8;

/// The fastest kernels that this machine can run.
pub(super) fn detect() -> Option<Kernels> {
    all().next()
}

/// All kernels that this machine can run, the fastest first.
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
    // Masks of the lanes i = 0, 1 and 2 (mod 3).
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
        // Channel 0 is in lane i of a where i = 0 (mod 3), of b where i = 2, of c where i = 1.
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

/// Returns which of 64 pixels may be in ranges with these outlines.
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

/// As [`among`], sixteen pixels at a time.
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
        // SAFETY: a place is below 2¹⁹, the number of half words.
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
    let (blocks, rest) = row.as_chunks::<96>();
    let (firsts, first_rest) = first.as_chunks_mut::<32>();
    let (seconds, second_rest) = second.as_chunks_mut::<32>();
    let (thirds, third_rest) = third.as_chunks_mut::<32>();
    for (((block, first), second), third) in blocks.iter().zip(firsts).zip(seconds).zip(thirds) {
        let [a, b, c] = channels_256(pixels_256(block));
        // SAFETY: the arrays are 32 bytes long.
        unsafe {
            _mm256_storeu_si256(first.as_mut_ptr().cast(), a);
            _mm256_storeu_si256(second.as_mut_ptr().cast(), b);
            _mm256_storeu_si256(third.as_mut_ptr().cast(), c);
        }
    }
    super::split_three(rest, [first_rest, second_rest, third_rest]);
}

/// A table of 32 bytes, each of its halves in both halves of a register.
type Table = [__m256i; 2];

// No closures are passed on here, for example to `map`: they would not be inlined, and the calls
// would cost more than the work.
#[inline]
#[target_feature(enable = "avx2")]
fn table(bytes: &[u8; STEPS]) -> Table {
    let [low, high] = bytes.as_chunks().0 else {
        unreachable!("a table has two halves");
    };
    [twice(low), twice(high)]
}

/// Looks up the steps of some levels in a table.
#[inline]
#[target_feature(enable = "avx2")]
fn at_steps(levels: __m256i, [low, high]: Table) -> __m256i {
    let steps = _mm256_and_si256(_mm256_srli_epi16(levels, 3), _mm256_set1_epi8(15));
    // A level's highest bit selects the half of the table that has its step.
    let (low, high) = (
        _mm256_shuffle_epi8(low, steps),
        _mm256_shuffle_epi8(high, steps),
    );
    _mm256_blendv_epi8(low, high, levels)
}

/// Returns where one level is at least another, one bit each.
#[inline]
#[target_feature(enable = "avx2")]
fn no_less(a: __m256i, b: __m256i) -> u64 {
    let equal = _mm256_cmpeq_epi8(_mm256_max_epu8(a, b), a);
    u64::from(_mm256_movemask_epi8(equal).cast_unsigned())
}

/// An outline in registers.
#[derive(Clone, Copy)]
struct Ends {
    largest: [__m256i; 2],
    smallest: [Table; 2],
}

#[inline]
#[target_feature(enable = "avx2")]
fn ends(outline: &Outline) -> Ends {
    let [least, most] = outline.largest;
    let [low, high] = &outline.smallest;
    Ends {
        largest: [
            _mm256_set1_epi8(least.cast_signed()),
            _mm256_set1_epi8(most.cast_signed()),
        ],
        smallest: [table(low), table(high)],
    }
}

/// As [`outlined_512`], for 32 pixels.
#[inline]
#[target_feature(enable = "avx2")]
fn outlined_256(outlines: &[Outline], of: &[Ends; BANDS], [r, g, b]: [__m256i; 3]) -> u64 {
    let largest = _mm256_max_epu8(r, _mm256_max_epu8(g, b));
    let smallest = _mm256_min_epu8(r, _mm256_min_epu8(g, b));
    let down = [no_less(r, g), no_less(g, b), no_less(b, r)];
    let up = [no_less(g, r), no_less(b, g), no_less(r, b)];
    let mut may = 0;
    for (outline, ends) in outlines.iter().zip(of) {
        let [least, most] = ends.largest;
        let is_light = no_less(largest, least) & no_less(most, largest);
        let (low, high) = (
            at_steps(largest, ends.smallest[0]),
            at_steps(largest, ends.smallest[1]),
        );
        let is_dull = no_less(smallest, low) & no_less(high, smallest);
        may |= is_light & is_dull & outline.in_order(down, up);
    }
    may
}

/// One byte per bit: 255 or 0.
#[inline]
#[target_feature(enable = "avx2")]
fn bytes_of(bits: u32) -> __m256i {
    let all = _mm256_set1_epi32(bits.cast_signed());
    // Repeat each of four bytes eight times.
    let [first, second] = [0x0101_0101_0101_0101, 0x0303_0303_0303_0303];
    let order = _mm256_setr_epi64x(0, first, 2 * first, second);
    let own = _mm256_set1_epi64x(0x8040_2010_0804_0201u64.cast_signed());
    _mm256_cmpeq_epi8(_mm256_and_si256(_mm256_shuffle_epi8(all, order), own), own)
}

#[target_feature(enable = "avx2")]
fn select_256(cube: &Cube, planes: [&[u8]; 3], inside: &mut [u8], words: &mut [u64]) {
    let [first, second, third] = [
        table(&cube.bands[0]),
        table(&cube.bands[1]),
        table(&cube.bands[2]),
    ];
    let nothing = _mm256_setzero_si256();
    let mut outlines = [Ends {
        largest: [nothing; 2],
        smallest: [[nothing; 2]; 2],
    }; BANDS];
    for (of, outline) in outlines.iter_mut().zip(&cube.outlines) {
        *of = ends(outline);
    }
    let blocks = inside.len() / 64;
    let [a, b, c] = planes.map(|plane| plane.as_chunks::<64>().0);
    let (bytes, rest) = inside.as_chunks_mut::<64>();
    for ((bytes, word), ((a, b), c)) in bytes
        .iter_mut()
        .zip(&mut *words)
        .zip(a.iter().zip(b).zip(c))
    {
        let mut may = 0;
        for from in [0, 32] {
            // SAFETY: the arrays are 64 bytes long.
            let [a, b, c] = unsafe {
                [
                    _mm256_loadu_si256(a.as_ptr().add(from).cast()),
                    _mm256_loadu_si256(b.as_ptr().add(from).cast()),
                    _mm256_loadu_si256(c.as_ptr().add(from).cast()),
                ]
            };
            let common = _mm256_and_si256(at_steps(a, first), at_steps(b, second));
            let common = _mm256_and_si256(common, at_steps(c, third));
            let none = _mm256_cmpeq_epi8(common, nothing);
            let mut some = u64::from(!_mm256_movemask_epi8(none).cast_unsigned());
            if some != 0 && !cube.outlines.is_empty() {
                some &= outlined_256(&cube.outlines, &outlines, [a, b, c]);
            }
            may |= some << from;
        }
        *word = among(may, cube, [a, b, c]);
        for from in [0, 32] {
            // SAFETY: the array is 64 bytes long.
            unsafe {
                let out = bytes.as_mut_ptr().add(from).cast();
                _mm256_storeu_si256(out, bytes_of((*word >> from) as u32));
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
