//! A part of a picture. Nothing outside of it is read.
//!
//! The setting `roi` makes the extractor's image a view into the same memory (`Image::region`). No
//! pixel outside counts, although a wide load may read some. Its edge is the image's edge to the
//! extractor: a rope that crosses it *leaves the image*. Points, crossings, `start` and masks from
//! elsewhere refer to the whole image.
//!
//! If pixels share their color, the region begins at an even column (YUYV, NV12, Bayer) and row
//! (NV12, Bayer). This may be one pixel before the requested start.

use super::{Image, PixelFormat};

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region {
    /// The first column.
    pub x: usize,
    /// The first row.
    pub y: usize,
    /// Number of columns.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
}

impl Region {
    /// The region of a whole image.
    pub(crate) fn whole(image: &Image) -> Self {
        Self {
            x: 0,
            y: 0,
            width: image.width(),
            height: image.height(),
        }
    }

    /// Returns the part of the region that is in an image; `None` if no part is.
    ///
    /// If pixels share their color, the part begins with the first of them. For an odd requested
    /// start, that is one column earlier in `Yuyv`, `Uyvy`, `Nv12` and the Bayer patterns. In
    /// `Nv12` and the Bayer patterns, the same holds for rows.
    pub fn within(&self, image: &Image) -> Option<Self> {
        let [even_x, even_y] = match image.format() {
            PixelFormat::Gray8 | PixelFormat::Rgb8 | PixelFormat::Bgr8 => [false, false],
            PixelFormat::Bgra8 | PixelFormat::Gray16 => [false, false],
            PixelFormat::Yuyv | PixelFormat::Uyvy => [true, false],
            PixelFormat::Nv12
            | PixelFormat::BayerRggb8
            | PixelFormat::BayerBggr8
            | PixelFormat::BayerGrbg8
            | PixelFormat::BayerGbrg8 => [true, true],
        };
        let begin = |at: usize, even: bool| if even { at & !1 } else { at };
        let (x, y) = (begin(self.x, even_x), begin(self.y, even_y));
        let right = self.x.saturating_add(self.width).min(image.width());
        let bottom = self.y.saturating_add(self.height).min(image.height());
        let inside = self.x < right && self.y < bottom;
        inside.then(|| Self {
            x,
            y,
            width: right - x,
            height: bottom - y,
        })
    }
}
