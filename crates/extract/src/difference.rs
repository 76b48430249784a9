//! How unlike the table each pixel is, straight from the camera's bytes, and which pixels are not just its noise.
//!
//! `difference = max over channels |pixel − table|`, U and V counting double. Because the maximum
//! scales with the share of rope in a pixel (see `color::distance`), half the rope's own difference
//! is the rope's edge, whatever its color. All that is asked of every pixel is asked here, while a row is in reach.

mod planes;

use crate::background::Background;
use crate::bits::BitPlane;
use crate::color;
use crate::kernels::Kernels;
use crate::plane::Plane;
use crate::threshold::Levels;
use crate::{Image, PixelFormat};

/// Rows, and pixels along a row, that share one evaluation of the table's surface: it changes by a level over many more.
const BLOCK: usize = 8;

/// Pixels down a column that are worked on together.
const PART: usize = 64;

/// Memory of the differencing: the table's color along a band of rows, interleaved as the image's bytes.
#[derive(Debug, Default)]
pub(crate) struct Differencer {
    kernels: Kernels,
    /// One level for each block.
    channels: [Vec<u8>; 3],
    luma: Vec<u8>,
    chroma: Vec<u8>,
}

impl Differencer {
    /// Fills `out` with the difference of each pixel of `image` from `background`, `faint` with those from the level
    /// `least` on, and counts the levels.
    pub(crate) fn run(
        &mut self,
        image: &Image,
        background: &Background,
        least: u8,
        out: &mut Plane,
        faint: &mut BitPlane,
    ) -> Levels {
        let (width, height) = (image.width(), image.height());
        out.resize(width, height);
        faint.resize(width, height);
        let mut levels = Levels::new(width * height);
        for y in 0..height {
            if y % BLOCK == 0 {
                let middle = (y + BLOCK / 2).min(height - 1);
                self.lay_table(image.format(), background, [0, middle], width);
            }
            self.stretch(image, [0, y], out.row_mut(y));
            let (row, words) = (out.row(y), faint.row_mut(y));
            levels.total += (self.kernels.at_least)(row, least, words);
            levels.count(row, words);
        }
        levels
    }

    /// The difference down a column, compiled for the registers of whoever calls it, from pixel [x, y] on, into `out`. The table has one color for all of it.
    #[inline(always)]
    pub(crate) fn down(image: &Image, table: [u8; 3], [x, y]: [usize; 2], out: &mut [u8]) {
        // U and V count double.
        let more = if color::is_yuv(image.format()) {
            0xFF
        } else {
            0
        };
        for (part, out) in out.chunks_mut(PART).enumerate() {
            let mut pixels = [[0; 4]; PART];
            color::down(image, [x, y + part * PART], out.len(), |k, [a, b, c]| {
                pixels[k] = [a, b, c, 0];
            });
            four_channels(&pixels, table, more, out);
        }
    }

    /// Lays the table's color along `width` pixels from [x, y] on.
    fn lay_table(
        &mut self,
        format: PixelFormat,
        background: &Background,
        from: [usize; 2],
        width: usize,
    ) {
        self.reserve(width);
        let [a, b, c] = &mut self.channels;
        background.row(from, BLOCK, [a, b, c]);
        self.interleave(format);
    }

    /// Makes room for the table along `width` pixels.
    fn reserve(&mut self, width: usize) {
        let blocks = width.div_ceil(BLOCK);
        // For the format that needs the most, so that a camera's first frame after a gray one grows nothing.
        self.luma.resize(self.luma.len().max(3 * BLOCK * blocks), 0);
        self.chroma.resize(self.chroma.len().max(BLOCK * blocks), 0);
        for channel in &mut self.channels {
            channel.resize(blocks, 0);
        }
    }

    fn stretch(&self, image: &Image, [x, y]: [usize; 2], out: &mut [u8]) {
        let (row, luma, chroma) = (image.row(y), &self.luma[..], &self.chroma[..]);
        match image.format() {
            PixelFormat::Gray8 => planes::gray(&row[x..], luma, out),
            PixelFormat::Rgb8 | PixelFormat::Bgr8 => {
                (self.kernels.three_channels)(&row[3 * x..], luma, out);
            }
            PixelFormat::Yuyv => planes::yuyv(&row[2 * x..], luma, out),
            PixelFormat::Nv12 => {
                let uv = &image.chroma_row(y)[x..];
                planes::nv12([&row[x..], uv], [luma, chroma], out);
            }
        }
    }

    /// Puts the table's three channels in the order of the image's bytes, a block of pixels at a time.
    fn interleave(&mut self, format: PixelFormat) {
        let [a, b, c] = &self.channels;
        let colors = a.iter().zip(b).zip(c).map(|((&a, &b), &c)| [a, b, c]);
        let (luma, chroma) = (&mut self.luma, &mut self.chroma);
        match format {
            PixelFormat::Gray8 => spread(colors, luma, |[a, _, _]| [a; BLOCK]),
            PixelFormat::Rgb8 => spread(colors, luma, triples),
            PixelFormat::Bgr8 => spread(colors, luma, |[r, g, b]| triples([b, g, r])),
            PixelFormat::Yuyv => spread(colors, luma, |[y, u, v]| {
                repeated::<{ 2 * BLOCK }>([y, u, y, v])
            }),
            PixelFormat::Nv12 => {
                spread(colors.clone(), luma, |[y, _, _]| [y; BLOCK]);
                spread(colors, chroma, |[_, u, v]| repeated::<BLOCK>([u, v, u, v]));
            }
        }
    }
}

/// Fills `out` with the bytes of each block.
#[inline(always)]
fn spread<const N: usize>(
    colors: impl Iterator<Item = [u8; 3]>,
    out: &mut [u8],
    bytes: impl Fn([u8; 3]) -> [u8; N],
) {
    for (out, color) in out.as_chunks_mut::<N>().0.iter_mut().zip(colors) {
        *out = bytes(color);
    }
}

/// Eight times the same three bytes, as the three words they are.
#[inline(always)]
fn triples([a, b, c]: [u8; 3]) -> [u8; 3 * BLOCK] {
    let v = u64::from_le_bytes([a, b, c, 0, 0, 0, 0, 0]);
    let words = [
        v | v << 24 | v << 48,
        v >> 16 | v << 8 | v << 32 | v << 56,
        v >> 8 | v << 16 | v << 40,
    ];
    let mut bytes = [0; 3 * BLOCK];
    for (bytes, word) in bytes.as_chunks_mut::<8>().0.iter_mut().zip(words) {
        *bytes = word.to_le_bytes();
    }
    bytes
}

/// The same four bytes over and over, as the words they are.
#[inline(always)]
fn repeated<const N: usize>(four: [u8; 4]) -> [u8; N] {
    let word = u64::from(u32::from_le_bytes(four)) * 0x1_0000_0001;
    let mut bytes = [0; N];
    for bytes in bytes.as_chunks_mut::<8>().0 {
        *bytes = word.to_le_bytes();
    }
    bytes
}

/// The difference of pixels of four bytes, the last of which is nothing.
#[inline(always)]
fn four_channels(pixels: &[[u8; 4]; PART], [a, b, c]: [u8; 3], more: u8, out: &mut [u8]) {
    let mut differences = [0; PART];
    for (difference, pixel) in differences.iter_mut().zip(pixels) {
        let chroma = pixel[1].abs_diff(b).max(pixel[2].abs_diff(c));
        let chroma = chroma.saturating_add(chroma & more);
        *difference = pixel[0].abs_diff(a).max(chroma);
    }
    out.copy_from_slice(&differences[..out.len()]);
}
