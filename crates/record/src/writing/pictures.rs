//! Encodes frames as PNG or JPEG, which takes time but saves space.

use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use lariat_message::PixelFormat;

use crate::images::ImageRecord;
use crate::{CdrError, encode_compressed_image};

/// Encoding of recorded frames.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Images {
    /// Raw pixels.
    #[default]
    Raw,
    /// PNG: lossless for gray, RGB, BGR and BGRA, except for the unused byte of BGRA. YUV stays
    /// raw, since PNG would require RGB, which is larger and rounded. Bayer patterns stay raw as
    /// well.
    Png,
    /// JPEG of this quality, 1 to 100. Bayer patterns stay raw.
    Jpeg(u8),
    /// No images.
    None,
}

/// Makes picture files in memory that it reuses.
#[derive(Debug, Default)]
pub struct PictureMaker {
    rgb: Vec<u8>,
    file: Vec<u8>,
}

impl PictureMaker {
    /// Encodes a recorded image as a picture and writes it as `sensor_msgs/CompressedImage` into a
    /// buffer. Returns `false` if the image is to stay raw.
    ///
    /// # Errors
    /// Fails if the bytes are not a `sensor_msgs/Image`.
    pub fn make(
        &mut self,
        cdr: &[u8],
        images: Images,
        into: &mut Vec<u8>,
    ) -> Result<bool, CdrError> {
        let image = ImageRecord::decode(cdr)?;
        let Some(format) = image.format().filter(|_| image.is_whole()) else {
            return Ok(false);
        };
        let Some((pixels, color)) = pixels(&mut self.rgb, &image, format, images) else {
            return Ok(false);
        };
        let file = &mut self.file;
        file.clear();
        let (width, height) = (image.width, image.height);
        let (made, name) = match images {
            Images::Jpeg(quality) => {
                let encoder = JpegEncoder::new_with_quality(&mut *file, quality);
                (encoder.write_image(pixels, width, height, color), "jpeg")
            }
            _ => {
                // Fast compression yields files a third larger than the best compression does, in a
                // tenth of the time.
                let encoder = PngEncoder::new_with_quality(
                    &mut *file,
                    CompressionType::Fast,
                    FilterType::Adaptive,
                );
                (encoder.write_image(pixels, width, height, color), "png")
            }
        };
        // An image too large for the format (JPEG is limited to 65,535 pixels) is recorded raw.
        if made.is_ok() {
            encode_compressed_image(file, name, image.stamp_ns, image.frame_id, into);
        }
        Ok(made.is_ok())
    }
}

/// Returns the pixels in the form that the picture encoder needs, in `buffer` if they are
/// converted. `None` if the image stays raw.
fn pixels<'a>(
    buffer: &'a mut Vec<u8>,
    image: &ImageRecord<'a>,
    format: PixelFormat,
    images: Images,
) -> Option<(&'a [u8], ExtendedColorType)> {
    let data = image.data;
    match (format, images) {
        (_, Images::Raw | Images::None) => return None,
        (PixelFormat::Gray8, _) => return Some((data, ExtendedColorType::L8)),
        (PixelFormat::Rgb8, _) => return Some((data, ExtendedColorType::Rgb8)),
        // The PNG encoder takes 16-bit numbers in the machine's own byte order. JPEG has no 16-bit
        // numbers.
        (PixelFormat::Gray16, Images::Png) => return Some((data, ExtendedColorType::L16)),
        (PixelFormat::Gray16, _) => {
            buffer.clear();
            let wide = data.as_chunks().0.iter();
            let nearest = wide.map(|two| ((u32::from(u16::from_ne_bytes(*two)) + 128) / 257) as u8);
            buffer.extend(nearest);
            return Some((buffer, ExtendedColorType::L8));
        }
        (PixelFormat::Bgra8, _) => {
            buffer.clear();
            let turned = data.chunks_exact(4).flat_map(|p| [p[2], p[1], p[0]]);
            buffer.extend(turned);
        }
        (
            PixelFormat::BayerRggb8
            | PixelFormat::BayerBggr8
            | PixelFormat::BayerGrbg8
            | PixelFormat::BayerGbrg8,
            _,
        ) => return None,
        (PixelFormat::Bgr8, _) => {
            buffer.clear();
            let turned = data.chunks_exact(3).flat_map(|p| [p[2], p[1], p[0]]);
            buffer.extend(turned);
        }
        (_, Images::Png) => return None,
        (PixelFormat::Yuyv | PixelFormat::Uyvy | PixelFormat::Nv12, _) => {
            buffer.clear();
            let (width, height) = (image.width as usize, image.height as usize);
            for y in 0..height {
                for x in 0..width {
                    let yuv = yuv_at(data, format, image.step as usize, height, x, y);
                    buffer.extend(rgb(yuv));
                }
            }
        }
    }
    Some((buffer, ExtendedColorType::Rgb8))
}

/// Y, U and V of a pixel.
fn yuv_at(
    data: &[u8],
    format: PixelFormat,
    step: usize,
    height: usize,
    x: usize,
    y: usize,
) -> [u8; 3] {
    let row = &data[y * step..];
    let pair = 4 * (x / 2);
    match format {
        PixelFormat::Yuyv => [row[2 * x], row[pair + 1], row[pair + 3]],
        PixelFormat::Uyvy => [row[2 * x + 1], row[pair], row[pair + 2]],
        _ => {
            let colors = &data[(height + y / 2) * step..];
            let pair = 2 * (x / 2);
            // If the width is odd, the last pair may be cut off.
            let u = colors.get(pair).copied().unwrap_or(128);
            let v = colors.get(pair + 1).copied().unwrap_or(128);
            [row[x], u, v]
        }
    }
}

/// BT.601 in full range, as in extraction.
fn rgb([y, u, v]: [u8; 3]) -> [u8; 3] {
    let (y, u, v) = (f32::from(y), f32::from(u) - 128.0, f32::from(v) - 128.0);
    [
        y + 1.402 * v,
        y - 0.344_136 * u - 0.714_136 * v,
        y + 1.772 * u,
    ]
    .map(|level| level.round().clamp(0.0, 255.0) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{CompressedImageRecord, encode_image};
    use lariat_message::FrameHeader;

    const FORMATS: [PixelFormat; 8] = [
        PixelFormat::Bgra8,
        PixelFormat::Gray16,
        PixelFormat::Gray8,
        PixelFormat::Rgb8,
        PixelFormat::Bgr8,
        PixelFormat::Yuyv,
        PixelFormat::Uyvy,
        PixelFormat::Nv12,
    ];

    /// A brightness gradient as an image.
    fn slope(format: PixelFormat, width: u32, height: u32) -> Vec<u8> {
        let stride = format.row_bytes(width) as u32;
        let header = FrameHeader {
            width,
            height,
            stride,
            pixel_format: format as u32,
            ..FrameHeader::default()
        };
        let mut bytes = vec![128; header.image_bytes().unwrap()];
        for y in 0..height as usize {
            for x in 0..width as usize {
                let level = (2 * x + y) as u8;
                let row = y * stride as usize;
                match format {
                    PixelFormat::Gray8 | PixelFormat::Nv12 => bytes[row + x] = level,
                    PixelFormat::Rgb8 | PixelFormat::Bgr8 => {
                        bytes[row + 3 * x..row + 3 * x + 3].fill(level);
                    }
                    PixelFormat::Bgra8 => bytes[row + 4 * x..row + 4 * x + 3].fill(level),
                    PixelFormat::Gray16 => bytes[row + 2 * x..row + 2 * x + 2].fill(level),
                    PixelFormat::Yuyv => bytes[row + 2 * x] = level,
                    PixelFormat::Uyvy => bytes[row + 2 * x + 1] = level,
                    _ => {}
                }
            }
        }
        let mut cdr = Vec::new();
        assert!(encode_image(&header, &bytes, 5, "left", &mut cdr));
        cdr
    }

    #[test]
    fn a_jpeg_of_every_format_shows_what_the_frame_showed() {
        let (width, height) = (65, 33);
        for format in FORMATS {
            let mut maker = PictureMaker::default();
            let mut cdr = Vec::new();
            let frame = slope(format, width, height);
            assert!(maker.make(&frame, Images::Jpeg(95), &mut cdr).unwrap());
            let record = CompressedImageRecord::decode(&cdr).unwrap();
            assert_eq!((record.format, record.frame_id), ("jpeg", "left"));
            let picture = image::load_from_memory(record.data).unwrap().into_rgb8();
            for (x, y, pixel) in picture.enumerate_pixels() {
                let level = (2 * x + y) as i32;
                for channel in pixel.0 {
                    assert!((i32::from(channel) - level).abs() < 6, "{format:?} {x} {y}");
                }
            }
        }
    }

    #[test]
    fn a_png_is_exact_and_what_would_be_rounded_stays_as_it_is() {
        for format in FORMATS {
            let mut cdr = Vec::new();
            let frame = slope(format, 65, 33);
            let made = PictureMaker::default().make(&frame, Images::Png, &mut cdr);
            let exact = !matches!(
                format,
                PixelFormat::Yuyv | PixelFormat::Uyvy | PixelFormat::Nv12
            );
            assert_eq!(made, Ok(exact), "{format:?}");
            if exact {
                let record = CompressedImageRecord::decode(&cdr).unwrap();
                let picture = image::load_from_memory(record.data).unwrap().into_rgb8();
                assert!(
                    picture
                        .enumerate_pixels()
                        .all(|(x, y, pixel)| pixel.0 == [(2 * x + y) as u8; 3])
                );
            }
        }
    }

    #[test]
    fn a_mosaic_becomes_no_picture() {
        for images in [Images::Png, Images::Jpeg(90)] {
            let mut cdr = Vec::new();
            let frame = slope(PixelFormat::BayerRggb8, 64, 32);
            let made = PictureMaker::default().make(&frame, images, &mut cdr);
            assert_eq!(made, Ok(false));
        }
    }

    #[test]
    fn a_picture_too_large_for_its_format_stays_as_it_is() {
        let mut cdr = Vec::new();
        let frame = slope(PixelFormat::Gray8, 70_000, 1);
        let made = PictureMaker::default().make(&frame, Images::Jpeg(90), &mut cdr);
        assert_eq!(made, Ok(false));
    }
}
