//! A borrowed picture in the camera's own pixel format: the only thing the extractor reads.

use super::{Region, color};
use std::ops::Range;
use thiserror::Error;

/// Longest side accepted, so that positions and areas stay far from any overflow.
const MAX_SIDE: usize = 16_384;

/// How the bytes of an [`Image`] encode its pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PixelFormat {
    /// One byte a pixel: brightness.
    Gray8,
    /// Three bytes a pixel: red, green, blue.
    Rgb8,
    /// Three bytes a pixel: blue, green, red.
    Bgr8,
    /// Four bytes for two pixels side by side: Y₀ U Y₁ V (BT.601, full range).
    Yuyv,
    /// The same in another order: U Y₀ V Y₁.
    Uyvy,
    /// A plane of Y, then a plane of half the height of U V pairs, each for 2×2 pixels, both of the
    /// same stride (BT.601, full range).
    Nv12,
    /// Four bytes a pixel: blue, green, red, and one that is not looked at.
    Bgra8,
    /// Two bytes of brightness a pixel, in the machine's own order; of all 65,536 levels the nearest of 256 is read.
    Gray16,
    /// One byte a pixel, behind a mosaic of colour filters: R G in the first row, G B in the second, and so on. The
    /// colours that a pixel lacks are made of its neighbours about it, evenly, so that nothing is displaced.
    BayerRggb8,
    /// The same of B G and G R.
    BayerBggr8,
    /// The same of G R and B G.
    BayerGrbg8,
    /// The same of G B and R G.
    BayerGbrg8,
}

impl PixelFormat {
    /// Those that are read as they are.
    #[cfg(test)]
    pub(crate) const DIRECT: [Self; 6] = [
        Self::Gray8,
        Self::Rgb8,
        Self::Bgr8,
        Self::Yuyv,
        Self::Uyvy,
        Self::Nv12,
    ];

    /// Bytes that hold one row of `width` pixels (of the first plane).
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

    /// The column and the row of the first red pixel of a Bayer pattern.
    pub(crate) fn red(self) -> Option<[usize; 2]> {
        Some(match self {
            PixelFormat::BayerRggb8 => [0, 0],
            PixelFormat::BayerBggr8 => [1, 1],
            PixelFormat::BayerGrbg8 => [1, 0],
            PixelFormat::BayerGbrg8 => [0, 1],
            _ => return None,
        })
    }

    /// Rows of bytes, all planes together.
    pub fn rows(self, height: usize) -> usize {
        match self {
            PixelFormat::Nv12 => height + height.div_ceil(2),
            _ => height,
        }
    }
}

/// Why bytes and a size do not make an [`Image`].
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ImageError {
    /// Width or height is zero.
    #[error("the image is {width}×{height} pixels: both sides must be at least 1")]
    Empty {
        /// Width asked for, in pixels.
        width: usize,
        /// Height asked for, in pixels.
        height: usize,
    },
    /// A side is longer than the extractor takes.
    #[error("the image is {width}×{height} pixels: scale it down to at most {MAX_SIDE} a side")]
    TooLarge {
        /// Width asked for, in pixels.
        width: usize,
        /// Height asked for, in pixels.
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
        /// Bytes that one row takes.
        needed: usize,
        /// Width, in pixels.
        width: usize,
        /// The pixel format.
        format: PixelFormat,
    },
    /// Fewer bytes than the size, the stride and the format ask for.
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

/// A picture that somebody else owns, checked once so that every later read is in bounds.
#[derive(Clone, Copy, Debug)]
pub struct Image<'a> {
    bytes: &'a [u8],
    width: usize,
    height: usize,
    stride: usize,
    format: PixelFormat,
    /// Rows of bytes from the first one of Y to the first one of U and V, of an `Nv12` picture.
    chroma: usize,
}

impl<'a> Image<'a> {
    /// A picture of `width` × `height` pixels in `bytes`, whose rows start `stride` bytes apart.
    ///
    /// Bytes after the last row's last pixel may be missing; more are ignored. Sides may be odd: a
    /// `Yuyv` or `Uyvy` row then holds one pixel more than is used, as does an `Nv12` plane of U and V.
    ///
    /// # Errors
    /// When a side is 0 or above 16,384, the stride is shorter than a row, or bytes are missing.
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

    /// A part of the picture, in the same memory, as a picture of its own. `None` if the region does not lie in it, is
    /// empty, or begins within pixels that share their colour ([`Region::within`] makes one that does not).
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
        // Where colour is shared x is even: then this is where the pixel's, or its pair's, bytes begin, of U and V too.
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

    /// How the bytes encode pixels.
    pub fn format(&self) -> PixelFormat {
        self.format
    }

    /// All pixels as red, green and blue, row after row: the colours that masks go by.
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

    /// All bytes, those between the rows as well.
    #[inline(always)]
    pub(crate) fn bytes(&self) -> &'a [u8] {
        self.bytes
    }

    /// The bytes of row `y` of the first plane, exactly as long as the row.
    ///
    /// # Panics
    /// The image has no such row.
    pub fn row(&self, y: usize) -> &'a [u8] {
        let start = y * self.stride;
        &self.bytes[start..start + self.format.row_bytes(self.width)]
    }

    /// The bytes of the first plane from byte `from` of row `y` on.
    #[inline(always)]
    pub(crate) fn bytes_from(&self, from: usize, y: usize) -> &'a [u8] {
        &self.bytes[y * self.stride + from..]
    }

    /// The bytes of some rows of the first plane, from the first one's start to the last one's end.
    pub(crate) fn rows(&self, rows: Range<usize>) -> &'a [u8] {
        let last = rows.end.saturating_sub(1) * self.stride;
        &self.bytes[rows.start * self.stride..last + self.format.row_bytes(self.width)]
    }

    /// The bytes of the first plane from byte `from` of row `y` on, and of each row after it, up to the next one's.
    pub(crate) fn rows_from(&self, from: usize, y: usize) -> impl Iterator<Item = &'a [u8]> {
        self.bytes[y * self.stride + from..].chunks(self.stride)
    }

    /// The bytes of U and V for row `y` of an `Nv12` picture.
    pub(crate) fn chroma_row(&self, y: usize) -> &'a [u8] {
        let start = self.chroma_line(y) * self.stride;
        &self.bytes[start..start + self.format.row_bytes(self.width)]
    }

    /// How many rows of bytes after the first the U and V for row `y` of an `Nv12` picture stand.
    #[inline(always)]
    pub(crate) fn chroma_line(&self, y: usize) -> usize {
        self.chroma + y / 2
    }
}
