//! A frame that the bench owns, with the chain's memory layout.

use lariat_extract::{Image, PixelFormat};

/// Alignment of a frame's first byte in the chain's shared memory: a cache line, which is also the
/// widest load.
const ALIGNMENT: usize = 64;

/// A frame without padding between its rows, aligned to a cache line.
#[derive(Debug)]
pub struct Picture {
    memory: Vec<u8>,
    bytes: usize,
    width: usize,
    height: usize,
    format: PixelFormat,
}

impl Picture {
    /// Creates a frame of `width` × `height` pixels, filled by `write`. Returns `None` if `bytes`
    /// does not match such an image.
    pub fn new(
        [width, height]: [usize; 2],
        format: PixelFormat,
        bytes: usize,
        write: impl FnOnce(&mut [u8]),
    ) -> Option<Self> {
        let mut picture = Self {
            memory: vec![0; bytes + ALIGNMENT - 1],
            bytes,
            width,
            height,
            format,
        };
        let start = picture.start();
        write(&mut picture.memory[start..start + bytes]);
        picture.checked().is_some().then_some(picture)
    }

    /// Creates a frame of red, green and blue bytes. Returns `None` if their number does not match
    /// the size.
    pub fn rgb(size: [usize; 2], rgb: &[u8]) -> Option<Self> {
        if rgb.len() != 3 * size[0] * size[1] {
            return None;
        }
        Self::new(size, PixelFormat::Rgb8, rgb.len(), |bytes| {
            bytes.copy_from_slice(rgb);
        })
    }

    fn start(&self) -> usize {
        let off = self.memory.as_ptr().align_offset(ALIGNMENT);
        // Memory that cannot be aligned is measured as it is.
        if off < ALIGNMENT { off } else { 0 }
    }

    /// Returns all bytes of the frame.
    pub fn bytes(&self) -> &[u8] {
        let start = self.start();
        &self.memory[start..start + self.bytes]
    }

    /// Returns width and height, in pixels.
    pub fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// Returns the pixel format.
    pub fn format(&self) -> PixelFormat {
        self.format
    }

    /// Returns the frame as an image for the extractor.
    pub fn image(&self) -> Image<'_> {
        self.checked()
            .expect("new() made sure that the bytes are an image, and they do not change")
    }

    fn checked(&self) -> Option<Image<'_>> {
        let stride = self.format.row_bytes(self.width);
        Image::new(self.bytes(), self.width, self.height, stride, self.format).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_begins_on_a_cache_line() {
        let rgb: Vec<u8> = (0..3 * 5 * 4).collect();
        let picture = Picture::rgb([5, 4], &rgb).unwrap();
        assert_eq!(picture.bytes(), rgb);
        assert_eq!(picture.bytes().as_ptr().align_offset(ALIGNMENT), 0);
        assert_eq!(picture.image().stride(), 15);
    }

    #[test]
    fn bytes_of_another_size_are_no_picture() {
        assert!(Picture::rgb([5, 4], &[0; 59]).is_none());
        assert!(Picture::new([5, 4], PixelFormat::Nv12, 20, |_| {}).is_none());
    }
}
