//! Kernels in registers of 64 bytes: AVX-512 with VBMI and VBMI2.
//!
//! `unsafe` is needed to load and store through pointers, which come from slices as long as the
//! data moved.
#![allow(unsafe_code)]

use super::x86::orders;
use super::{Band, Patch, Rows};
use crate::image::PixelFormat;
use std::arch::x86_64::*;

/// Constants that sort interleaved pixels into channels: the order of lanes for each channel, and
/// masks of the lanes i = 0, 1 and 2 (mod 3).
struct Sorting {
    orders: [__m512i; 3],
    lanes: [u64; 3],
}

impl Sorting {
    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vbmi")]
    fn new() -> Self {
        const ORDERS: [[u8; 64]; 3] = orders();
        const LANES: u64 = 0x9249_2492_4924_9249;
        let [first, second, third] = &ORDERS;
        Self {
            orders: [load(first), load(second), load(third)],
            lanes: [LANES, LANES << 1, LANES << 2],
        }
    }

    /// Largest difference among the three channels, for 64 pixels.
    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512vbmi")]
    fn most(&self, pixels: [__m512i; 3], table: [__m512i; 3]) -> __m512i {
        let [p, q, r] = pixels;
        let [t, u, v] = table;
        let (a, b, c) = (apart(p, t), apart(q, u), apart(r, v));
        // Channel 0 is in lane i of a where i = 0 (mod 3), of b where i = 2, of c where i = 1.
        let [zero, one, two] = self.lanes;
        let first = choose(one, choose(two, a, b), c);
        let second = choose(two, choose(zero, a, b), c);
        let third = choose(zero, choose(one, a, b), c);
        let first = _mm512_permutexvar_epi8(self.orders[0], first);
        let second = _mm512_permutexvar_epi8(self.orders[1], second);
        let third = _mm512_permutexvar_epi8(self.orders[2], third);
        _mm512_max_epu8(first, _mm512_max_epu8(second, third))
    }
}

/// Selects bytes of `there` in the set `lanes`, and of `elsewhere` in the others.
#[inline]
#[target_feature(enable = "avx512f,avx512bw")]
fn choose(lanes: u64, elsewhere: __m512i, there: __m512i) -> __m512i {
    _mm512_mask_blend_epi8(lanes, elsewhere, there)
}

#[inline]
#[target_feature(enable = "avx512f,avx512bw")]
fn apart(p: __m512i, t: __m512i) -> __m512i {
    _mm512_or_si512(_mm512_subs_epu8(p, t), _mm512_subs_epu8(t, p))
}

#[inline]
#[target_feature(enable = "avx512f,avx512bw")]
fn load(bytes: &[u8; 64]) -> __m512i {
    // SAFETY: the array is 64 bytes long.
    unsafe { _mm512_loadu_si512(bytes.as_ptr().cast()) }
}

/// Loads the first `count` bytes, at most 64, followed by zeros.
#[inline]
#[target_feature(enable = "avx512f,avx512bw")]
fn load_some(bytes: &[u8], count: usize) -> __m512i {
    let bytes = &bytes[..count];
    // SAFETY: no more is loaded than the slice holds.
    unsafe { _mm512_maskz_loadu_epi8(first_lanes(count), bytes.as_ptr().cast()) }
}

/// Mask of the first `count` lanes, at most 64.
#[inline]
fn first_lanes(count: usize) -> u64 {
    u64::MAX.checked_shr(64 - count as u32).unwrap_or(0)
}

/// Loads the 192 bytes of 64 pixels.
#[inline]
#[target_feature(enable = "avx512f,avx512bw")]
fn load_pixels(bytes: &[u8; 192]) -> [__m512i; 3] {
    // SAFETY: each load is of 64 of 192 bytes.
    unsafe {
        let at = bytes.as_ptr();
        [
            _mm512_loadu_si512(at.cast()),
            _mm512_loadu_si512(at.add(64).cast()),
            _mm512_loadu_si512(at.add(128).cast()),
        ]
    }
}

/// Loads fewer than 64 pixels from `bytes`, followed by zeros.
#[inline]
#[target_feature(enable = "avx512f,avx512bw")]
fn load_some_pixels(bytes: &[u8], pixels: usize) -> [__m512i; 3] {
    let (low, rest) = bytes[..3 * pixels].split_at((3 * pixels).min(64));
    let (middle, high) = rest.split_at(rest.len().min(64));
    [
        load_some(low, low.len()),
        load_some(middle, middle.len()),
        load_some(high, high.len()),
    ]
}

#[inline]
#[target_feature(enable = "avx512f,avx512bw")]
fn store(bytes: &mut [u8; 64], of: __m512i) {
    // SAFETY: the array is 64 bytes long.
    unsafe { _mm512_storeu_si512(bytes.as_mut_ptr().cast(), of) };
}

/// Stores as many bytes as `bytes` has, fewer than 64.
#[inline]
#[target_feature(enable = "avx512f,avx512bw")]
fn store_some(bytes: &mut [u8], of: __m512i) {
    // SAFETY: no more is stored than the slice holds.
    unsafe { _mm512_mask_storeu_epi8(bytes.as_mut_ptr().cast(), first_lanes(bytes.len()), of) };
}

#[target_feature(enable = "avx512f,avx512bw,avx512vbmi")]
pub(super) fn three_channels(row: &[u8], table: &[u8], out: &mut [u8]) {
    let sorting = Sorting::new();
    let pixels = out.len().min(row.len() / 3).min(table.len() / 3);
    let (blocks, rest) = out[..pixels].as_chunks_mut::<64>();
    let done = 192 * blocks.len();
    let rows = row.as_chunks::<192>().0.iter();
    let rows = rows.zip(table.as_chunks::<192>().0);
    for (out, (row, table)) in blocks.iter_mut().zip(rows) {
        store(out, sorting.most(load_pixels(row), load_pixels(table)));
    }
    if !rest.is_empty() {
        let row = load_some_pixels(&row[done..], rest.len());
        let table = load_some_pixels(&table[done..], rest.len());
        store_some(rest, sorting.most(row, table));
    }
}

#[target_feature(enable = "avx512f,avx512bw,avx512vbmi")]
pub(super) fn three_channel_band(band: Band) {
    let sorting = Sorting::new();
    let least = _mm512_set1_epi8(band.least.cast_signed());
    let words = band.width.div_ceil(64);
    let out = band.out.chunks_mut(band.out_stride);
    let faint = band.faint.chunks_mut(band.faint_stride);
    let tables = band.table.as_chunks::<192>().0;
    for (i, (out, faint)) in out.zip(faint).enumerate() {
        let row = &band.rows[i * band.stride..][..3 * band.width];
        let faint = &mut faint[..words];
        let (blocks, rest) = out[..band.width].as_chunks_mut::<64>();
        let done = blocks.len();
        let rows = row.as_chunks::<192>().0.iter().zip(tables);
        for ((out, faint), (row, table)) in blocks.iter_mut().zip(&mut *faint).zip(rows) {
            let most = sorting.most(load_pixels(row), load_pixels(table));
            store(out, most);
            *faint = _mm512_cmpge_epu8_mask(most, least);
        }
        if !rest.is_empty() {
            let row = load_some_pixels(&row[192 * done..], rest.len());
            let table = load_some_pixels(&band.table[192 * done..], rest.len());
            let most = sorting.most(row, table);
            store_some(rest, most);
            faint[done] = _mm512_cmpge_epu8_mask(most, least) & first_lanes(rest.len());
        }
    }
}

/// Largest difference among Y, U and V, for 64 pixels, 32 of them in each of two registers.
///
/// The pixels are Y₀ U Y₁ V if `LIGHT` is 0, and U Y₀ V Y₁ if it is 1. `every` gathers the bytes of
/// Y.
#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512vbmi")]
fn most_of_pairs<const LIGHT: usize>(
    [p, q]: [__m512i; 2],
    [t, u]: [__m512i; 2],
    every: __m512i,
) -> __m512i {
    let (low, high) = (most_beside::<LIGHT>(p, t), most_beside::<LIGHT>(q, u));
    _mm512_permutex2var_epi8(low, every, high)
}

/// Largest difference among Y, U and V, for one register, in its bytes of Y.
#[inline]
#[target_feature(enable = "avx512f,avx512bw")]
fn most_beside<const LIGHT: usize>(p: __m512i, t: __m512i) -> __m512i {
    let off = apart(p, t);
    let color = if LIGHT == 0 {
        _mm512_srli_epi16::<8>(off)
    } else {
        _mm512_slli_epi16::<8>(off)
    };
    let color = _mm512_max_epu8(color, _mm512_rol_epi32::<16>(color));
    // U and V count double.
    _mm512_max_epu8(off, _mm512_adds_epu8(color, color))
}

#[target_feature(enable = "avx512f,avx512bw,avx512vbmi")]
pub(super) fn pairs_band<const LIGHT: usize>(band: Band) {
    let every = &const {
        let mut every = [0; 64];
        let mut k = 0;
        while k < 64 {
            every[k] = (2 * k + LIGHT) as u8;
            k += 1;
        }
        every
    };
    let every = load(every);
    let least = _mm512_set1_epi8(band.least.cast_signed());
    let words = band.width.div_ceil(64);
    let out = band.out.chunks_mut(band.out_stride);
    let faint = band.faint.chunks_mut(band.faint_stride);
    let tables = band.table.as_chunks::<64>().0.as_chunks::<2>().0;
    for (i, (out, faint)) in out.zip(faint).enumerate() {
        let row = &band.rows[i * band.stride..][..4 * band.width.div_ceil(2)];
        let faint = &mut faint[..words];
        let (blocks, rest) = out[..band.width].as_chunks_mut::<64>();
        let done = blocks.len();
        let rows = row
            .as_chunks::<64>()
            .0
            .as_chunks::<2>()
            .0
            .iter()
            .zip(tables);
        for ((out, faint), (row, table)) in blocks.iter_mut().zip(&mut *faint).zip(rows) {
            let row = [load(&row[0]), load(&row[1])];
            let most = most_of_pairs::<LIGHT>(row, [load(&table[0]), load(&table[1])], every);
            store(out, most);
            *faint = _mm512_cmpge_epu8_mask(most, least);
        }
        if !rest.is_empty() {
            let two = |bytes: &[u8]| {
                let (low, high) = bytes.split_at(bytes.len().min(64));
                [load_some(low, low.len()), load_some(high, high.len())]
            };
            let row = &row[128 * done..];
            let most = most_of_pairs::<LIGHT>(
                two(row),
                two(&band.table[128 * done..][..row.len()]),
                every,
            );
            store_some(rest, most);
            faint[done] = _mm512_cmpge_epu8_mask(most, least) & first_lanes(rest.len());
        }
    }
}

#[target_feature(enable = "avx512f,avx512bw")]
pub(super) fn look(look: Rows) {
    match look.bytes {
        1 => look_at::<1>(look),
        2 => look_at::<2>(look),
        _ => look_at::<3>(look),
    }
}

/// Searches pixels of `N` bytes. The table is the same for all rows, so the maximum and minimum of
/// each column of bytes suffice.
#[inline]
#[target_feature(enable = "avx512f,avx512bw")]
fn look_at<const N: usize>(look: Rows) {
    let least = _mm512_set1_epi16(i16::from_le_bytes(look.least));
    for (strip, hit) in look.hits.iter_mut().enumerate() {
        let from = 64 * N * strip;
        let count = (look.row - from).min(64 * N);
        let [mut most, mut fewest] = [[_mm512_setzero_si512(); N], [_mm512_set1_epi8(-1); N]];
        for row in look.rows[from..].chunks(look.stride) {
            let bytes = load_each::<N>(&row[..count]);
            for k in 0..N {
                most[k] = _mm512_max_epu8(most[k], bytes[k]);
                fewest[k] = _mm512_min_epu8(fewest[k], bytes[k]);
            }
        }
        let table = load_each::<N>(&look.table[from..][..count]);
        let mut off = [0; N];
        for k in 0..N {
            let above = _mm512_subs_epu8(most[k], table[k]);
            let below = _mm512_subs_epu8(table[k], fewest[k]);
            off[k] = _mm512_cmpge_epu8_mask(_mm512_max_epu8(above, below), least);
        }
        let side = Rows::SIDE * N;
        let any = off.iter().any(|&off| off != 0);
        let (left, right) = (off[0] << (64 - side), off[N - 1] >> (64 - side));
        *hit = u8::from(any) * Rows::ANY
            + u8::from(left != 0) * Rows::LEFT
            + u8::from(right != 0) * Rows::RIGHT;
    }
}

/// Loads up to 64 · `N` bytes, followed by zeros.
#[inline]
#[target_feature(enable = "avx512f,avx512bw")]
fn load_each<const N: usize>(bytes: &[u8]) -> [__m512i; N] {
    let mut each = [_mm512_setzero_si512(); N];
    if bytes.len() == 64 * N {
        for (each, bytes) in each.iter_mut().zip(bytes.as_chunks().0) {
            *each = load(bytes);
        }
    } else {
        for (each, bytes) in each.iter_mut().zip(bytes.chunks(64)) {
            *each = load_some(bytes, bytes.len());
        }
    }
    each
}

/// Permutations that produce the bytes of 8 blocks, 64 · `N` in all. Each block repeats its levels
/// in the order `channels`. The input register holds 8 levels of each channel, one channel after
/// the other.
const fn sources<const N: usize>(channels: &[u8]) -> [[u8; 64]; N] {
    let mut order = [[0; 64]; N];
    let mut k = 0;
    while k < 64 * N {
        // A block has 8 · N bytes.
        order[k / 64][k % 64] = 8 * channels[k % channels.len()] + (k / (8 * N)) as u8;
        k += 1;
    }
    order
}

#[target_feature(enable = "avx512f,avx512bw,avx512vbmi")]
pub(super) fn spread(format: PixelFormat, levels: [&[u8]; 3], luma: &mut [u8], chroma: &mut [u8]) {
    match format {
        PixelFormat::Gray8 => spread_one(&const { sources::<1>(&[0]) }, levels, luma),
        PixelFormat::Rgb8 => spread_one(&const { sources::<3>(&[0, 1, 2]) }, levels, luma),
        PixelFormat::Bgr8 => spread_one(&const { sources::<3>(&[2, 1, 0]) }, levels, luma),
        PixelFormat::Yuyv => spread_one(&const { sources::<2>(&[0, 1, 0, 2]) }, levels, luma),
        PixelFormat::Uyvy => spread_one(&const { sources::<2>(&[1, 0, 2, 0]) }, levels, luma),
        PixelFormat::Nv12 => {
            spread_one(&const { sources::<1>(&[0]) }, levels, luma);
            spread_one(&const { sources::<1>(&[1, 2]) }, levels, chroma);
        }
        // Other formats were unpacked earlier.
        _ => {}
    }
}

#[inline]
#[target_feature(enable = "avx512f,avx512bw,avx512vbmi")]
fn spread_one<const N: usize>(orders: &[[u8; 64]; N], [a, b, c]: [&[u8]; 3], out: &mut [u8]) {
    let levels = a.as_chunks::<8>().0.iter().zip(b.as_chunks::<8>().0);
    let levels = levels.zip(c.as_chunks::<8>().0);
    let (out, _) = out.as_chunks_mut::<64>();
    for (out, ((a, b), c)) in out.chunks_exact_mut(N).zip(levels) {
        let [a, b, c] = [
            i64::from_le_bytes(*a),
            i64::from_le_bytes(*b),
            i64::from_le_bytes(*c),
        ];
        let levels = _mm512_set_epi64(0, 0, 0, 0, 0, c, b, a);
        for (out, order) in out.iter_mut().zip(orders) {
            store(out, _mm512_permutexvar_epi8(load(order), levels));
        }
    }
}

/// Permutation that packs 16 pixels: of each four bytes, the third, the second and the first.
const PACKED: [u8; 64] = {
    let mut order = [0; 64];
    let mut k = 0;
    while k < 48 {
        order[k] = (4 * (k / 3) + 2 - k % 3) as u8;
        k += 1;
    }
    order
};

#[target_feature(enable = "avx512f,avx512bw,avx512vbmi")]
pub(super) fn pack(pixels: &[[u8; 4]], out: &mut [u8]) {
    let order = load(&PACKED);
    for (out, pixels) in out.chunks_mut(48).zip(pixels.chunks(16)) {
        let bytes = load_some(pixels.as_flattened(), 4 * pixels.len());
        let count = out.len().min(3 * pixels.len());
        store_some(&mut out[..count], _mm512_permutexvar_epi8(order, bytes));
    }
}

#[target_feature(enable = "avx512f,avx512bw,avx512vbmi2,popcnt")]
pub(super) fn collect(row: &[u8], bits: &[u64], out: &mut [u8]) -> usize {
    let mut count = 0;
    // Most words are 0. Find the others in groups of 64.
    for (bits, row) in bits.chunks(64).zip(row.chunks(64 * 64)) {
        let mut rest = 0;
        for (i, &word) in bits.iter().enumerate() {
            rest |= u64::from(word != 0) << i;
        }
        while rest != 0 {
            let i = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            let pixels = &row[64 * i..];
            let bytes = load_some(pixels, pixels.len().min(64));
            if let Some(out) = out[count..].first_chunk_mut() {
                store(out, _mm512_maskz_compress_epi8(bits[i], bytes));
            }
            count += bits[i].count_ones() as usize;
        }
    }
    count
}

#[target_feature(enable = "avx512f,avx512bw")]
pub(super) fn patch_at_least(patch: Patch, cut: u8, words: &mut [u64]) {
    let level = _mm512_set1_epi8(cut.cast_signed());
    let rows = patch.bytes.chunks(patch.stride);
    let lanes = first_lanes(patch.width);
    for (word, row) in words.iter_mut().zip(rows) {
        let bytes = load_some(row, patch.width);
        *word = _mm512_mask_cmpge_epu8_mask(lanes, bytes, level);
    }
}

#[target_feature(enable = "avx512f,avx512bw")]
pub(super) fn at_least(row: &[u8], cut: u8, words: &mut [u64]) -> u64 {
    let level = _mm512_set1_epi8(cut.cast_signed());
    let mut sums = _mm512_setzero_si512();
    let (blocks, rest) = row.as_chunks::<64>();
    for (word, block) in words.iter_mut().zip(blocks) {
        // SAFETY: a block is 64 bytes long.
        let bytes = unsafe { _mm512_loadu_si512(block.as_ptr().cast()) };
        *word = _mm512_cmpge_epu8_mask(bytes, level);
        sums = _mm512_add_epi64(sums, _mm512_sad_epu8(bytes, _mm512_setzero_si512()));
    }
    let sum = _mm512_reduce_add_epi64(sums).cast_unsigned();
    sum + super::at_least(rest, cut, words.get_mut(blocks.len()..).unwrap_or(&mut []))
}
