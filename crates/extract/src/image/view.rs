//! A borrowed picture in the camera's own pixel format: the only thing the extractor reads.

use super::{Region, color};
use std::ops::Range;
use thiserror::Error;

/// Maximum side in pixels, so that positions and areas stay far from overflow.
const MAX_SIDE: usize = 16_384;

/// Encoding of an [`Image`]'s pixels in bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PixelFormat {
    /// One byte per pixel: brightness.
    Gray8,
    /// Three bytes per pixel: red, green, blue.
    Rgb8,
    /// Three bytes per pixel: blue, green, red.
    Bgr8,
    /// Four bytes for two adjacent pixels: Y₀ U Y₁ V (BT.601, full range).
    Yuyv,
    /// Four bytes for two adjacent pixels: U Y₀ V Y₁ (BT.601, full range).
    Uyvy,
    /// A plane of Y, then a plane of U V pairs of half the height. Each pair covers 2×2 pixels.
    /// Both planes have the same stride (BT.601, full range).
    Nv12,
    /// Four bytes per pixel: blue, green, red, and one that is ignored.
    Bgra8,
    /// Two bytes of brightness per pixel, in the machine's byte order. The nearest of 256 levels is
    /// used.
    Gray16,
    /// One byte per pixel behind a mosaic of color filters: R G in the first row, G B in the
    /// second, and so on. Missing colors are means of the neighbors around the pixel, so nothing is
    /// displaced.
    BayerRggb8,
    /// A mosaic of B G and G R.
    BayerBggr8,
    /// A mosaic of G R and B G.
    BayerGrbg8,
    /// A mosaic of G B and R G.
    BayerGbrg8,
}

impl PixelFormat {
    /// Formats that are read without conversion.
    #[cfg(test)]
    pub(crate) const DIRECT: [Self; 6] = [
        Self::Gray8,
        Self::Rgb8,
        Self::Bgr8,
        Self::Yuyv,
        Self::Uyvy,
        Self::Nv12,
    ];

    /// Bytes of one row of `width` pixels (in the first plane).
    pub fn row_bytes(self, width: usize) -> usize {
        match self {
            PixelFormat::Gray8 => width,
            PixelFormat::Rgb8 | PixelFormat::Bgr8 => 3 * width,
            PixelFormat::Yuyv | PixelFormat::Uyvy => 4 * width.div_ceil(2),
            PixelFormat::Nv12 => 2 * width.div_ceil(2),
            PixelFormat::Bgra8 => 4 * width,
            PixelFormat::Gray16 => 2 * width,
            PixelFormat::BayerRggb8
            | PixelFormat::BayerBggr8
            | PixelFormat::BayerGrbg8
            | PixelFormat::BayerGbrg8 => width,
        }
    }

    /// Column and row of the first red pixel of a Bayer pattern.
    pub(crate) fn red(self) -> Option<[usize; 2]> {
        Some(match self {
            PixelFormat::BayerRggb8 => [0, 0],
            PixelFormat::BayerBggr8 => [1, 1],
            PixelFormat::BayerGrbg8 => [1, 0],
            PixelFormat::BayerGbrg8 => [0, 1],
            _ => return None,
        })
    }

    /// Rows of bytes for `height` rows of pixels, all planes together.
    pub fn rows(self, height: usize) -> usize {
        match self {
            PixelFormat::Nv12 => height + height.div_ceil(2),
            _ => height,
        }
    }
}

/// Reason why bytes and a size do not form an [`Image`].
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ImageError {
    /// Width or height is zero.
    #[error("the image is {width}×{height} pixels: both sides must be at least 1")]
    Empty {
        /// Requested width, in pixels.
        width: usize,
        /// Requested height, in pixels.
        height: usize,
    },
    /// A side is longer than the extractor accepts.
    #[error("the image is {width}×{height} pixels: scale it down to at most {MAX_SIDE} a side")]
    TooLarge {
        /// Requested width, in pixels.
        width: usize,
        /// Requested height, in pixels.
        height: usize,
    },
    /// The stride is shorter than a row.
    #[error(
        "a stride of {stride} bytes is shorter than one row of {width} pixels of {format:?} \
         ({needed} bytes): give the bytes from one row's start to the next"
    )]
    Stride {
        /// Stride given, in bytes.
        stride: usize,
        /// Bytes of one row.
        needed: usize,
        /// Width, in pixels.
        width: usize,
        /// The pixel format.
        format: PixelFormat,
    },
    /// There are fewer bytes than the size, stride and format require.
    #[error(
        "{width}×{height} pixels of {format:?} need {needed} bytes and only {given} were given: \
         check size, stride and pixel format"
    )]
    TooShort {
        /// Bytes given.
        given: usize,
        /// Bytes needed.
        needed: usize,
        /// Width, in pixels.
        width: usize,
        /// Height, in pixels.
        height: usize,
        /// The pixel format.
        format: PixelFormat,
    },
}

/// A borrowed picture, checked once so that every later read is in bounds.
#[derive(Clone, Copy, Debug)]
pub struct Image<'a> {
    bytes: &'a [u8],
    width: usize,
    height: usize,
    stride: usize,
    format: PixelFormat,
    /// In an `Nv12` picture, rows of bytes from the first one of Y to the first one of U and V.
    chroma: usize,
}

impl<'a> Image<'a> {
    /// Creates a picture of `width` × `height` pixels in `bytes`, with rows that start `stride`
    /// bytes apart.
    ///
    /// Bytes after the last row's last pixel may be missing; extra ones are ignored. Sides may be
    /// odd. A `Yuyv` or `Uyvy` row then holds one pixel more than is used, as does an `Nv12` plane
    /// of U and V.
    ///
    /// # Errors
    /// If a side is 0 or above 16,384, the stride is shorter than a row, or bytes are missing.
    pub fn new(
        bytes: &'a [u8],
        width: usize,
        height: usize,
        stride: usize,
        format: PixelFormat,
    ) -> Result<Self, ImageError> {
        if width == 0 || height == 0 {
            return Err(ImageError::Empty { width, height });
        }
        if width > MAX_SIDE || height > MAX_SIDE {
            return Err(ImageError::TooLarge { width, height });
        }
        let row = format.row_bytes(width);
        if stride < row {
            return Err(ImageError::Stride {
                stride,
                needed: row,
                width,
                format,
            });
        }
        let needed = stride
            .saturating_mul(format.rows(height) - 1)
            .saturating_add(row);
        if bytes.len() < needed {
            return Err(ImageError::TooShort {
                given: bytes.len(),
                needed,
                width,
                height,
                format,
            });
        }
        Ok(Self {
            bytes,
            width,
            height,
            stride,
            format,
            chroma: height,
        })
    }

    /// Returns a part of the picture as a picture of its own, in the same memory.
    ///
    /// `None` if the region is empty, is not inside the picture, or begins between pixels that
    /// share their color. [`Region::within`] returns one that is valid.
    pub fn region(&self, region: Region) -> Option<Self> {
        if region.within(self) != Some(region) {
            return None;
        }
        let Region {
            x,
            y,
            width,
            height,
        } = region;
        // `x` is even where color is shared. The bytes of the pixel or its pair, U and V included,
        // therefore begin here.
        let column = match self.format {
            PixelFormat::Gray8 | PixelFormat::Nv12 => x,
            PixelFormat::Rgb8 | PixelFormat::Bgr8 => 3 * x,
            PixelFormat::Yuyv | PixelFormat::Uyvy | PixelFormat::Gray16 => 2 * x,
            PixelFormat::Bgra8 => 4 * x,
            PixelFormat::BayerRggb8
            | PixelFormat::BayerBggr8
            | PixelFormat::BayerGrbg8
            | PixelFormat::BayerGbrg8 => x,
        };
        Some(Self {
            bytes: self.bytes.get(y * self.stride + column..)?,
            width,
            height,
            chroma: self.chroma - y + y / 2,
            ..*self
        })
    }

    /// Width in pixels.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height in pixels.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Bytes from one row's start to the next.
    pub fn stride(&self) -> usize {
        self.stride
    }

    /// The pixel format.
    pub fn format(&self) -> PixelFormat {
        self.format
    }

    /// All pixels as red, green and blue, row after row: the colors that masks use.
    pub fn to_rgb(&self) -> Vec<u8> {
        let mut rgb = Vec::with_capacity(3 * self.width * self.height);
        for y in 0..self.height {
            match self.format {
                PixelFormat::Rgb8 => rgb.extend_from_slice(self.row(y)),
                _ => (0..self.width).for_each(|x| rgb.extend_from_slice(&color::rgb(self, x, y))),
            }
        }
        rgb
    }

    /// All bytes, including those between rows.
    #[inline(always)]
    pub(crate) fn bytes(&self) -> &'a [u8] {
        self.bytes
    }

    /// The bytes of row `y` of the first plane, exactly as long as the row.
    ///
    /// # Panics
    /// If the image has no such row.
    pub fn row(&self, y: usize) -> &'a [u8] {
        let start = y * self.stride;
        &self.bytes[start..start + self.format.row_bytes(self.width)]
    }

    /// The bytes of the first plane from byte `from` of row `y`.
    #[inline(always)]
    pub(crate) fn bytes_from(&self, from: usize, y: usize) -> &'a [u8] {
        &self.bytes[y * self.stride + from..]
    }

    /// The bytes of some rows of the first plane, from the first one's start to the last one's end.
    pub(crate) fn rows(&self, rows: Range<usize>) -> &'a [u8] {
        let last = rows.end.saturating_sub(1) * self.stride;
        &self.bytes[rows.start * self.stride..last + self.format.row_bytes(self.width)]
    }

    /// For row `y` and each row after it, yields the bytes from byte `from` up to the same byte of
    /// the next row.
    pub(crate) fn rows_from(&self, from: usize, y: usize) -> impl Iterator<Item = &'a [u8]> {
        self.bytes[y * self.stride + from..].chunks(self.stride)
    }

    /// The bytes of U and V for row `y` of an `Nv12` picture.
    pub(crate) fn chroma_row(&self, y: usize) -> &'a [u8] {
        let start = self.chroma_line(y) * self.stride;
        &self.bytes[start..start + self.format.row_bytes(self.width)]
    }

    /// In an `Nv12` picture, rows of bytes from the first row to the U and V of row `y`.
    #[inline(always)]
    pub(crate) fn chroma_line(&self, y: usize) -> usize {
        self.chroma + y / 2
    }
}
