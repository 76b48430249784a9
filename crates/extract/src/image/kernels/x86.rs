//! Kernels for the registers of x86-64: 64 bytes at a time (AVX-512 with VBMI, in `wide`) or 32
//! (AVX2).
//!
//! `unsafe` is needed to call functions compiled for registers that not every machine has, after
//! checking that this one has them. It is also needed to load and store through pointers, which
//! come from slices as long as the data moved.
//!
//! Three interleaved channels A, B, C fill three registers of 16 or 64 lanes. Both numbers leave 1
//! when divided by 3. Lane i of the three registers therefore holds channels i, i + 1 and i + 2
//! (mod 3). Blending them by lanes gathers all bytes of a channel in one register, and one
//! permutation puts them in order.
#![allow(unsafe_code)]

use super::{Band, Kernels, Patch, wide};
use std::arch::x86_64::*;

/// The fastest kernels that this machine can run.
pub(super) fn detect() -> Option<Kernels> {
    all().next()
}

/// All kernels that this machine can run, the fastest first.
pub(super) fn all() -> impl Iterator<Item = Kernels> {
    let wide = is_x86_feature_detected!("avx512bw")
        && is_x86_feature_detected!("avx512vbmi")
        && is_x86_feature_detected!("avx512vbmi2")
        && is_x86_feature_detected!("popcnt");
    let medium = is_x86_feature_detected!("avx2");
    let wide = wide.then_some(Kernels {
        // SAFETY: the machine has AVX-512BW, VBMI and VBMI2.
        three_channels: |row, table, out| unsafe { wide::three_channels(row, table, out) },
        // SAFETY: as above.
        spread: |format, levels, luma, chroma| unsafe {
            wide::spread(format, levels, luma, chroma)
        },
        // SAFETY: as above.
        three_channel_band: |band| unsafe { wide::three_channel_band(band) },
        // SAFETY: as above.
        yuyv_band: Some(|band| unsafe { wide::pairs_band::<0>(band) }),
        // SAFETY: as above.
        uyvy_band: Some(|band| unsafe { wide::pairs_band::<1>(band) }),
        // SAFETY: as above.
        look: |look| unsafe { wide::look(look) },
        // SAFETY: as above.
        pack: |pixels, out| unsafe { wide::pack(pixels, out) },
        // SAFETY: as above.
        collect: |row, bits, out| unsafe { wide::collect(row, bits, out) },
        // SAFETY: as above.
        patch_at_least: |patch, cut, words| unsafe { wide::patch_at_least(patch, cut, words) },
        // SAFETY: as above.
        at_least: |row, cut, words| unsafe { wide::at_least(row, cut, words) },
    });
    let medium = medium.then_some(Kernels {
        // SAFETY: the machine has AVX2.
        three_channels: |row, table, out| unsafe { three_channels_256(row, table, out) },
        spread: super::spread::spread,
        // SAFETY: as above.
        three_channel_band: |band| unsafe { three_channel_band_256(band) },
        yuyv_band: None,
        uyvy_band: None,
        look: super::scan::look,
        // SAFETY: as above.
        pack: |pixels, out| unsafe { pack_128(pixels, out) },
        collect: super::collect,
        // SAFETY: as above.
        patch_at_least: |patch, cut, words| unsafe { patch_at_least_256(patch, cut, words) },
        // SAFETY: as above.
        at_least: |row, cut, words| unsafe { at_least_256(row, cut, words) },
    });
    wide.into_iter().chain(medium)
}

/// Separates three registers of interleaved channels into one register per channel. Each half has
/// 16 pixels.
#[inline]
#[target_feature(enable = "avx2")]
pub(crate) fn channels_256([a, b, c]: [__m256i; 3]) -> [__m256i; 3] {
    const ORDERS: [[u8; 16]; 3] = orders();
    const LANES: [[u8; 16]; 3] = {
        let mut lanes = [[0; 16]; 3];
        let mut i = 0;
        while i < 16 {
            lanes[i % 3][i] = 0xFF;
            i += 1;
        }
        lanes
    };
    let (zero, one, two) = (twice(&LANES[0]), twice(&LANES[1]), twice(&LANES[2]));
    let first = _mm256_blendv_epi8(_mm256_blendv_epi8(a, b, two), c, one);
    let second = _mm256_blendv_epi8(_mm256_blendv_epi8(a, b, zero), c, two);
    let third = _mm256_blendv_epi8(_mm256_blendv_epi8(a, b, one), c, zero);
    [
        _mm256_shuffle_epi8(first, twice(&ORDERS[0])),
        _mm256_shuffle_epi8(second, twice(&ORDERS[1])),
        _mm256_shuffle_epi8(third, twice(&ORDERS[2])),
    ]
}

/// Repeats 16 bytes in both halves of a register.
#[inline]
#[target_feature(enable = "avx2")]
pub(crate) fn twice(bytes: &[u8; 16]) -> __m256i {
    // SAFETY: the array is 16 bytes long.
    _mm256_broadcastsi128_si256(unsafe { _mm_loadu_si128(bytes.as_ptr().cast()) })
}

/// Loads 32 pixels of three interleaved channels. The two halves of the registers hold 16 pixels
/// each.
#[inline]
#[target_feature(enable = "avx2")]
pub(crate) fn pixels_256(bytes: &[u8; 96]) -> [__m256i; 3] {
    let (low, high) = (bytes.as_ptr(), bytes[48..].as_ptr());
    // SAFETY: both halves of the array are 3 × 16 bytes long.
    unsafe {
        [
            _mm256_loadu2_m128i(high.cast(), low.cast()),
            _mm256_loadu2_m128i(high.add(16).cast(), low.add(16).cast()),
            _mm256_loadu2_m128i(high.add(32).cast(), low.add(32).cast()),
        ]
    }
}

// No closures are passed on here, for example to `map`: they would not be inlined, and the calls
// would cost more than the work.
#[inline]
#[target_feature(enable = "avx2")]
fn three_channels_256(row: &[u8], table: &[u8], out: &mut [u8]) {
    let pixels = out.len().min(row.len() / 3).min(table.len() / 3);
    let mut x = 0;
    while let (Some(p), Some(t), Some(out)) = (
        row[3 * x..].first_chunk(),
        table[3 * x..].first_chunk(),
        out[x..pixels].first_chunk_mut::<32>(),
    ) {
        let ([p0, p1, p2], [t0, t1, t2]) = (pixels_256(p), pixels_256(t));
        let [a, b, c] = channels_256([apart(p0, t0), apart(p1, t1), apart(p2, t2)]);
        let most = _mm256_max_epu8(a, _mm256_max_epu8(b, c));
        // SAFETY: `out` is 32 bytes long.
        unsafe { _mm256_storeu_si256(out.as_mut_ptr().cast(), most) };
        x += 32;
        // The last block is moved back to end with the row.
        if x < pixels && x + 32 > pixels {
            x = pixels - 32;
        }
    }
    super::three_channels(&row[3 * x..], &table[3 * x..], &mut out[x..]);
}

/// Absolute differences of bytes.
#[inline]
#[target_feature(enable = "avx2")]
fn apart(a: __m256i, b: __m256i) -> __m256i {
    _mm256_sub_epi8(_mm256_max_epu8(a, b), _mm256_min_epu8(a, b))
}

#[target_feature(enable = "avx2")]
fn three_channel_band_256(band: Band) {
    let least = band.least;
    band.for_each_row(|row, table, out, faint| {
        three_channels_256(row, table, out);
        at_least_256(out, least, faint);
    });
}

/// Packs four pixels at a time. Each store writes four bytes too many, which the next one
/// overwrites.
#[target_feature(enable = "avx2")]
fn pack_128(pixels: &[[u8; 4]], out: &mut [u8]) {
    let order = _mm_setr_epi8(2, 1, 0, 6, 5, 4, 10, 9, 8, 14, 13, 12, -1, -1, -1, -1);
    let pixels = &pixels[..pixels.len().min(out.len() / 3)];
    let mut done = 0;
    for four in pixels.as_chunks::<4>().0 {
        // Nothing is written past the pixels' own place.
        if 3 * done + 16 > 3 * pixels.len() {
            break;
        }
        let out = &mut out[3 * done..][..16];
        // SAFETY: four pixels are 16 bytes long, and so is `out`.
        unsafe {
            let bytes = _mm_loadu_si128(four.as_ptr().cast());
            _mm_storeu_si128(out.as_mut_ptr().cast(), _mm_shuffle_epi8(bytes, order));
        }
        done += 4;
    }
    super::pack(&pixels[done..], &mut out[3 * done..]);
}

#[target_feature(enable = "avx2")]
fn patch_at_least_256(patch: Patch, cut: u8, words: &mut [u64]) {
    let rows = patch.bytes.chunks(patch.stride);
    for (word, row) in words.iter_mut().zip(rows) {
        at_least_256(&row[..patch.width], cut, std::slice::from_mut(word));
    }
}

/// For each channel, the lane of pixel p: (3p + channel) mod the number of lanes.
pub(crate) const fn orders<const N: usize>() -> [[u8; N]; 3] {
    let mut orders = [[0; N]; 3];
    let mut channel = 0;
    while channel < 3 {
        let mut p = 0;
        while p < N {
            orders[channel][p] = ((3 * p + channel) % N) as u8;
            p += 1;
        }
        channel += 1;
    }
    orders
}

#[target_feature(enable = "avx2")]
fn at_least_256(row: &[u8], cut: u8, words: &mut [u64]) -> u64 {
    let level = _mm256_set1_epi8(cut.cast_signed());
    let mut sums = _mm256_setzero_si256();
    let (blocks, rest) = row.as_chunks::<64>();
    for (word, block) in words.iter_mut().zip(blocks) {
        *word = 0;
        for (half, bytes) in block.as_chunks::<32>().0.iter().enumerate() {
            // SAFETY: half a block is 32 bytes long.
            let bytes = unsafe { _mm256_loadu_si256(bytes.as_ptr().cast()) };
            let is = _mm256_cmpeq_epi8(_mm256_max_epu8(bytes, level), bytes);
            *word |= u64::from(_mm256_movemask_epi8(is).cast_unsigned()) << (32 * half);
            sums = _mm256_add_epi64(sums, _mm256_sad_epu8(bytes, _mm256_setzero_si256()));
        }
    }
    let mut parts = [0u64; 4];
    // SAFETY: the array is 32 bytes long.
    unsafe { _mm256_storeu_si256(parts.as_mut_ptr().cast(), sums) };
    let sum: u64 = parts.iter().sum();
    sum + super::at_least(rest, cut, words.get_mut(blocks.len()..).unwrap_or(&mut []))
}
