//! Reads an image message: raw pixels, pixels to convert, or a picture file, whose first bytes
//! identify its kind.

use std::ops::Range;

use lariat_message::{FrameHeader, SourceKind, Trace};

use super::entry::Pixels;
use crate::cdr::CdrError;
use crate::conversion::convert;
use crate::{CompressedImageRecord, ImageRecord};

/// Kind and location of a frame's bytes.
#[derive(Debug, Clone)]
pub(super) enum Bytes {
    None,
    Raw(Place),
    Png(Place),
    Jpeg(Place),
    Other(Place),
}

/// Location of bytes.
#[derive(Debug, Clone)]
pub(super) enum Place {
    /// In the records of the loaded part.
    Records(Range<usize>),
    /// In the memory of the message's reader.
    Room,
    /// In the output of the conversion.
    Converted,
}

impl Place {
    /// Locates a slice in the records. Bytes from elsewhere are in the reader's memory.
    fn of(part: &[u8], records: &[u8]) -> Self {
        match records.as_ptr_range().contains(&part.as_ptr()) {
            true => {
                let begin = part.as_ptr().addr() - records.as_ptr().addr();
                Self::Records(begin..begin + part.len())
            }
            false => Self::Room,
        }
    }
}

impl Bytes {
    /// Returns the bytes themselves.
    pub(super) fn lend<'a>(
        self,
        records: &'a [u8],
        room: &'a [u8],
        converted: &'a [u8],
    ) -> Pixels<'a> {
        let bytes = |place| match place {
            Place::Records(range) => &records[range],
            Place::Room => room,
            Place::Converted => converted,
        };
        match self {
            Self::None => Pixels::None,
            Self::Raw(place) => Pixels::Raw(bytes(place)),
            Self::Png(place) => Pixels::Png(bytes(place)),
            Self::Jpeg(place) => Pixels::Jpeg(bytes(place)),
            Self::Other(place) => Pixels::Other(bytes(place)),
        }
    }
}

/// Error in a message.
pub(super) enum Wrong {
    Cdr(CdrError),
    Image,
    Encoding(String),
    Depth,
}

impl From<CdrError> for Wrong {
    fn from(why: CdrError) -> Self {
        Self::Cdr(why)
    }
}

/// Reads an image, with the header that came before it or with a header made from the image.
/// Encodings that frames do not have are converted.
pub(super) fn raw(
    image: ImageRecord,
    known: Option<FrameHeader>,
    records: &[u8],
    converted: &mut Vec<u8>,
) -> Result<(FrameHeader, Bytes), Wrong> {
    if !image.is_known() {
        return Err(Wrong::Encoding(image.encoding.to_owned()));
    }
    let (format, stride, place) = match image.format().filter(|_| image.is_whole()) {
        Some(format) => (format, image.step, Place::of(image.data, records)),
        None => {
            let made = convert(&image, converted).ok_or(Wrong::Image)?;
            (made.format, made.stride, Place::Converted)
        }
    };
    let of_image = FrameHeader {
        width: image.width,
        height: image.height,
        stride,
        pixel_format: format as u32,
        ..known.unwrap_or_else(|| header_of(image.stamp_ns))
    };
    let agrees = known.is_none_or(|known| {
        let size = (known.width, known.height, known.pixel_format);
        size == (of_image.width, of_image.height, of_image.pixel_format)
    });
    match agrees {
        true => Ok((of_image, Bytes::Raw(place))),
        false => Err(Wrong::Image),
    }
}

/// Bytes before the PNG of a depth image of image transport: its kind, and two parameters of its
/// quantization.
const DEPTH_HEAD_BYTES: usize = 12;

/// Reads a picture file. Its bytes identify its kind. The format named by the writer is used only
/// if the bytes are not recognized.
pub(super) fn picture(
    picture: CompressedImageRecord,
    known: Option<FrameHeader>,
    records: &[u8],
) -> Result<(FrameHeader, Bytes), Wrong> {
    let header = known.unwrap_or_else(|| header_of(picture.stamp_ns));
    let place = Place::of(picture.data, records);
    // ROS writes formats such as `rgb8; jpeg compressed bgr8`.
    let is = |name: &str| picture.format.contains(name);
    let behind_head = picture.data.get(DEPTH_HEAD_BYTES..).unwrap_or_default();
    let of_bytes = image::guess_format(picture.data).ok();
    if of_bytes.is_none() && (is("compressedDepth") || behind_head.starts_with(PNG)) {
        return Err(Wrong::Depth);
    }
    let bytes = match of_bytes {
        Some(image::ImageFormat::Png) => Bytes::Png(place),
        Some(image::ImageFormat::Jpeg) => Bytes::Jpeg(place),
        Some(_) => Bytes::Other(place),
        None if is("png") => Bytes::Png(place),
        None if is("jpeg") || is("jpg") => Bytes::Jpeg(place),
        None => return Err(Wrong::Encoding(picture.format.to_owned())),
    };
    Ok((header, bytes))
}

/// Signature of PNG files.
const PNG: &[u8] = b"\x89PNG\r\n\x1a\n";

/// Header for an image of another program.
fn header_of(stamp_ns: u64) -> FrameHeader {
    FrameHeader {
        trace: Trace {
            exposed_ns: stamp_ns,
            captured_ns: stamp_ns,
            ..Trace::EMPTY
        },
        source: SourceKind::Files as u32,
        ..FrameHeader::default()
    }
}
