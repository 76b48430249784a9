//! What comes out of a recording.

use lariat_message::{Centerlines, Descriptors, FrameHeader};

use crate::Losses;

/// A message.
#[derive(Debug, Clone, Copy)]
pub enum Entry<'a> {
    /// What capture sent.
    Frame(Frame<'a>),
    /// A mask that was made elsewhere.
    Mask(Frame<'a>),
    /// What extract sent.
    Centerlines(&'a Centerlines),
    /// What fit sent.
    Descriptors(&'a Descriptors),
    /// The true centerlines of a rendered rope.
    Truth(&'a Centerlines),
    /// What was lost up to here.
    Losses(&'a Losses),
}

/// A frame, or a mask.
#[derive(Debug, Clone, Copy)]
pub struct Frame<'a> {
    /// Its trace, size and format; of pixels that are there as they are, with the length of their rows as they lie
    /// here. In recordings that lariat did not make, the sequence counts from 1, the times are those of the image, and
    /// of a [picture file](Pixels::Png) the size is 0: the file says it.
    pub header: FrameHeader,
    /// What is seen.
    pub pixels: Pixels<'a>,
    /// When it was logged, in nanoseconds of Unix time.
    pub log_time_ns: u64,
    /// Bytes of the message that held the pixels.
    pub message_bytes: usize,
}

/// What is seen in a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pixels<'a> {
    /// Nothing: a blank frame, or one whose image was not recorded.
    None,
    /// The bytes, as the header describes them.
    Raw(&'a [u8]),
    /// A PNG file.
    Png(&'a [u8]),
    /// A JPEG file.
    Jpeg(&'a [u8]),
    /// A picture file of another kind, such as WebP: its first bytes say which.
    Other(&'a [u8]),
}
