//! Stretches with AVX-512: sixteen pixels per register, at four bytes each. A pixel's difference is
//! that of its most different byte.
//!
//! `unsafe` is needed for two things. One is to call code for registers that not every machine has,
//! after checking for them. The other is to load through pointers, which come from slices of the
//! length that is loaded.
#![allow(unsafe_code)]

use super::{BLOCK, Lanes, Plain, Stretch, WORD, Work};
use crate::image::PixelFormat;
use std::arch::x86_64::*;

/// The three color bytes of a pixel.
const COLORS: u32 = 0x00FF_FFFF;
/// Those that count double in YUV formats.
const CHROMA: u32 = 0x00FF_FF00;

/// Proof that the machine has AVX-512.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wide(());

impl Wide {
    pub(super) fn detect() -> Option<Self> {
        let has = is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512bw")
            && is_x86_feature_detected!("avx512vl")
            && is_x86_feature_detected!("avx512dq")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2")
            && is_x86_feature_detected!("lzcnt")
            && is_x86_feature_detected!("popcnt");
        has.then_some(Self(()))
    }

    pub(super) fn dispatch<W: Work>(self, work: W) {
        #[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512dq,bmi1,bmi2,lzcnt,popcnt")]
        fn inner<W: Work>(wide: Wide, work: W) {
            work.run(wide);
        }
        // SAFETY: `Wide` is only created on a machine that has all of these.
        unsafe { inner(self, work) }
    }
}

impl Lanes for Wide {
    #[inline(always)]
    fn read(self, stretch: &Stretch, out: &mut [u8; WORD]) -> u64 {
        // SAFETY: `Wide` is only created on a machine that has AVX-512.
        let set = unsafe {
            if stretch.axis == 0 {
                across(stretch, out)
            } else {
                down(stretch, out)
            }
        };
        // Near the end of the image's bytes, a register may reach beyond them.
        set.unwrap_or_else(|| Plain.read(stretch, out))
    }

    #[inline(always)]
    fn sum(self, differences: &[u8; WORD], [from, to]: [u32; 2]) -> u32 {
        let within = !(u64::MAX << (to - from).min(63)) << (from & 63);
        // SAFETY: `Wide` is only created on a machine that has AVX-512, and the array is 64 bytes
        // long.
        let sum = unsafe {
            let bytes = _mm512_maskz_loadu_epi8(within, differences.as_ptr().cast());
            _mm512_reduce_add_epi64(_mm512_sad_epu8(bytes, _mm512_setzero_si512()))
        };
        sum as u32
    }
}

/// Pixels, and how they are compared with the table.
#[derive(Clone, Copy)]
struct Pixels {
    /// Four bytes a pixel.
    bytes: __m512i,
    table: __m512i,
    /// Mask of the bytes that count.
    keep: __m512i,
    /// Mask of the bytes that count double.
    double: __m512i,
}

impl Pixels {
    /// The differences, one byte each.
    ///
    /// # Safety
    /// The machine has AVX-512 F, BW and VL.
    #[inline(always)]
    unsafe fn differences(self) -> __m128i {
        // SAFETY: guaranteed by the caller.
        unsafe {
            let (p, t) = (self.bytes, self.table);
            let off = _mm512_sub_epi8(_mm512_max_epu8(p, t), _mm512_min_epu8(p, t));
            let off = _mm512_and_si512(off, self.keep);
            let off = _mm512_adds_epu8(off, _mm512_and_si512(off, self.double));
            let two = _mm512_max_epu8(off, _mm512_srli_epi32::<16>(off));
            let one = _mm512_max_epu8(two, _mm512_srli_epi32::<8>(two));
            _mm512_cvtepi32_epi8(one)
        }
    }
}

/// Writes the differences of block `k`. Returns a bit for each, set if it is rope.
///
/// # Safety
/// The machine has AVX-512 F, BW and VL.
#[inline(always)]
unsafe fn put(pixels: Pixels, k: usize, cut: __m128i, out: &mut [u8; WORD]) -> u64 {
    let out = &mut out[BLOCK * k..][..BLOCK];
    // SAFETY: guaranteed by the caller. `out` is 16 bytes long.
    unsafe {
        let differences = pixels.differences();
        _mm_storeu_si128(out.as_mut_ptr().cast(), differences);
        u64::from(_mm_cmpge_epu8_mask(differences, cut)) << (BLOCK * k)
    }
}

/// Reads along a row. `None` if that would reach beyond the image's bytes.
///
/// # Safety
/// The machine has AVX-512 F, BW and VL.
#[inline(always)]
unsafe fn across(stretch: &Stretch, out: &mut [u8; WORD]) -> Option<u64> {
    let Stretch {
        image,
        from: [x, y],
        count,
        tables,
        cut,
        ..
    } = *stretch;
    let blocks = count / BLOCK;
    let start = y * image.stride();
    let mut set = 0;
    // SAFETY: guaranteed by the caller. Each load is from a slice of at least its length.
    unsafe {
        let all = |word: u32| _mm512_set1_epi32(word.cast_signed());
        let table = |k: usize| all(laid(image.format(), tables[k]));
        let (cut, nothing) = (_mm_set1_epi8(cut.cast_signed()), _mm512_setzero_si512());
        match image.format() {
            PixelFormat::Gray8 => {
                let bytes = image.bytes().get(start + x..)?.get(..count)?;
                let keep = all(0xFF);
                for (k, block) in bytes.as_chunks::<BLOCK>().0.iter().enumerate() {
                    let bytes = _mm512_cvtepu8_epi32(_mm_loadu_si128(block.as_ptr().cast()));
                    let pixels = Pixels {
                        bytes,
                        table: table(k),
                        keep,
                        double: nothing,
                    };
                    set |= put(pixels, k, cut, out);
                }
            }
            PixelFormat::Rgb8 | PixelFormat::Bgr8 => {
                // Twelve bytes are four pixels. The last of the 64 bytes are not needed.
                let reach = 3 * BLOCK * (blocks - 1) + 64;
                let bytes = image.bytes().get(start + 3 * x..)?.get(..reach)?;
                let keep = all(COLORS);
                let fours = _mm512_setr_epi32(0, 1, 2, 2, 3, 4, 5, 5, 6, 7, 8, 8, 9, 10, 11, 11);
                let triples = _mm512_broadcast_i32x4(_mm_setr_epi8(
                    0, 1, 2, -1, 3, 4, 5, -1, 6, 7, 8, -1, 9, 10, 11, -1,
                ));
                for k in 0..blocks {
                    let block = &bytes[3 * BLOCK * k..][..64];
                    let block = _mm512_loadu_si512(block.as_ptr().cast());
                    let fours = _mm512_permutexvar_epi32(fours, block);
                    let bytes = _mm512_shuffle_epi8(fours, triples);
                    let pixels = Pixels {
                        bytes,
                        table: table(k),
                        keep,
                        double: nothing,
                    };
                    set |= put(pixels, k, cut, out);
                }
            }
            format @ (PixelFormat::Yuyv | PixelFormat::Uyvy) => {
                let bytes = image.bytes().get(start + 2 * x..)?.get(..2 * count)?;
                let ([first, second], double) = shared(format);
                let [first, second] = [first, second].map(u32::cast_signed);
                let keep = _mm512_setr4_epi32(first, second, first, second);
                let double = all(double);
                for (k, block) in bytes.as_chunks::<{ 2 * BLOCK }>().0.iter().enumerate() {
                    let pairs = _mm512_cvtepu32_epi64(_mm256_loadu_si256(block.as_ptr().cast()));
                    let bytes = _mm512_shuffle_epi32::<0b10_10_00_00>(pairs);
                    set |= put(
                        Pixels {
                            bytes,
                            table: table(k),
                            keep,
                            double,
                        },
                        k,
                        cut,
                        out,
                    );
                }
            }
            PixelFormat::Nv12 => {
                let chroma = image.chroma_line(y) * image.stride();
                let light = image.bytes().get(start + x..)?.get(..count)?;
                let color = image.bytes().get(chroma + x..)?.get(..count)?;
                let (keep, double) = (all(COLORS), all(CHROMA));
                let color = color.as_chunks::<BLOCK>().0;
                let both = light.as_chunks::<BLOCK>().0.iter().zip(color);
                for (k, (light, color)) in both.enumerate() {
                    let light = _mm512_cvtepu8_epi32(_mm_loadu_si128(light.as_ptr().cast()));
                    let pairs = _mm512_cvtepu16_epi64(_mm_loadu_si128(color.as_ptr().cast()));
                    let color = _mm512_shuffle_epi32::<0b10_10_00_00>(pairs);
                    let bytes = _mm512_or_si512(light, _mm512_slli_epi32::<8>(color));
                    set |= put(
                        Pixels {
                            bytes,
                            table: table(k),
                            keep,
                            double,
                        },
                        k,
                        cut,
                        out,
                    );
                }
            }
            // Other formats are unpacked before.
            _ => return None,
        }
    }
    Some(set)
}

/// Reads down a column. `None` if that would reach beyond the image's bytes.
///
/// # Safety
/// The machine has AVX-512 F, BW and VL.
#[inline(always)]
unsafe fn down(stretch: &Stretch, out: &mut [u8; WORD]) -> Option<u64> {
    let Stretch {
        image,
        from: [x, y],
        count,
        tables,
        cut,
        ..
    } = *stretch;
    let stride = image.stride();
    let mut set = 0;
    let format = image.format();
    // Offset of the pixel's four bytes in its row, and the masks of the bytes that count and that
    // count double.
    let (place, keep, double) = match format {
        PixelFormat::Gray8 => (x, 0xFF, 0),
        PixelFormat::Rgb8 | PixelFormat::Bgr8 => (3 * x, COLORS, 0),
        PixelFormat::Yuyv | PixelFormat::Uyvy => {
            let (keep, double) = shared(format);
            (4 * (x / 2), keep[x % 2], double)
        }
        PixelFormat::Nv12 => (x, COLORS, CHROMA),
        // Other formats are unpacked before.
        _ => return None,
    };
    let column = Column::new(image.bytes(), y * stride + place, stride, count)?;
    // SAFETY: guaranteed by the caller. The columns have as many pixels as are gathered.
    unsafe {
        let all = |word: u32| _mm512_set1_epi32(word.cast_signed());
        let table = all(laid(format, tables[0]));
        let (keep, double) = (all(keep), all(double));
        let rows = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
        let steps = _mm512_mullo_epi32(rows, all(stride as u32));
        let cut = _mm_set1_epi8(cut.cast_signed());
        if format != PixelFormat::Nv12 {
            for k in 0..count / BLOCK {
                let bytes = column.gather(BLOCK * k, steps);
                set |= put(
                    Pixels {
                        bytes,
                        table,
                        keep,
                        double,
                    },
                    k,
                    cut,
                    out,
                );
            }
            return Some(set);
        }
        // As y is even, two rows share theirs.
        let chroma = image.chroma_line(y) * stride + (x & !1);
        let chroma = Column::new(image.bytes(), chroma, stride, count / 2)?;
        let pairs = _mm512_srli_epi32::<1>(rows);
        let half_steps = _mm512_mullo_epi32(pairs, all(stride as u32));
        for k in 0..count / BLOCK {
            let light = _mm512_and_si512(column.gather(BLOCK * k, steps), all(0xFF));
            let color = _mm512_slli_epi32::<8>(chroma.gather(BLOCK / 2 * k, half_steps));
            let bytes = _mm512_or_si512(light, color);
            set |= put(
                Pixels {
                    bytes,
                    table,
                    keep,
                    double,
                },
                k,
                cut,
                out,
            );
        }
    }
    Some(set)
}

/// Four bytes in each of several rows, from a position on.
#[derive(Clone, Copy)]
struct Column<'a> {
    bytes: &'a [u8],
    stride: usize,
}

impl<'a> Column<'a> {
    /// `None` if the last of them would reach beyond the bytes.
    #[inline(always)]
    fn new(bytes: &'a [u8], from: usize, stride: usize, rows: usize) -> Option<Self> {
        let reach = (rows - 1) * stride + 4;
        let bytes = bytes.get(from..)?.get(..reach)?;
        // Otherwise a lane could not hold the offset.
        (reach < i32::MAX as usize).then_some(Self { bytes, stride })
    }

    /// The four bytes at each lane's offset from row `row`.
    ///
    /// # Safety
    /// The machine has AVX-512F; no lane reaches beyond the column's last row.
    #[inline(always)]
    unsafe fn gather(self, row: usize, lanes: __m512i) -> __m512i {
        let from = self.bytes[row * self.stride..].as_ptr();
        // SAFETY: guaranteed by the caller, and each row has four bytes.
        unsafe { _mm512_i32gather_epi32::<1>(lanes, from.cast()) }
    }
}

/// Masks for two pixels that share four bytes. The first two select the bytes that count for each
/// pixel, without the other pixel's Y. The third selects the bytes that count double.
#[inline(always)]
fn shared(format: PixelFormat) -> ([u32; 2], u32) {
    match format {
        // U Y V Y.
        PixelFormat::Uyvy => ([0x00FF_FFFF, 0xFFFF_00FF], 0x00FF_00FF),
        // Y U Y V.
        _ => ([0xFF00_FFFF, 0xFFFF_FF00], 0xFF00_FF00),
    }
}

/// A color as the four bytes of a pixel.
#[inline(always)]
fn laid(format: PixelFormat, color: u32) -> u32 {
    match format {
        PixelFormat::Bgr8 => color.swap_bytes() >> 8,
        // Y U Y V.
        PixelFormat::Yuyv => color & 0xFFFF | (color & 0xFF) << 16 | (color & 0xFF_0000) << 8,
        // U Y V Y.
        PixelFormat::Uyvy => color >> 8 & 0xFF | color & 0xFF_0000 | ((color & 0xFF) * 0x0100_0100),
        _ => color,
    }
}
