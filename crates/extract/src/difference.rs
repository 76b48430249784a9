//! How unlike the table each pixel is, straight from the camera's bytes, and which pixels are not just its noise.
//!
//! `difference = max over channels |pixel − table|`, U and V counting double. Because the maximum
//! scales with the share of rope in a pixel (see `color::distance`), half the rope's own difference
//! is the rope's edge, whatever its color. All that is asked of every pixel is asked here, while a row is in reach.

mod planes;

use crate::background::Background;
use crate::bits::BitPlane;
use crate::color;
use crate::kernels::{self, Band, Kernels};
use crate::plane::Plane;
use crate::threshold::Levels;
use crate::{Image, PixelFormat};
use std::ops::Range;

/// Rows, and pixels along a row, that share one evaluation of the table's surface: it changes by a level over many more.
const BLOCK: usize = kernels::BLOCK;

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
    /// `least` on, and takes the levels.
    pub(crate) fn run(
        &mut self,
        image: &Image,
        background: &Background,
        least: u8,
        out: &mut Plane,
        faint: &mut BitPlane,
        levels: &mut Levels,
    ) {
        let (width, height) = (image.width(), image.height());
        out.resize(width, height);
        faint.reshape(width, height);
        levels.clear(width, height);
        for top in (0..height).step_by(BLOCK) {
            let middle = (top + BLOCK / 2).min(height - 1);
            self.lay_table(image.format(), background, [0, middle], width);
            let rows = top..(top + BLOCK).min(height);
            let (out, faint) = (out.rows_mut(rows.clone()), faint.rows_mut(rows.clone()));
            self.band(image, rows.clone(), least, out, faint);
            let faint = faint.chunks_exact(width.div_ceil(64));
            for (y, (row, bits)) in rows.zip(out.chunks_exact(width).zip(faint)) {
                levels.add(&self.kernels, y, row, bits, least);
            }
        }
        levels.close();
    }

    /// The same of some rows that share the table, already laid.
    fn band(
        &self,
        image: &Image,
        rows: Range<usize>,
        least: u8,
        out: &mut [u8],
        faint: &mut [u64],
    ) {
        let width = image.width();
        let kernel = match image.format() {
            PixelFormat::Rgb8 | PixelFormat::Bgr8 => Some(self.kernels.three_channel_band),
            PixelFormat::Yuyv => self.kernels.yuyv_band,
            PixelFormat::Gray8 | PixelFormat::Nv12 => None,
        };
        if let Some(kernel) = kernel {
            return kernel(Band {
                rows: image.rows(rows),
                stride: image.stride(),
                table: &self.luma,
                width,
                out,
                faint,
                least,
            });
        }
        let out = out.chunks_exact_mut(width);
        let faint = faint.chunks_exact_mut(width.div_ceil(64));
        for (y, (out, faint)) in rows.zip(out.zip(faint)) {
            self.stretch(image, [0, y], out);
            (self.kernels.at_least)(out, least, faint);
        }
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
        // As many as fill the widest registers with floats.
        let blocks = width.div_ceil(BLOCK).next_multiple_of(16);
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
        let channels = self.channels.each_ref().map(|channel| &channel[..]);
        (self.kernels.spread)(format, channels, &mut self.luma, &mut self.chroma);
    }
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
