//! Images in schemas that ROS 2 and Foxglove display: `sensor_msgs/Image` and
//! `sensor_msgs/CompressedImage`.

use lariat_message::{FrameHeader, PixelFormat};

use crate::cdr::{Cdr, CdrError, Decoder, Encoder};
use crate::conversion::is_convertible;
use crate::schema::{Schema, schema};

const NS_PER_S: u64 = 1_000_000_000;

/// Schema of a raw image.
pub const IMAGE: Schema = schema!(
    "sensor_msgs/msg/Image",
    "Image.msg",
    "std_msgs/Header" = "Header.msg",
    "builtin_interfaces/Time" = "Time.msg"
);
/// Schema of an image as PNG or JPEG.
pub const COMPRESSED_IMAGE: Schema = schema!(
    "sensor_msgs/msg/CompressedImage",
    "CompressedImage.msg",
    "std_msgs/Header" = "Header.msg",
    "builtin_interfaces/Time" = "Time.msg"
);

/// Name of a pixel format in `sensor_msgs/image_encodings`. Most are the same as ours.
const fn encoding(format: PixelFormat) -> &'static str {
    match format {
        PixelFormat::Gray8 => "mono8",
        PixelFormat::Gray16 => "mono16",
        PixelFormat::Yuyv => "yuv422_yuy2",
        other => other.name(),
    }
}

fn format_of(name: &str) -> Option<PixelFormat> {
    let known = PixelFormat::ALL
        .into_iter()
        .find(|format| encoding(*format) == name);
    known.or(match name {
        "8UC1" => Some(PixelFormat::Gray8),
        "8UC3" => Some(PixelFormat::Bgr8),
        "8UC4" => Some(PixelFormat::Bgra8),
        "16UC1" => Some(PixelFormat::Gray16),
        "yuyv" => Some(PixelFormat::Yuyv),
        "yuv422" => Some(PixelFormat::Uyvy),
        _ => None,
    })
}

/// Writes `std_msgs/Header`. `stamp_ns` is in nanoseconds of Unix time.
pub fn put_header(to: &mut Encoder, stamp_ns: u64, frame_id: &str) {
    put_time(to, stamp_ns);
    to.string(frame_id);
}

pub(crate) fn put_time(to: &mut Encoder, ns: u64) {
    ((ns / NS_PER_S) as i32).put(to);
    ((ns % NS_PER_S) as u32).put(to);
}

pub(crate) fn stamp(from: &mut Decoder) -> Result<u64, CdrError> {
    let (s, ns): (i32, u32) = (from.value()?, from.value()?);
    Ok(s.max(0) as u64 * NS_PER_S + u64::from(ns))
}

/// Writes a frame as `sensor_msgs/Image` into a buffer, replacing its contents. Rows are written
/// without the padding between them in memory.
///
/// `stamp_ns` is the exposure, in nanoseconds of Unix time, and `rig` is the frame of reference.
/// Returns `false` and writes nothing if the header does not match the bytes, or if the frame has
/// no image.
pub fn encode_image(
    header: &FrameHeader,
    bytes: &[u8],
    stamp_ns: u64,
    rig: &str,
    into: &mut Vec<u8>,
) -> bool {
    let (Some(format), Some(size)) = (header.format(), header.image_bytes()) else {
        return false;
    };
    let Some(bytes) = bytes.get(..size).filter(|_| !header.is_blank()) else {
        return false;
    };
    let row = format.row_bytes(header.width);
    // Includes the rows of NV12's half-size plane.
    let rows = bytes.len() / header.stride as usize;
    let mut to = Encoder::new(into);
    put_header(&mut to, stamp_ns, rig);
    header.height.put(&mut to);
    header.width.put(&mut to);
    to.string(encoding(format));
    u8::from(cfg!(target_endian = "big")).put(&mut to);
    (row as u32).put(&mut to);
    to.byte_count(rows * row);
    if row == header.stride as usize {
        to.raw(bytes);
    } else {
        for padded in bytes.chunks_exact(header.stride as usize) {
            to.raw(&padded[..row]);
        }
    }
    true
}

/// An image in a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ImageRecord<'a> {
    /// Exposure time, in nanoseconds of Unix time.
    pub stamp_ns: u64,
    /// Frame of reference: the rig.
    pub frame_id: &'a str,
    /// Pixels per row.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
    /// Name of the pixel encoding.
    pub encoding: &'a str,
    /// True if the most significant byte of a number comes first.
    pub is_big_endian: bool,
    /// Bytes from the start of one row to the next.
    pub step: u32,
    /// The pixels.
    pub data: &'a [u8],
}

impl<'a> ImageRecord<'a> {
    /// Reads an image in place.
    ///
    /// # Errors
    /// Fails if the bytes are not a `sensor_msgs/Image`.
    pub fn decode(cdr: &'a [u8]) -> Result<Self, CdrError> {
        let mut from = Decoder::new(cdr)?;
        let stamp_ns = stamp(&mut from)?;
        let frame_id = from.string()?;
        let (height, width) = (from.value()?, from.value()?);
        let encoding = from.string()?;
        let is_big_endian = from.value::<u8>()? != 0;
        let step = from.value()?;
        let data = from.bytes()?;
        Ok(Self {
            stamp_ns,
            frame_id,
            width,
            height,
            encoding,
            is_big_endian,
            step,
            data,
        })
    }

    /// Returns the pixel format; `None` if lariat has no such format.
    pub fn format(&self) -> Option<PixelFormat> {
        let is_turned = self.is_big_endian != cfg!(target_endian = "big");
        // Gray16 is in this machine's byte order.
        format_of(self.encoding).filter(|format| !(is_turned && *format == PixelFormat::Gray16))
    }

    /// Returns true if the encoding is supported, directly or by [conversion](crate::convert).
    pub fn is_known(&self) -> bool {
        self.format().is_some() || is_convertible(self.encoding)
    }

    /// Returns whether the format is one of lariat's, and the number of bytes matches width, height
    /// and step.
    pub fn is_whole(&self) -> bool {
        let header = FrameHeader {
            width: self.width,
            height: self.height,
            stride: self.step,
            pixel_format: self.format().map_or(0, |format| format as u32),
            ..FrameHeader::default()
        };
        // Avoids overflow: no image this large is in memory.
        let fits = u64::from(self.step) * u64::from(self.height) <= 1 << 40;
        fits && header.image_bytes() == Some(self.data.len())
    }
}

/// Writes a picture file as `sensor_msgs/CompressedImage` into a buffer, replacing its contents.
/// `format` is `png` or `jpeg`; the rest is as in [`encode_image`].
pub fn encode_compressed_image(
    file: &[u8],
    format: &str,
    stamp_ns: u64,
    rig: &str,
    into: &mut Vec<u8>,
) {
    let mut to = Encoder::new(into);
    put_header(&mut to, stamp_ns, rig);
    to.string(format);
    to.byte_count(file.len());
    to.raw(file);
}

/// A picture file in a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CompressedImageRecord<'a> {
    /// Exposure time, in nanoseconds of Unix time.
    pub stamp_ns: u64,
    /// Frame of reference: the rig.
    pub frame_id: &'a str,
    /// `png` or `jpeg`, or another writer's name of the format.
    pub format: &'a str,
    /// The picture file.
    pub data: &'a [u8],
}

impl<'a> CompressedImageRecord<'a> {
    /// Reads a picture in place.
    ///
    /// # Errors
    /// Fails if the bytes are not a `sensor_msgs/CompressedImage`.
    pub fn decode(cdr: &'a [u8]) -> Result<Self, CdrError> {
        let mut from = Decoder::new(cdr)?;
        Ok(Self {
            stamp_ns: stamp(&mut from)?,
            frame_id: from.string()?,
            format: from.string()?,
            data: from.bytes()?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header(format: PixelFormat, width: u32, height: u32, stride: u32) -> FrameHeader {
        FrameHeader {
            width,
            height,
            stride,
            pixel_format: format as u32,
            ..FrameHeader::default()
        }
    }

    #[test]
    fn an_image_comes_back_without_the_padding_of_its_rows() {
        for (format, row, rows) in [
            (PixelFormat::Gray8, 6, 3),
            (PixelFormat::Rgb8, 18, 3),
            (PixelFormat::Bgr8, 18, 3),
            (PixelFormat::Yuyv, 12, 3),
            (PixelFormat::Uyvy, 12, 3),
            (PixelFormat::Nv12, 6, 5),
            (PixelFormat::Bgra8, 24, 3),
            (PixelFormat::Gray16, 12, 3),
            (PixelFormat::BayerRggb8, 6, 3),
            (PixelFormat::BayerBggr8, 6, 3),
            (PixelFormat::BayerGrbg8, 6, 3),
            (PixelFormat::BayerGbrg8, 6, 3),
        ] {
            for padding in [0, 7] {
                let stride = row + padding;
                let header = header(format, 6, 3, stride as u32);
                let bytes: Vec<u8> = (0..(stride * rows + 5) as u32).map(|i| i as u8).collect();
                let mut cdr = Vec::new();
                let stamp_ns = 1_700_000_000_123_456_789;
                assert!(encode_image(&header, &bytes, stamp_ns, "left", &mut cdr));
                let image = ImageRecord::decode(&cdr).unwrap();
                assert_eq!((image.width, image.height, image.step), (6, 3, row as u32));
                assert_eq!((image.stamp_ns, image.frame_id), (stamp_ns, "left"));
                assert_eq!(image.format(), Some(format));
                assert!(image.is_whole());
                let expected: Vec<u8> = (0..rows)
                    .flat_map(|y| bytes[y * stride..y * stride + row].to_vec())
                    .collect();
                assert_eq!(image.data, expected, "{format:?}, padding {padding}");
            }
        }
    }

    #[test]
    fn what_is_no_image_is_not_written() {
        let mut cdr = vec![7];
        let short = header(PixelFormat::Gray8, 6, 3, 6);
        let unknown = FrameHeader {
            pixel_format: 99,
            ..short
        };
        for header in [short, unknown, FrameHeader::default()] {
            assert!(!encode_image(&header, &[0; 17], 0, "", &mut cdr));
            assert_eq!(cdr, [7]);
        }
    }

    #[test]
    fn an_image_that_lies_about_its_size_is_not_whole() {
        let image = ImageRecord {
            stamp_ns: 0,
            frame_id: "",
            width: 6,
            height: 3,
            encoding: "mono8",
            is_big_endian: false,
            step: 6,
            data: &[0; 18],
        };
        assert!(image.is_whole());
        assert!(!ImageRecord { height: 4, ..image }.is_whole());
        assert!(!ImageRecord { step: 5, ..image }.is_whole());
        assert!(!ImageRecord { width: 7, ..image }.is_whole());
        let turned = cfg!(target_endian = "little");
        let wide = ImageRecord {
            width: 3,
            encoding: "mono16",
            is_big_endian: turned,
            ..image
        };
        assert!(!wide.is_whole(), "numbers in another machine's order");
        let is_big_endian = !turned;
        assert!(
            ImageRecord {
                is_big_endian,
                ..wide
            }
            .is_whole()
        );
        let huge = u32::MAX;
        let huge = ImageRecord {
            height: huge,
            step: huge,
            ..image
        };
        assert!(!huge.is_whole());
    }

    #[test]
    fn a_picture_file_comes_back() {
        let mut cdr = Vec::new();
        encode_compressed_image(b"PNG...", "png", 5, "default", &mut cdr);
        let picture = CompressedImageRecord::decode(&cdr).unwrap();
        assert_eq!((picture.format, picture.data), ("png", &b"PNG..."[..]));
        assert_eq!((picture.stamp_ns, picture.frame_id), (5, "default"));
    }
}
