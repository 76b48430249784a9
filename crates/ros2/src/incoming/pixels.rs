//! Converts the pixels of a ROS image to those of a frame: rows without gaps. Pure.

use std::borrow::Cow;
use std::io::Cursor;

use image::{ColorType, ImageReader, Limits};
use lariat_record::{ImageRecord, convert};
use lariat_wire::PixelFormat;

use super::Trouble;
use super::received::Image;

/// Maximum number of pixels along a side, as for frames.
const MAX_SIDE: u32 = 8192;

/// An image with the number of bytes that it declares.
#[derive(Debug, Clone)]
pub(super) struct Pixels<'a> {
    pub(super) width: u32,
    pub(super) height: u32,
    /// Format after conversion.
    pub(super) format: PixelFormat,
    step: usize,
    /// The original bytes, or the converted ones.
    data: Cow<'a, [u8]>,
}

impl<'a> Pixels<'a> {
    /// Checks an image's fields and converts it if necessary.
    ///
    /// # Errors
    /// The encoding is not supported, or the numbers are inconsistent.
    pub(super) fn of(image: &'a Image) -> Result<Self, Trouble> {
        let record = ImageRecord {
            stamp_ns: 0,
            frame_id: "",
            width: image.width,
            height: image.height,
            encoding: &image.encoding,
            is_big_endian: image.is_bigendian != 0,
            step: image.step,
            data: image.data,
        };
        if !record.is_known() {
            return Err(Trouble::Encoding(shown(&image.encoding)));
        }
        let as_it_is = record.format().filter(|_| record.is_whole());
        let (format, step, data) = match as_it_is.filter(|_| !image.data.is_empty()) {
            Some(format) => (format, image.step, Cow::Borrowed(image.data)),
            None => {
                let mut pixels = Vec::new();
                let converted = convert(&record, &mut pixels).ok_or_else(|| Trouble::Size {
                    width: image.width,
                    height: image.height,
                    encoding: image.encoding.clone(),
                    step: image.step,
                    bytes: image.data.len(),
                })?;
                (converted.format, converted.stride, Cow::Owned(pixels))
            }
        };
        Ok(Self {
            width: image.width,
            height: image.height,
            format,
            step: step as usize,
            data,
        })
    }

    /// Copies the rows into a slice of exactly their size.
    pub(super) fn copy_to(&self, into: &mut [u8]) {
        let row = self.format.row_bytes(self.width);
        let rows = into
            .chunks_exact_mut(row)
            .zip(self.data.chunks_exact(self.step));
        if row == self.step {
            into.copy_from_slice(&self.data);
        } else {
            rows.for_each(|(to, from)| to.copy_from_slice(&from[..row]));
        }
    }
}

/// A decoded image file.
#[derive(Debug)]
pub(super) struct Decoded {
    pub(super) width: u32,
    pub(super) height: u32,
    /// `Gray8` or `Rgb8`.
    pub(super) format: PixelFormat,
    pub(super) bytes: Vec<u8>,
}

/// Decodes an image file.
///
/// # Errors
/// It is not an image, is damaged, or is larger than a frame may be.
pub(super) fn decode(file: &[u8]) -> Result<Decoded, Trouble> {
    let read = || {
        let mut reader = ImageReader::new(Cursor::new(file)).with_guessed_format()?;
        let mut limits = Limits::default();
        (limits.max_image_width, limits.max_image_height) = (Some(MAX_SIDE), Some(MAX_SIDE));
        reader.limits(limits);
        reader.decode()
    };
    let picture = read().map_err(|cause| Trouble::File(cause.to_string()))?;
    let (width, height) = (picture.width(), picture.height());
    let is_gray = matches!(
        picture.color(),
        ColorType::L8 | ColorType::La8 | ColorType::L16 | ColorType::La16
    );
    let (format, bytes) = if is_gray {
        (PixelFormat::Gray8, picture.into_luma8().into_raw())
    } else {
        (PixelFormat::Rgb8, picture.into_rgb8().into_raw())
    };
    Ok(Decoded {
        width,
        height,
        format,
        bytes,
    })
}

/// Text from another node, shortened for an error message.
pub(super) fn shown(text: &str) -> String {
    let short: String = text.chars().filter(|c| !c.is_control()).take(24).collect();
    format!("\"{short}\"")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::incoming::received::tests::image;

    fn copied(pixels: &Pixels) -> Vec<u8> {
        let row = pixels.format.row_bytes(pixels.width);
        let mut into = vec![0; row * pixels.format.rows(pixels.height)];
        pixels.copy_to(&mut into);
        into
    }

    #[test]
    fn rows_are_copied_without_what_lies_between_them() {
        let counted: Vec<u8> = (0..=255).collect();
        for (encoding, format, row, rows) in [
            ("rgb8", PixelFormat::Rgb8, 12, 2),
            ("bgr8", PixelFormat::Bgr8, 12, 2),
            ("bgra8", PixelFormat::Bgra8, 16, 2),
            ("mono8", PixelFormat::Gray8, 4, 2),
            ("8UC1", PixelFormat::Gray8, 4, 2),
            ("yuv422_yuy2", PixelFormat::Yuyv, 8, 2),
            ("uyvy", PixelFormat::Uyvy, 8, 2),
            ("nv12", PixelFormat::Nv12, 4, 3),
            ("bayer_rggb8", PixelFormat::BayerRggb8, 4, 2),
        ] {
            for padding in [0, 3] {
                let step = row + padding;
                let image = image(encoding, [4, 2], step as u32, &counted[..step * rows]);
                let pixels = Pixels::of(&image).expect(encoding);
                assert_eq!(pixels.format, format);
                let expected: Vec<u8> = (0..rows)
                    .flat_map(|y| counted[y * step..y * step + row].to_vec())
                    .collect();
                assert_eq!(copied(&pixels), expected, "{encoding}, padding {padding}");
            }
        }
        let image = image("rgba8", [2, 1], 9, &counted[..9]);
        let pixels = Pixels::of(&image).expect("rgba8");
        assert_eq!(pixels.format, PixelFormat::Rgb8);
        assert_eq!(copied(&pixels), [0, 1, 2, 4, 5, 6]);
    }

    #[test]
    fn an_image_that_lies_about_itself_is_refused_with_a_sentence() {
        let bytes = [0; 64];
        for (encoding, size, step, bytes) in [
            ("rgb8", [4, 2], 11, &bytes[..22]),
            ("rgb8", [4, 2], 12, &bytes[..23]),
            ("rgba8", [4, 2], 12, &bytes[..24]),
            ("mono8", [0, 0], 0, &bytes[..0]),
            ("mono8", [0, 2], 4, &bytes[..8]),
            ("mono8", [u32::MAX, u32::MAX], u32::MAX, &bytes[..]),
            ("nv12", [4, 2], 4, &bytes[..8]),
        ] {
            let image = image(encoding, size, step, bytes);
            let trouble = Pixels::of(&image).err();
            assert!(
                matches!(trouble, Some(Trouble::Size { .. }))
                    // An image without rows is refused by the writer of frames.
                    || size[0] == 0 && trouble.is_none(),
                "{encoding} {size:?}: {trouble:?}"
            );
        }
        let unknown = image("nv\n24", [4, 2], 4, &bytes[..8]);
        let said = Pixels::of(&unknown).expect_err("unknown").to_string();
        assert!(said.contains("\"nv24\"") && said.contains("rgb8"), "{said}");
    }

    #[test]
    fn a_picture_file_is_read_and_what_is_none_is_refused() {
        let mut file = Cursor::new(Vec::new());
        let picture = image::RgbImage::from_fn(3, 2, |x, y| image::Rgb([x as u8, y as u8, 7]));
        picture
            .write_to(&mut file, image::ImageFormat::Png)
            .expect("a PNG");
        let file = file.into_inner();
        let read = decode(&file).expect("a picture");
        assert_eq!(
            (read.width, read.height, read.format),
            (3, 2, PixelFormat::Rgb8)
        );
        assert_eq!(read.bytes, picture.into_raw());
        for broken in [&file[..file.len() / 2], b"no picture", b""] {
            assert!(matches!(decode(broken), Err(Trouble::File(_))));
        }
    }
}
