//! Entries of a recording.

use lariat_message::{Centerlines, Descriptors, FrameHeader};

use crate::Losses;

/// A message.
#[derive(Debug, Clone, Copy)]
pub enum Entry<'a> {
    /// A frame from capture.
    Frame(Frame<'a>),
    /// A mask made by another program.
    Mask(Frame<'a>),
    /// Centerlines from extract.
    Centerlines(&'a Centerlines),
    /// Descriptors from fit.
    Descriptors(&'a Descriptors),
    /// The true centerlines of a rendered rope.
    Truth(&'a Centerlines),
    /// Losses up to this point.
    Losses(&'a Losses),
}

/// A frame, or a mask.
#[derive(Debug, Clone, Copy)]
pub struct Frame<'a> {
    /// Trace, size and format. For raw pixels, the stride is that of `pixels`. In recordings of
    /// other programs, the sequence counts from 1 and the times are those of the image. For a
    /// [picture file](Pixels::Png) from such a recording, the size is 0, because only the file
    /// contains it.
    pub header: FrameHeader,
    /// The pixels.
    pub pixels: Pixels<'a>,
    /// Log time, in nanoseconds of Unix time.
    pub log_time_ns: u64,
    /// Size of the message with the pixels, in bytes.
    pub message_bytes: usize,
}

/// Pixels of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pixels<'a> {
    /// No pixels: a blank frame, or one whose image was not recorded.
    None,
    /// Raw bytes, as described by the header.
    Raw(&'a [u8]),
    /// A PNG file.
    Png(&'a [u8]),
    /// A JPEG file.
    Jpeg(&'a [u8]),
    /// A picture file of another kind, such as WebP, which its first bytes identify.
    Other(&'a [u8]),
}
