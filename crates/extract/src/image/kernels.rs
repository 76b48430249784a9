//! Loops over all pixels that a compiler alone does not make fast. Each exists for AVX-512 and
//! AVX2, chosen at run time, and as the plain loop that defines its result.

mod scan;
mod spread;
#[cfg(target_arch = "x86_64")]
mod wide;
#[cfg(target_arch = "x86_64")]
mod x86;

use super::PixelFormat;
#[cfg(target_arch = "x86_64")]
pub(crate) use x86::{channels_256, orders, pixels_256, twice};

/// Pixels along a row that share one level of the table.
pub(crate) const BLOCK: usize = 8;

/// Some rows of a picture with interleaved channels, the table along them, and the buffers for the
/// result.
pub(crate) struct Band<'a> {
    /// The bytes from the first row's start to the last row's end: at most one block of rows.
    pub(crate) rows: &'a [u8],
    /// Bytes from one row's start to the next.
    pub(crate) stride: usize,
    /// At least as long as a row.
    pub(crate) table: &'a [u8],
    /// Pixels in a row.
    pub(crate) width: usize,
    /// Difference, one byte per pixel. The stride is in bytes.
    pub(crate) out: &'a mut [u8],
    pub(crate) out_stride: usize,
    /// One bit per pixel, set where the difference is `≥ least`. Each row has its own words. The
    /// stride is in words.
    pub(crate) faint: &'a mut [u64],
    pub(crate) faint_stride: usize,
    pub(crate) least: u8,
}

impl Band<'_> {
    /// Calls `row` with each row, the table, and the row's parts of `out` and `faint`.
    #[inline(always)]
    fn for_each_row(self, mut row: impl FnMut(&[u8], &[u8], &mut [u8], &mut [u64])) {
        let bytes = 3 * self.width;
        let words = self.width.div_ceil(64);
        let out = self.out.chunks_mut(self.out_stride);
        let faint = self.faint.chunks_mut(self.faint_stride);
        for (i, (out, faint)) in out.zip(faint).enumerate() {
            let pixels = &self.rows[i * self.stride..][..bytes];
            let (out, faint) = (&mut out[..self.width], &mut faint[..words]);
            row(pixels, &self.table[..bytes], out, faint);
        }
    }
}

/// Some rows of a picture to be searched, in strips of 64 pixels, for anything other than the
/// table.
pub(crate) struct Rows<'a> {
    /// The bytes from the first row's start to the last row's end: at most one block of rows.
    pub(crate) rows: &'a [u8],
    /// Bytes from one row's start to the next, and bytes of a row.
    pub(crate) stride: usize,
    pub(crate) row: usize,
    /// Bytes per pixel, at most three.
    pub(crate) bytes: usize,
    /// At least as long as a row.
    pub(crate) table: &'a [u8],
    /// Minimum difference from the table, for the even bytes and the odd ones; not 0.
    pub(crate) least: [u8; 2],
    /// For each strip, the sum of the flags below that apply.
    pub(crate) hits: &'a mut [u8],
}

impl Rows<'_> {
    /// Flags of a strip that differs from the table anywhere, among its first eight pixels, or
    /// among its last eight.
    pub(crate) const ANY: u8 = 1;
    pub(crate) const LEFT: u8 = 2;
    pub(crate) const RIGHT: u8 = 4;
    /// Pixels at each side of a strip that have a flag of their own.
    pub(crate) const SIDE: usize = 8;
}

/// Some rows of a plane of bytes, at most 64 pixels of each.
#[derive(Clone, Copy)]
pub(crate) struct Patch<'a> {
    /// The bytes from the first row's start.
    pub(crate) bytes: &'a [u8],
    /// Bytes from one row's start to the next.
    pub(crate) stride: usize,
    /// Pixels in each row.
    pub(crate) width: usize,
}

type Spread = fn(PixelFormat, [&[u8]; 3], &mut [u8], &mut [u8]);

/// The kernels for this machine.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kernels {
    /// Writes the difference of three interleaved channels from the table. Takes a row, the table
    /// along it (at least as long), and an output of one byte per pixel.
    pub(crate) three_channels: fn(&[u8], &[u8], &mut [u8]),
    /// Repeats one level per channel and block of pixels in the byte order of a format's first
    /// plane, and of its second if it has one. The number of blocks is a multiple of eight.
    pub(crate) spread: Spread,
    /// As `three_channels` for some rows; also marks which results reach a level.
    pub(crate) three_channel_band: fn(Band),
    /// As `three_channel_band` for Y₀ U Y₁ V, with U and V counted double. `None` unless the
    /// machine has registers that make it worthwhile.
    pub(crate) yuyv_band: Option<fn(Band)>,
    /// As `yuyv_band` for U Y₀ V Y₁.
    pub(crate) uyvy_band: Option<fn(Band)>,
    /// Finds where some rows differ from the table.
    pub(crate) look: fn(Rows),
    /// Packs pixels of blue, green, red and a fourth byte as red, green and blue.
    pub(crate) pack: fn(&[[u8; 4]], &mut [u8]),
    /// Collects the bytes of a row whose bits are set and returns their number. The output needs
    /// room for 64 more.
    pub(crate) collect: fn(&[u8], &[u64], &mut [u8]) -> usize,
    /// Compares a patch with `cut`: one word per row, one bit per byte, set if the byte is `≥ cut`.
    pub(crate) patch_at_least: fn(Patch, u8, &mut [u64]),
    /// Compares a row with `cut`: one bit per byte, 64 to a word, set if the byte is `≥ cut`.
    /// Returns the sum of the bytes.
    pub(crate) at_least: fn(&[u8], u8, &mut [u64]) -> u64,
}

impl Kernels {
    /// The fastest kernels that this machine can run.
    pub(crate) fn detect() -> Self {
        #[cfg(target_arch = "x86_64")]
        if let Some(kernels) = x86::detect() {
            return kernels;
        }
        Self {
            three_channels: |row, table, out| {
                lariat_portable::Arch::new().dispatch(|| three_channels(row, table, out));
            },
            spread: spread::spread,
            three_channel_band: |band| {
                lariat_portable::Arch::new().dispatch(|| three_channel_band(band))
            },
            yuyv_band: None,
            uyvy_band: None,
            look: scan::look,
            pack: |pixels, out| lariat_portable::Arch::new().dispatch(|| pack(pixels, out)),
            collect,
            patch_at_least: |patch, cut, words| {
                lariat_portable::Arch::new().dispatch(|| patch_at_least(patch, cut, words));
            },
            at_least: |row, cut, words| {
                lariat_portable::Arch::new().dispatch(|| at_least(row, cut, words))
            },
        }
    }
}

impl Default for Kernels {
    fn default() -> Self {
        Self::detect()
    }
}

#[inline(always)]
fn three_channels(row: &[u8], table: &[u8], out: &mut [u8]) {
    for ((d, p), t) in out
        .iter_mut()
        .zip(row.chunks_exact(3))
        .zip(table.chunks_exact(3))
    {
        *d = p[0]
            .abs_diff(t[0])
            .max(p[1].abs_diff(t[1]))
            .max(p[2].abs_diff(t[2]));
    }
}

#[inline(always)]
fn three_channel_band(band: Band) {
    let least = band.least;
    band.for_each_row(|row, table, out, faint| {
        three_channels(row, table, out);
        at_least(out, least, faint);
    });
}

#[inline(always)]
fn pack(pixels: &[[u8; 4]], out: &mut [u8]) {
    for (out, &[b, g, r, _]) in out.as_chunks_mut::<3>().0.iter_mut().zip(pixels) {
        *out = [r, g, b];
    }
}

fn collect(row: &[u8], bits: &[u64], out: &mut [u8]) -> usize {
    let mut count = 0;
    for (pixels, &word) in row.chunks(64).zip(bits) {
        let mut rest = word;
        while rest != 0 {
            out[count] = pixels[rest.trailing_zeros() as usize];
            count += 1;
            rest &= rest - 1;
        }
    }
    count
}

#[inline(always)]
fn patch_at_least(patch: Patch, cut: u8, words: &mut [u64]) {
    let rows = patch.bytes.chunks(patch.stride);
    for (word, row) in words.iter_mut().zip(rows) {
        at_least(&row[..patch.width], cut, std::slice::from_mut(word));
    }
}

/// Turns eight comparisons at a time into eight bits with one multiplication.
#[inline(always)]
fn at_least(row: &[u8], cut: u8, words: &mut [u64]) -> u64 {
    let mut sum = 0;
    for (word, pixels) in words.iter_mut().zip(row.chunks(64)) {
        let mut ones = [0u8; 64];
        for (one, &pixel) in ones.iter_mut().zip(pixels) {
            *one = u8::from(pixel >= cut);
        }
        sum += pixels.iter().map(|&p| u64::from(p)).sum::<u64>();
        *word = 0;
        for (i, eight) in ones.chunks_exact(8).enumerate() {
            let mut bytes = [0; 8];
            bytes.copy_from_slice(eight);
            let bits = u64::from_le_bytes(bytes).wrapping_mul(0x0102_0408_1020_4080) >> 56;
            *word |= bits << (8 * i);
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// All kernels that this machine can run.
    fn all() -> Vec<Kernels> {
        let mut all = vec![Kernels::detect()];
        #[cfg(target_arch = "x86_64")]
        all.extend(x86::all());
        all
    }

    fn bytes() -> impl Strategy<Value = Vec<u8>> {
        prop_oneof![
            prop::collection::vec(any::<u8>(), 0..700),
            (0..700usize, any::<u8>()).prop_map(|(length, byte)| vec![byte; length]),
        ]
    }

    proptest! {
        #[test]
        fn a_row_of_three_channels_differs_as_the_plain_loop_says(row in bytes(), table in bytes()) {
            let pixels = row.len().min(table.len()) / 3;
            let mut expected = vec![0; pixels];
            three_channels(&row, &table, &mut expected);
            for kernels in all() {
                let mut found = vec![0; pixels];
                (kernels.three_channels)(&row, &table, &mut found);
                prop_assert_eq!(&found, &expected);
            }
        }

        #[test]
        fn levels_are_spread_as_the_plain_loop_says(
            levels in prop::collection::vec(any::<u8>(), 3 * 48), eights in 1usize..=6,
        ) {
            let channels = [0, 1, 2].map(|c| &levels[48 * c..][..8 * eights]);
            let formats = [
                PixelFormat::Gray8,
                PixelFormat::Rgb8,
                PixelFormat::Bgr8,
                PixelFormat::Yuyv,
                PixelFormat::Uyvy,
                PixelFormat::Nv12,
            ];
            for (kernels, format) in all().into_iter().flat_map(|k| formats.map(|f| (k, f))) {
                let planes = || (vec![7; 3 * 64 * 6 + 5], vec![9; 64 * 6]);
                let (mut luma, mut chroma) = planes();
                spread::spread(format, channels, &mut luma, &mut chroma);
                let expected = (luma, chroma);
                let (mut luma, mut chroma) = planes();
                (kernels.spread)(format, channels, &mut luma, &mut chroma);
                prop_assert_eq!((luma, chroma), expected);
            }
        }

        #[test]
        fn a_band_of_three_channels_differs_as_the_plain_loop_says(
            bytes in prop::collection::vec(any::<u8>(), 3000),
            table in prop::collection::vec(any::<u8>(), 600),
            width in 1usize..200, gap in 0usize..20, rows in 1usize..5, least: u8,
        ) {
            let words = width.div_ceil(64);
            let make = |kernel: fn(Band)| {
                let (mut out, mut faint) = (vec![7; rows * width], vec![9; rows * words]);
                kernel(Band {
                    rows: &bytes,
                    stride: 3 * width + gap,
                    table: &table,
                    width,
                    out: &mut out,
                    out_stride: width,
                    faint: &mut faint,
                    faint_stride: words,
                    least,
                });
                (out, faint)
            };
            for kernels in all() {
                prop_assert_eq!(make(kernels.three_channel_band), make(three_channel_band));
            }
        }

        #[test]
        fn a_look_sees_what_is_off_the_table(
            bytes in prop::collection::vec(any::<u8>(), 3000),
            far in prop::collection::vec((0usize..3000, any::<u8>()), 0..6),
            table in prop::collection::vec(any::<u8>(), 700),
            row in 1usize..300, gap in 0usize..20, rows in 1usize..=BLOCK, of in 1usize..=3,
            least in prop::array::uniform2(1u8..60),
        ) {
            // Like the table except for some bytes.
            let stride = row + gap;
            let pixel = |k: usize| match far.iter().find(|(at, _)| *at == k) {
                Some((_, byte)) => *byte,
                None => table[k % stride].saturating_add(bytes[k] % 12).saturating_sub(6),
            };
            let bytes: Vec<u8> = (0..rows * stride).map(pixel).collect();
            let mut expected = vec![0; row.div_ceil(64 * of)];
            for (x, y) in (0..rows).flat_map(|y| (0..row).map(move |x| (x, y))) {
                if bytes[y * stride + x].abs_diff(table[x]) >= least[x % 2] {
                    let at = x % (64 * of);
                    let (left, right) = (at < Rows::SIDE * of, at >= (64 - Rows::SIDE) * of);
                    let sides = u8::from(left) * Rows::LEFT + u8::from(right) * Rows::RIGHT;
                    expected[x / (64 * of)] |= Rows::ANY + sides;
                }
            }
            for kernels in all() {
                let mut hits = vec![9; expected.len()];
                (kernels.look)(Rows {
                    rows: &bytes[..(rows - 1) * stride + row],
                    stride,
                    row,
                    bytes: of,
                    table: &table,
                    least,
                    hits: &mut hits,
                });
                prop_assert_eq!(&hits, &expected);
            }
        }

        #[test]
        fn a_band_of_pairs_differs_as_its_pixels_do(
            bytes in prop::collection::vec(any::<u8>(), 2000),
            table in prop::collection::vec(any::<u8>(), 512),
            width in 1usize..200, gap in 0usize..20, rows in 1usize..5, least: u8, light in 0usize..2,
        ) {
            let (words, stride) = (width.div_ceil(64), 4 * width.div_ceil(2) + gap);
            let difference = |x: usize, y: usize| {
                let off = |k: usize| bytes[y * stride + k].abs_diff(table[k]);
                let color = off(4 * (x / 2) + 1 - light).max(off(4 * (x / 2) + 3 - light));
                off(2 * x + light).max(color.saturating_mul(2))
            };
            let band = |kernels: Kernels| [kernels.yuyv_band, kernels.uyvy_band][light];
            for kernel in all().into_iter().filter_map(band) {
                let (mut out, mut faint) = (vec![7; rows * width], vec![9; rows * words]);
                kernel(Band {
                    rows: &bytes,
                    stride,
                    table: &table,
                    width,
                    out: &mut out,
                    out_stride: width,
                    faint: &mut faint,
                    faint_stride: words,
                    least,
                });
                for (x, y) in (0..rows).flat_map(|y| (0..width).map(move |x| (x, y))) {
                    prop_assert_eq!(out[y * width + x], difference(x, y));
                    let bit = faint[y * words + x / 64] >> (x % 64) & 1 == 1;
                    prop_assert_eq!(bit, difference(x, y) >= least);
                }
            }
        }

        #[test]
        fn pixels_are_packed_as_the_plain_loop_says(
            pixels in prop::collection::vec(any::<[u8; 4]>(), 0..200), behind in 0..7usize,
        ) {
            let room = vec![7; 3 * pixels.len() + behind];
            let mut expected = room.clone();
            pack(&pixels, &mut expected);
            for kernels in all() {
                let mut found = room.clone();
                (kernels.pack)(&pixels, &mut found);
                prop_assert_eq!(&found, &expected);
            }
        }

        #[test]
        fn bytes_are_collected_as_the_plain_loop_says(
            row in prop::collection::vec(any::<u8>(), 1..700),
            bits in prop::collection::vec(any::<u64>(), 11),
            sparse: bool,
        ) {
            let inside = |i: usize| match row.len().saturating_sub(64 * i) {
                rest @ 0..64 => (1 << rest) - 1,
                _ => u64::MAX,
            };
            let words = bits.iter().enumerate();
            let words = words.map(|(i, bits)| if sparse && bits % 3 > 0 { 0 } else { bits & inside(i) });
            let bits: Vec<u64> = words.collect();
            let make = |kernel: fn(&[u8], &[u64], &mut [u8]) -> usize| {
                let mut out = vec![0; row.len() + 64];
                let count = kernel(&row, &bits, &mut out);
                out.truncate(count);
                out
            };
            for kernels in all() {
                prop_assert_eq!(make(kernels.collect), make(collect));
            }
        }

        #[test]
        fn a_patch_is_cut_as_the_plain_loop_says(
            bytes in prop::collection::vec(any::<u8>(), 900),
            width in 1usize..=64, gap in 0usize..40, rows in 1usize..=8, cut: u8,
        ) {
            let patch = Patch { bytes: &bytes, stride: width + gap, width };
            let mut expected = vec![7; rows];
            patch_at_least(patch, cut, &mut expected);
            for kernels in all() {
                let mut found = vec![9; rows];
                (kernels.patch_at_least)(patch, cut, &mut found);
                prop_assert_eq!(&found, &expected);
            }
        }

        #[test]
        fn bytes_are_cut_and_summed_as_the_plain_loop_says(row in bytes(), cut: u8) {
            let mut expected = vec![7; row.len().div_ceil(64)];
            let sum = at_least(&row, cut, &mut expected);
            for kernels in all() {
                let mut found = vec![9; expected.len()];
                prop_assert_eq!((kernels.at_least)(&row, cut, &mut found), sum);
                prop_assert_eq!(&found, &expected);
            }
        }
    }
}
