//! Header of an image.

#[cfg(feature = "transport")]
use iceoryx2::prelude::ZeroCopySend;

use crate::{PixelFormat, Trace};

message! {
    /// Header before the bytes of an image.
    ///
    /// It fills two cache lines. Both the header and the bytes that follow begin on a cache line.
    /// The transport's own payload alignment would align every single byte and take 64 times the
    /// memory.
    #[repr(align(64))]
    #[derive(Eq)]
    pub struct FrameHeader = "lariat.FrameHeader.v3" {
        /// Trace up to this stage.
        trace: Trace = Trace::EMPTY => message,
        /// Width in pixels; 0 [without an image](Self::is_blank).
        width: u32 = 0 => number,
        /// Height in pixels; 0 without an image.
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
    /// Pixel format; `None` for a number this version does not know.
    pub const fn format(&self) -> Option<PixelFormat> {
        PixelFormat::from_code(self.pixel_format)
    }

    /// Returns whether the frame lacks an image because the source could not give one when it was
    /// due. A stage still sends a result for such a frame, from what it already knows.
    pub const fn is_blank(&self) -> bool {
        self.width == 0 || self.height == 0
    }

    /// Header of a mask of this frame: `Gray8` of the same size without row padding, with the same
    /// trace.
    pub const fn of_mask(&self) -> Self {
        Self {
            stride: self.width,
            pixel_format: PixelFormat::Gray8 as u32,
            ..*self
        }
    }

    /// Header of a depth image of this frame: `Gray16` of its own size without row padding, with
    /// the same trace.
    pub const fn of_depth(&self, [width, height]: [u32; 2]) -> Self {
        Self {
            width,
            height,
            stride: 2 * width,
            pixel_format: PixelFormat::Gray16 as u32,
            ..*self
        }
    }

    /// Bytes of the whole image as described by the header; `None` if the format is unknown or a
    /// row does not fit its stride.
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
