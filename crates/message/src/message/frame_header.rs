//! What stands beside the bytes of an image.

#[cfg(feature = "transport")]
use iceoryx2::prelude::ZeroCopySend;

use crate::{PixelFormat, Trace};

message! {
    /// What stands beside the bytes of a frame.
    ///
    /// It fills two cache lines and begins on one, and so do the bytes that follow it. (The transport's own way to align
    /// the bytes would align each of them, and take 64 times the memory.)
    #[repr(align(64))]
    #[derive(Eq)]
    pub struct FrameHeader = "lariat.FrameHeader.v3" {
        /// The frame's way so far.
        trace: Trace = Trace::EMPTY => message,
        /// Pixels in a row; 0 if there is [no image](Self::is_blank).
        width: u32 = 0 => number,
        /// Rows; 0 likewise.
        height: u32 = 0 => number,
        /// Bytes from one row's start to the next.
        stride: u32 = 0 => number,
        /// A [`PixelFormat`]'s number.
        pixel_format: u32 = 0 => code(PixelFormat),
        /// A [`SourceKind`](crate::SourceKind)'s number.
        source: u32 = 0 => code(SourceKind),
        /// Always 0.
        reserved: [u32; 3] = [0; 3] => reserved,
    }
}

impl FrameHeader {
    /// How the bytes make pixels; `None` for a number this version does not know.
    pub const fn format(&self) -> Option<PixelFormat> {
        PixelFormat::from_code(self.pixel_format)
    }

    /// Whether there is no image: the source has none to give, though it is time for one. A reader has nothing to look at
    /// then, and sends on what it knows without.
    pub const fn is_blank(&self) -> bool {
        self.width == 0 || self.height == 0
    }

    /// What stands beside a mask of this frame: `Gray8` of its size, rows one after the other, with its trace.
    pub const fn of_mask(&self) -> Self {
        Self {
            stride: self.width,
            pixel_format: PixelFormat::Gray8 as u32,
            ..*self
        }
    }

    /// What stands beside a depth image of this frame: `Gray16` of its own size, rows one after the other, with its trace.
    pub const fn of_depth(&self, [width, height]: [u32; 2]) -> Self {
        Self {
            width,
            height,
            stride: 2 * width,
            pixel_format: PixelFormat::Gray16 as u32,
            ..*self
        }
    }

    /// Bytes of the whole image as the header describes it; `None` if the format is unknown or a row does not fit its stride.
    pub fn image_bytes(&self) -> Option<usize> {
        let format = self.format()?;
        (format.row_bytes(self.width) <= self.stride as usize)
            .then(|| format.image_bytes(self.stride, self.height))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SourceKind;

    #[test]
    fn it_begins_on_a_cache_line() {
        assert_eq!(align_of::<FrameHeader>(), 64);
    }

    #[test]
    fn a_header_that_lies_about_its_rows_has_no_size() {
        let header = FrameHeader {
            trace: Trace::EMPTY,
            width: 640,
            height: 480,
            stride: 1920,
            pixel_format: PixelFormat::Rgb8 as u32,
            source: SourceKind::Files as u32,
            reserved: [0; 3],
        };
        assert_eq!(header.image_bytes(), Some(640 * 480 * 3));
        assert_eq!(
            FrameHeader {
                stride: 1919,
                ..header
            }
            .image_bytes(),
            None
        );
        assert_eq!(
            FrameHeader {
                pixel_format: 99,
                ..header
            }
            .image_bytes(),
            None
        );
    }
}
