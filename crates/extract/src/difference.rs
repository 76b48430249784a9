//! How unlike the table each pixel is, straight from the camera's bytes.
//!
//! `difference = max over channels |pixel − table|`, U and V counting double. Because the maximum
//! scales with the share of rope in a pixel (see `color::distance`), half the rope's own difference
//! is the rope's edge, whatever its color. The loops are plain; pulp compiles them for the widest
//! registers that the machine turns out to have.

use crate::background::Background;
use crate::plane::Plane;
use crate::{Image, PixelFormat};

/// Rows that share one evaluation of the table's surface: it changes by a level over many more.
const BAND: usize = 8;

/// Memory of the differencing: the table's color along a band, interleaved as the image's bytes.
#[derive(Debug, Default)]
pub(crate) struct Differencer {
    channels: [Vec<u8>; 3],
    luma: Vec<u8>,
    chroma: Vec<u8>,
}

impl Differencer {
    /// Fills `out` with the difference of each pixel of `image` from `background`.
    pub(crate) fn difference(&mut self, image: &Image, background: &Background, out: &mut Plane) {
        let width = image.width();
        out.resize(width, image.height());
        for channel in &mut self.channels {
            channel.resize(width, 0);
        }
        // For the format that needs the most, so that a camera's first frame after a gray one grows nothing.
        self.luma.clear();
        self.luma.reserve(4 * width);
        self.chroma.clear();
        self.chroma.reserve(width + 1);
        let arch = pulp::Arch::new();
        for y in 0..image.height() {
            if y % BAND == 0 {
                let [a, b, c] = &mut self.channels;
                let middle = (y + BAND / 2).min(image.height() - 1);
                background.row(middle, [a, b, c]);
                self.interleave(image.format(), width);
            }
            let (row, out) = (image.row(y), out.row_mut(y));
            let (luma, chroma) = (&self.luma[..], &self.chroma[..]);
            match image.format() {
                PixelFormat::Gray8 => arch.dispatch(|| gray(row, luma, out)),
                PixelFormat::Rgb8 | PixelFormat::Bgr8 => {
                    arch.dispatch(|| three_channels(row, luma, out));
                }
                PixelFormat::Yuyv => arch.dispatch(|| yuyv(row, luma, out)),
                PixelFormat::Nv12 => {
                    let uv = image.chroma_row(y);
                    arch.dispatch(|| nv12(row, uv, luma, chroma, out));
                }
            }
        }
    }

    /// Puts the table's three channels in the order of the image's bytes.
    fn interleave(&mut self, format: PixelFormat, width: usize) {
        let [a, b, c] = &self.channels;
        self.luma.clear();
        self.chroma.clear();
        // An odd last pixel's pair is filled up with the last pixel itself.
        let even = |x: usize| x.min(width - 1);
        match format {
            PixelFormat::Gray8 => self.luma.extend_from_slice(a),
            PixelFormat::Rgb8 => (0..width).for_each(|x| self.luma.extend([a[x], b[x], c[x]])),
            PixelFormat::Bgr8 => (0..width).for_each(|x| self.luma.extend([c[x], b[x], a[x]])),
            PixelFormat::Yuyv => (0..width).step_by(2).for_each(|x| {
                self.luma.extend([a[x], b[x], a[even(x + 1)], c[x]]);
            }),
            PixelFormat::Nv12 => (0..width).step_by(2).for_each(|x| {
                self.luma.extend([a[x], a[even(x + 1)]]);
                self.chroma.extend([b[x], c[x]]);
            }),
        }
    }
}

#[inline(always)]
fn gray(row: &[u8], table: &[u8], out: &mut [u8]) {
    for ((d, &p), &t) in out.iter_mut().zip(row).zip(table) {
        *d = p.abs_diff(t);
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
fn twice(p: u8, t: u8) -> u8 {
    p.abs_diff(t).saturating_mul(2)
}

#[inline(always)]
fn yuyv(row: &[u8], table: &[u8], out: &mut [u8]) {
    for ((d, p), t) in out
        .chunks_mut(2)
        .zip(row.chunks_exact(4))
        .zip(table.chunks_exact(4))
    {
        let color = twice(p[1], t[1]).max(twice(p[3], t[3]));
        d[0] = p[0].abs_diff(t[0]).max(color);
        if let Some(second) = d.get_mut(1) {
            *second = p[2].abs_diff(t[2]).max(color);
        }
    }
}

#[inline(always)]
fn nv12(row: &[u8], uv: &[u8], luma: &[u8], chroma: &[u8], out: &mut [u8]) {
    let colors = uv.chunks_exact(2).zip(chroma.chunks_exact(2));
    let lights = row.chunks_exact(2).zip(luma.chunks_exact(2));
    for ((d, (p, t)), (c, k)) in out.chunks_mut(2).zip(lights).zip(colors) {
        let color = twice(c[0], k[0]).max(twice(c[1], k[1]));
        d[0] = p[0].abs_diff(t[0]).max(color);
        if let Some(second) = d.get_mut(1) {
            *second = p[1].abs_diff(t[1]).max(color);
        }
    }
}
