//! A camera's MJPG frames. Each is a complete JPEG, decoded straight into lent memory.
//!
//! zune-jpeg decodes. This module handles what cameras do and picture files do not: missing Huffman
//! tables ([`tables`]), bytes after the end of the image, frames cut off by lost packets, and a
//! size other than the negotiated one.
//!
//! Frames with color become `Rgb8`. The decoder converts YUV to RGB in SIMD registers while a row
//! is at hand. Decoding to interleaved YUV would take equally long, and packing that into `Yuyv`
//! would need one more pass over memory. Extraction takes equally long for both formats. `Rgb8`
//! also leaves no doubt about the range: YUV in a JPEG is BT.601 in full range (JFIF 1.02), but a
//! camera's `YUYV` mostly has video range.

mod head;
mod tables;

pub(crate) use tables::SEGMENT as HUFFMAN_TABLES;

use lariat_message::PixelFormat;
use thiserror::Error;
use zune_jpeg::JpegDecoder;
use zune_jpeg::errors::DecodeErrors;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use head::Head;

/// The decoder reads ahead by fewer bits than this.
const READ_AHEAD_BITS: usize = 64;

/// Why an MJPG frame cannot be decoded.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum MjpegError {
    /// The frame is empty.
    #[error("the frame is empty: the camera sent nothing for it")]
    Empty,
    /// The frame ends before its image does.
    #[error(
        "the frame is cut off: a part of it was lost on the way, as on a bus with too much traffic (ask for a smaller \
         size or a lower rate, or plug the camera into a bus of its own)"
    )]
    CutOff,
    /// The frame is not a valid JPEG.
    #[error("the frame is damaged ({what}): if most are, ask the camera for another pixel format")]
    Damaged {
        /// The fault.
        what: String,
    },
    /// A JPEG of a kind that cameras do not send.
    #[error(
        "the frame is {what}, which lariat does not decode: ask the camera for another pixel format"
    )]
    Unsupported {
        /// The kind of JPEG.
        what: &'static str,
    },
    /// The frame's size differs from the negotiated size.
    #[error(
        "the frame is {}×{} pixels where {}×{} were agreed on: ask the camera for one of the sizes that it lists",
        found[0], found[1], agreed[0], agreed[1]
    )]
    Size {
        /// Width and height of the frame, in pixels.
        found: [u32; 2],
        /// The negotiated width and height.
        agreed: [u32; 2],
    },
    /// The lent memory is too short.
    #[error(
        "the frame takes {needed} bytes decoded and only {given} were lent: lend as many as `Mjpeg::largest_frame_bytes` says"
    )]
    Room {
        /// Number of bytes needed.
        needed: usize,
        /// Number of bytes lent.
        given: usize,
    },
}

/// A decoder of a camera's MJPG frames of one size.
#[derive(Debug)]
pub struct Mjpeg {
    width: u32,
    height: u32,
    /// The frame with Huffman tables added, if it came without.
    completed: Vec<u8>,
}

impl Mjpeg {
    /// Creates a decoder of frames with the size negotiated with the camera, in pixels.
    pub fn new(width: u32, height: u32) -> Self {
        // A camera's frames are a fraction of this size. Unwritten memory takes no space.
        let most = (2 * width as usize).saturating_mul(height as usize);
        Self {
            width,
            height,
            completed: Vec::with_capacity(most.min(64 << 20) + tables::SEGMENT.len()),
        }
    }

    /// Maximum number of bytes in a decoded frame.
    pub fn largest_frame_bytes(&self) -> usize {
        PixelFormat::Rgb8
            .row_bytes(self.width)
            .saturating_mul(self.height as usize)
    }

    /// Returns the format of a decoded frame from its header: `Rgb8`, or `Gray8` for a frame
    /// without color. Rows are not padded.
    ///
    /// # Errors
    /// As [`decode`](Self::decode), except for errors after the header.
    pub fn format(&self, jpeg: &[u8]) -> Result<PixelFormat, MjpegError> {
        Ok(self.head(jpeg)?.format())
    }

    /// Decodes a frame into `into`, which may be longer than the image. Returns the same as
    /// [`format`](Self::format).
    ///
    /// Bytes after the end of the image are ignored. A missing end marker alone is harmless. This
    /// function itself allocates nothing once it has seen the longest frame. The decoder allocates
    /// memory for a few rows and frees it again. At 640×480 with color at half the width, it makes
    /// 17 allocations of 72 kB in total. It cannot be given memory to reuse.
    ///
    /// # Errors
    /// The frame is empty, cut off, damaged, of a kind that cameras do not send, or not of the
    /// negotiated size; or `into` is too short. After an error, the content of `into` may be
    /// overwritten. Damage that leaves a valid code stays undetected, because a JPEG lacks a
    /// checksum. The loss of the last few bytes also stays undetected.
    pub fn decode(&mut self, jpeg: &[u8], into: &mut [u8]) -> Result<PixelFormat, MjpegError> {
        let head = self.head(jpeg)?;
        let format = head.format();
        let needed = format.row_bytes(self.width) * self.height as usize;
        let given = into.len();
        let into = into
            .get_mut(..needed)
            .ok_or(MjpegError::Room { needed, given })?;
        // Past an end marker, the decoder silently continues with zeros, but not past the end of
        // the data. The marker is therefore hidden from the decoder. However, the read-ahead must
        // not reach the end of the data before the last row of blocks. It could do so if a row is
        // short, because a block may have only two bits.
        let end = if 2 * head.blocks_a_row() > READ_AHEAD_BITS {
            head.end(jpeg)
        } else {
            jpeg.len()
        };
        let whole = if head.has_tables {
            &jpeg[..end]
        } else {
            self.completed.clear();
            self.completed.extend_from_slice(&jpeg[..2]);
            self.completed.extend_from_slice(&tables::SEGMENT);
            self.completed.extend_from_slice(&jpeg[2..end]);
            &self.completed
        };
        let color = match format {
            PixelFormat::Gray8 => ColorSpace::Luma,
            _ => ColorSpace::RGB,
        };
        let options = DecoderOptions::default()
            .set_strict_mode(true)
            .set_max_width(self.width as usize)
            .set_max_height(self.height as usize)
            .jpeg_set_out_colorspace(color);
        let mut decoder = JpegDecoder::new_with_options(ZCursor::new(whole), options);
        decoder.decode_into(into).map_err(told)?;
        Ok(format)
    }

    /// Reads the header of a frame that can be decoded.
    fn head(&self, jpeg: &[u8]) -> Result<Head, MjpegError> {
        let head = Head::read(jpeg)?;
        let agreed = [self.width, self.height];
        if head.size != agreed {
            let found = head.size;
            return Err(MjpegError::Size { found, agreed });
        }
        Ok(head)
    }
}

/// Converts the decoder's error.
fn told(error: DecodeErrors) -> MjpegError {
    match error {
        DecodeErrors::ExhaustedData
        | DecodeErrors::IoErrors(_)
        | DecodeErrors::FormatStatic("Premature end of buffer") => MjpegError::CutOff,
        other => MjpegError::Damaged {
            what: other.to_string().trim().to_owned(),
        },
    }
}
