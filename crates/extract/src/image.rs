//! A borrowed picture in the camera's own pixel format: the only thing the extractor reads.

use crate::color;
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
}

impl PixelFormat {
    /// Bytes that hold one row of `width` pixels (of the first plane).
    pub(crate) fn row_bytes(self, width: usize) -> usize {
        match self {
            PixelFormat::Gray8 => width,
            PixelFormat::Rgb8 | PixelFormat::Bgr8 => 3 * width,
            PixelFormat::Yuyv | PixelFormat::Uyvy => 4 * width.div_ceil(2),
            PixelFormat::Nv12 => 2 * width.div_ceil(2),
        }
    }

    /// Rows of bytes, all planes together.
    fn rows(self, height: usize) -> usize {
        match self {
            PixelFormat::Nv12 => height + height.div_ceil(2),
            _ => height,
        }
    }
}

/// Why bytes and a size do not make an [`Image`].
#[derive(Clone, Debug, PartialEq, Eq, Error)]
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
        let rows = 0..self.height;
        rows.flat_map(|y| (0..self.width).flat_map(move |x| color::rgb(self, x, y)))
            .collect()
    }

    /// All bytes, those between the rows as well.
    #[inline(always)]
    pub(crate) fn bytes(&self) -> &'a [u8] {
        self.bytes
    }

    /// The bytes of row `y` of the first plane, exactly as long as the row.
    pub(crate) fn row(&self, y: usize) -> &'a [u8] {
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
        let start = (self.height + y / 2) * self.stride;
        &self.bytes[start..start + self.format.row_bytes(self.width)]
    }
}
