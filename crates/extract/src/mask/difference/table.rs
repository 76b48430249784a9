//! The table's color along a band of rows, and the difference of an image's pixels from it.

use super::super::background::Background;
use super::{BLOCK, planes};
use crate::image::kernels::Kernels;
use crate::image::{Image, PixelFormat};

/// The table's color, interleaved like the bytes of an image's first plane and of its second.
#[derive(Debug, Default)]
pub(super) struct Table {
    /// One level per block.
    channels: [Vec<u8>; 3],
    pub(super) luma: Vec<u8>,
    pub(super) chroma: Vec<u8>,
}

impl Table {
    /// Lays the table along the band that begins at row `top`.
    pub(super) fn lay(
        &mut self,
        kernels: &Kernels,
        image: &Image,
        background: &Background,
        top: usize,
    ) {
        self.reserve(image.width());
        let middle = (top + BLOCK / 2).min(image.height() - 1);
        let [a, b, c] = &mut self.channels;
        background.row([0, middle], BLOCK, [a, b, c]);
        let channels = self.channels.each_ref().map(|channel| &channel[..]);
        (kernels.spread)(image.format(), channels, &mut self.luma, &mut self.chroma);
    }

    /// Reserves room for `width` pixels.
    fn reserve(&mut self, width: usize) {
        // Enough to fill the widest registers with floats.
        let blocks = width.div_ceil(BLOCK).next_multiple_of(16);
        // Reserve for the format that needs the most, so that a camera's first frame after a gray
        // one allocates nothing.
        let (luma, chroma) = (3 * BLOCK * blocks, BLOCK * blocks);
        self.luma.resize(self.luma.len().max(luma), 0);
        self.chroma.resize(self.chroma.len().max(chroma), 0);
        for channel in &mut self.channels {
            channel.resize(blocks, 0);
        }
    }

    /// Writes the difference of the pixels of row `y` from `x` on, where a block begins.
    pub(super) fn apart(
        &self,
        kernels: &Kernels,
        image: &Image,
        [x, y]: [usize; 2],
        out: &mut [u8],
    ) {
        let format = image.format();
        let from = format.row_bytes(x);
        let (row, luma) = (&image.row(y)[from..], &self.luma[from..]);
        match format {
            PixelFormat::Gray8 => planes::gray(row, luma, out),
            PixelFormat::Rgb8 | PixelFormat::Bgr8 => (kernels.three_channels)(row, luma, out),
            PixelFormat::Yuyv => planes::yuyv(row, luma, out),
            PixelFormat::Uyvy => planes::uyvy(row, luma, out),
            PixelFormat::Nv12 => {
                let (uv, chroma) = (&image.chroma_row(y)[from..], &self.chroma[from..]);
                planes::nv12([row, uv], [luma, chroma], out);
            }
            // Other formats were unpacked earlier.
            _ => {}
        }
    }
}
