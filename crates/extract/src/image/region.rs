//! A part of a picture: what lies outside of it is not read.
//!
//! `roi` makes the extractor's image a view into the same memory (`Image::region`): no pixel outside is read, or, where
//! a wide load takes in some, counts. Its edge is the image's edge to the extractor: a rope that crosses it *leaves the image*. Points,
//! crossings, `start` and masks from elsewhere are those of the whole image. Where pixels share their colour it begins at an even
//! column (YUYV, NV12, Bayer) and row (NV12, Bayer), a pixel before what was asked for.

use super::{Image, PixelFormat};

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region {
    /// The first column.
    pub x: usize,
    /// The first row.
    pub y: usize,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

impl Region {
    /// All of an image.
    pub(crate) fn whole(image: &Image) -> Self {
        Self {
            x: 0,
            y: 0,
            width: image.width(),
            height: image.height(),
        }
    }

    /// What of the region lies in an image; `None` if nothing does.
    ///
    /// Where pixels share their colour it begins with the first of those that do: in `Yuyv` and `Uyvy` one column, in `Nv12` and the
    /// Bayer patterns also one row earlier than asked for, if that is an odd one.
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
