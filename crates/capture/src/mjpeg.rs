//! A camera's MJPG frames: each a JPEG of its own, decoded straight into lent memory.
//!
//! zune-jpeg decodes. What stands here is what a camera does and a picture file does not: Huffman tables left out
//! ([`tables`]), bytes behind the end of the image, frames cut off by packets that were lost on the way, a size that
//! is not the one agreed on.
//!
//! Frames with colour come out as `Rgb8`: the decoder's step from Y, U, V to red, green, blue runs in wide registers
//! while a row is at hand, and takes no longer than its step to interleaved Y, U, V, which would have to be packed into
//! `Yuyv` by one more pass over memory. Extraction takes as long for the one as for the other. It also leaves no doubt
//! about the range: a JPEG's Y, U, V are BT.601 in full range (JFIF 1.02), a camera's `YUYV` mostly in video range.

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

/// The decoder holds fewer bits than these that it has read and not used.
const READ_AHEAD_BITS: usize = 64;

/// Why an MJPG frame is no image.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum MjpegError {
    /// It has no bytes.
    #[error("the frame is empty: the camera sent nothing for it")]
    Empty,
    /// It ends before its image does.
    #[error(
        "the frame is cut off: a part of it was lost on the way, as on a bus with too much traffic (ask for a smaller \
         size or a lower rate, or plug the camera into a bus of its own)"
    )]
    CutOff,
    /// Its bytes do not make a JPEG.
    #[error("the frame is damaged ({what}): if most are, ask the camera for another pixel format")]
    Damaged {
        /// What is wrong.
        what: String,
    },
    /// A JPEG of a kind that cameras do not send.
    #[error(
        "the frame is {what}, which lariat does not decode: ask the camera for another pixel format"
    )]
    Unsupported {
        /// Of what kind it is.
        what: &'static str,
    },
    /// It has another size than was agreed on.
    #[error(
        "the frame is {}×{} pixels where {}×{} were agreed on: ask the camera for one of the sizes that it lists",
        found[0], found[1], agreed[0], agreed[1]
    )]
    Size {
        /// Width and height of the frame, in pixels.
        found: [u32; 2],
        /// Width and height that were agreed on.
        agreed: [u32; 2],
    },
    /// The memory lent is too short.
    #[error(
        "the frame takes {needed} bytes decoded and only {given} were lent: lend as many as `Mjpeg::largest_frame_bytes` says"
    )]
    Room {
        /// Bytes that it takes.
        needed: usize,
        /// Bytes that were lent.
        given: usize,
    },
}

/// A decoder of a camera's MJPG frames of one size.
#[derive(Debug)]
pub struct Mjpeg {
    width: u32,
    height: u32,
    /// The frame with Huffman tables, if it came without.
    completed: Vec<u8>,
}

impl Mjpeg {
    /// A decoder of frames of the size that was agreed on with the camera, in pixels.
    pub fn new(width: u32, height: u32) -> Self {
        // A camera's frames are a fraction of this. Memory that is not written to takes no room.
        let most = (2 * width as usize).saturating_mul(height as usize);
        Self {
            width,
            height,
            completed: Vec::with_capacity(most.min(64 << 20) + tables::SEGMENT.len()),
        }
    }

    /// The most bytes that a decoded frame takes.
    pub fn largest_frame_bytes(&self) -> usize {
        PixelFormat::Rgb8
            .row_bytes(self.width)
            .saturating_mul(self.height as usize)
    }

    /// What [`decode`](Self::decode) makes of a frame, by its head: `Rgb8`, or `Gray8` if it is without colour, its rows one
    /// after the other without padding.
    ///
    /// # Errors
    /// As `decode`, but for what is wrong behind the head.
    pub fn format(&self, jpeg: &[u8]) -> Result<PixelFormat, MjpegError> {
        Ok(self.head(jpeg)?.format())
    }

    /// Decodes a frame into `into`, which may be longer than the image; returns what [`format`](Self::format) says of it.
    ///
    /// Bytes behind the end of the image are passed over; a missing end marker alone is no harm. Once the longest frame has
    /// come nothing is allocated here. The decoder itself takes memory for a few rows and gives it back, 17 pieces of 72 kB
    /// in all at 640×480 with colour at half the width: it cannot be given memory to keep.
    ///
    /// # Errors
    /// When the frame is empty, cut off, damaged, of a kind that cameras do not send, or of another size than was agreed on;
    /// when `into` is too short. What was in `into` may be overwritten then. Damage that leaves a valid code is not seen, as a
    /// JPEG has no check sum; nor is a loss of the last few bytes.
    pub fn decode(&mut self, jpeg: &[u8], into: &mut [u8]) -> Result<PixelFormat, MjpegError> {
        let head = self.head(jpeg)?;
        let format = head.format();
        let needed = format.row_bytes(self.width) * self.height as usize;
        let given = into.len();
        let into = into
            .get_mut(..needed)
            .ok_or(MjpegError::Room { needed, given })?;
        // Behind an end marker the decoder goes on in zeros without a word; where the bytes end, it does not: so it is not
        // shown the marker. But then it must not have read all of them before it comes to the last row of blocks, as it may
        // if that is short: a block is two bits at least.
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

    /// The head of a frame that can be decoded.
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

/// What the decoder says, as ours.
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
