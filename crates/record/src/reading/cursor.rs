//! Iterates over messages in the order in which they were written.

use std::ops::Range;
use std::sync::Arc;

use lariat_message::{Centerlines, Descriptors, FrameHeader, Trace};

use super::chunk::Unpacker;
use super::entry::{Entry, Frame};
use super::error::RecordingError;
use super::index::Index;
use super::layout::{Message, Records, kind};
use super::pictures::{self, Bytes, Wrong};
use super::storage::Storage;
use super::topics::{Kind, Topics};
use crate::foxglove::{Form, Room};
use crate::{Losses, Record};

/// Maximum delay of a frame's results relative to later frames. Messages are therefore searched
/// until this long after the end of a span.
const LATE_NS: u64 = 2_000_000_000;

/// A file of a recording, shared by its cursors.
#[derive(Clone)]
pub(super) struct Source {
    pub(super) storage: Arc<dyn Storage>,
    pub(super) index: Arc<Index>,
    pub(super) topics: Arc<Topics>,
    /// Offset from a trace's time to a log time. Without it, a message's own log time counts.
    pub(super) offset_ns: Option<i64>,
}

/// A cursor over a recording's messages. Chunks are unpacked one by one into reused memory, so once
/// warm, a message needs no allocation.
pub struct Messages {
    source: Source,
    /// Files after the current one, the next one last.
    rest: Vec<Source>,
    unpacker: Unpacker,
    /// Log times of the wanted frames. Other messages are wanted if their frame is.
    span_ns: Range<u64>,
    /// Index of the next part.
    part: usize,
    /// Position of the next message among the loaded part's records.
    at: usize,
    /// The header of a frame that waits for its image, with its log time. `mask` holds the same for
    /// a mask.
    frame: Option<(FrameHeader, u64)>,
    mask: Option<(FrameHeader, u64)>,
    /// Number of frames without headers so far.
    counted: u64,
    scratch: Box<Scratch>,
}

/// Buffers into which messages are decoded.
struct Scratch {
    header: FrameHeader,
    centerlines: Centerlines,
    descriptors: Descriptors,
    losses: Losses,
    /// Pixels that had to be decoded or converted.
    room: Room,
    converted: Vec<u8>,
}

/// A message that was found. It is lent to the caller once the search is over.
enum Found {
    Frame(FoundFrame),
    Centerlines,
    Truth,
    Descriptors,
    Losses,
}

struct FoundFrame {
    header: FrameHeader,
    log_time_ns: u64,
    side: Side,
    message_bytes: usize,
    bytes: Bytes,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    Frame,
    Mask,
}

impl FoundFrame {
    fn lend<'a>(self, records: &'a [u8], scratch: &'a Scratch) -> Frame<'a> {
        Frame {
            header: self.header,
            log_time_ns: self.log_time_ns,
            message_bytes: self.message_bytes,
            pixels: self
                .bytes
                .lend(records, &scratch.room.data, &scratch.converted),
        }
    }
}

impl Messages {
    /// Creates a cursor. `source` is the first file and `rest` the files after it.
    pub(super) fn new(source: Source, rest: &[Source], span_ns: Range<u64>, counted: u64) -> Self {
        Self {
            unpacker: Unpacker::new(source.storage.clone()),
            source,
            rest: rest.iter().rev().cloned().collect(),
            span_ns,
            part: 0,
            at: 0,
            frame: None,
            mask: None,
            counted,
            scratch: Box::new(Scratch {
                header: FrameHeader::default(),
                centerlines: Centerlines::EMPTY,
                descriptors: Descriptors::EMPTY,
                losses: Losses::default(),
                room: Room::default(),
                converted: Vec::new(),
            }),
        }
    }

    /// Returns the next message; `None` after the last. After an error, the next call continues
    /// after the damaged part.
    ///
    /// # Errors
    /// Fails if a chunk or a message is damaged.
    #[allow(clippy::should_implement_trait)] // The result borrows from `self`, which `Iterator` does not allow.
    pub fn next(&mut self) -> Result<Option<Entry<'_>>, RecordingError> {
        let Some(found) = self.find()? else {
            return Ok(None);
        };
        let scratch = &self.scratch;
        Ok(Some(match found {
            Found::Centerlines => Entry::Centerlines(&scratch.centerlines),
            Found::Truth => Entry::Truth(&scratch.centerlines),
            Found::Descriptors => Entry::Descriptors(&scratch.descriptors),
            Found::Losses => Entry::Losses(&scratch.losses),
            Found::Frame(frame) => match frame.side {
                Side::Frame => Entry::Frame(frame.lend(self.unpacker.records(), scratch)),
                Side::Mask => Entry::Mask(frame.lend(self.unpacker.records(), scratch)),
            },
        }))
    }

    /// Returns the next frame and skips other messages.
    ///
    /// # Errors
    /// Fails as [`next`](Self::next) does.
    pub fn next_frame(&mut self) -> Result<Option<Frame<'_>>, RecordingError> {
        loop {
            match self.find()? {
                None => return Ok(None),
                Some(Found::Frame(frame)) if frame.side == Side::Frame => {
                    return Ok(Some(frame.lend(self.unpacker.records(), &self.scratch)));
                }
                Some(_) => {}
            }
        }
    }

    fn find(&mut self) -> Result<Option<Found>, RecordingError> {
        loop {
            if let Some((header, log_time_ns)) = self.frame.filter(|(held, _)| held.is_blank()) {
                self.frame = None;
                return Ok(without_image(header, log_time_ns, Side::Frame));
            }
            let Some((channel, log_time_ns, range)) = self.next_message()? else {
                // Returns the remaining headers, whose images never came.
                let (side, held) = match (self.frame.take(), self.mask.take()) {
                    (Some(frame), mask) => {
                        self.mask = mask;
                        (Side::Frame, frame)
                    }
                    (None, Some(mask)) => (Side::Mask, mask),
                    (None, None) => return Ok(None),
                };
                return Ok(without_image(held.0, held.1, side));
            };
            let Some(kind) = self.source.topics.kind(channel) else {
                continue;
            };
            let found = self.take(kind, log_time_ns, range);
            if let Some(found) = found.map_err(|why| self.about(channel, why))? {
                return Ok(Some(found));
            }
        }
    }

    fn about(&self, channel: u16, why: Wrong) -> RecordingError {
        let listed = self.source.index.channels.get(&channel);
        let topic = listed.map_or_else(String::new, |listed| listed.topic.clone());
        match why {
            Wrong::Cdr(why) => RecordingError::Message { topic, why },
            Wrong::Image => RecordingError::Image { topic },
            Wrong::Encoding(encoding) => RecordingError::Encoding { topic, encoding },
            Wrong::Depth => RecordingError::Depth { topic },
        }
    }

    /// Returns the channel, log time and range of the next message of any kind.
    fn next_message(&mut self) -> Result<Option<(u16, u64, Range<usize>)>, RecordingError> {
        loop {
            let records = self.unpacker.records();
            let mut walk = Records::new(&records[self.at..]);
            let next = walk.next();
            let behind = records.len() - walk.0.0.len();
            match next {
                Some((kind::MESSAGE, record)) => {
                    self.at = behind;
                    if let Some(message) = Message::read(record) {
                        let range = behind - message.bytes.len()..behind;
                        return Ok(Some((message.channel, message.log_time_ns, range)));
                    }
                }
                Some(_) => self.at = behind,
                None => {
                    if !self.load_next()? {
                        return Ok(None);
                    }
                }
            }
        }
    }

    /// Loads the next part that can contain a wanted message; `false` after the last.
    fn load_next(&mut self) -> Result<bool, RecordingError> {
        let last_ns = self.span_ns.end.saturating_add(LATE_NS);
        loop {
            while let Some(indexed) = self.source.index.parts.get(self.part) {
                self.part += 1;
                if indexed.end_ns >= self.span_ns.start && indexed.start_ns < last_ns {
                    self.at = 0;
                    self.unpacker.load(indexed.part)?;
                    return Ok(true);
                }
            }
            let Some(next) = self.rest.pop() else {
                break;
            };
            self.unpacker = Unpacker::new(next.storage.clone());
            (self.source, self.part) = (next, 0);
        }
        self.at = self.unpacker.records().len();
        Ok(false)
    }

    /// Reads a message. `None` if it is not wanted, or if it has to wait for another message.
    fn take(
        &mut self,
        kind: Kind,
        log_time_ns: u64,
        range: Range<usize>,
    ) -> Result<Option<Found>, Wrong> {
        let bytes = &self.unpacker.records()[range.clone()];
        let scratch = &mut *self.scratch;
        let found = match kind {
            Kind::FrameHeader | Kind::MaskHeader => {
                scratch.header.decode(bytes)?;
                return Ok(self.take_header(kind, log_time_ns));
            }
            Kind::Image(_) | Kind::Picture(_) | Kind::MaskImage | Kind::MaskPicture => {
                return self.take_image(kind, log_time_ns, range);
            }
            Kind::Centerlines => {
                scratch.centerlines.decode(bytes)?;
                (Found::Centerlines, Some(scratch.centerlines.trace))
            }
            Kind::Truth => {
                scratch.centerlines.decode(bytes)?;
                (Found::Truth, Some(scratch.centerlines.trace))
            }
            Kind::Descriptors => {
                scratch.descriptors.decode(bytes)?;
                (Found::Descriptors, Some(scratch.descriptors.trace))
            }
            Kind::Losses => {
                scratch.losses.decode(bytes)?;
                (Found::Losses, None)
            }
        };
        let (found, trace) = found;
        Ok(Some(found).filter(|_| self.is_wanted(trace.as_ref(), log_time_ns)))
    }

    /// Returns whether a message's frame is within the span.
    fn is_wanted(&self, trace: Option<&Trace>, log_time_ns: u64) -> bool {
        let of_frame = trace.zip(self.source.offset_ns);
        let at_ns = of_frame.map(|(trace, offset)| trace.captured_ns.wrapping_add_signed(offset));
        self.span_ns.contains(&at_ns.unwrap_or(log_time_ns))
    }

    /// Keeps a header until its image comes. A header that was already kept has no image.
    fn take_header(&mut self, kind: Kind, log_time_ns: u64) -> Option<Found> {
        let header = self.scratch.header;
        let (held, side) = match kind {
            Kind::MaskHeader => (&mut self.mask, Side::Mask),
            _ => (&mut self.frame, Side::Frame),
        };
        if !self.span_ns.contains(&log_time_ns) {
            return None;
        }
        let (before, before_ns) = held.replace((header, log_time_ns))?;
        without_image(before, before_ns, side)
    }

    fn take_image(
        &mut self,
        kind: Kind,
        log_time_ns: u64,
        range: Range<usize>,
    ) -> Result<Option<Found>, Wrong> {
        let (side, held) = match kind {
            Kind::MaskImage | Kind::MaskPicture => (Side::Mask, &mut self.mask),
            _ => (Side::Frame, &mut self.frame),
        };
        let held = held.take_if(|(_, header_ns)| *header_ns == log_time_ns);
        let has_header = self.source.topics.has_headers || side == Side::Mask;
        if held.is_none() && (has_header || !self.span_ns.contains(&log_time_ns)) {
            return Ok(None);
        }
        let records = self.unpacker.records();
        let message_bytes = range.len();
        let message = &records[range];
        let known = held.map(|(header, _)| header);
        let Scratch {
            room, converted, ..
        } = &mut *self.scratch;
        let form = match kind {
            Kind::Image(form) | Kind::Picture(form) => form,
            _ => Form::Ros2,
        };
        let (header, bytes) = match kind {
            Kind::Image(_) | Kind::MaskImage => {
                pictures::raw(form.image(message, room)?, known, records, converted)?
            }
            _ => pictures::picture(form.picture(message, room)?, known, records)?,
        };
        let mut header = header;
        if known.is_none() {
            self.counted += 1;
            header.trace.sequence = self.counted;
            header.trace.captured = self.counted;
        }
        Ok(Some(Found::Frame(FoundFrame {
            header,
            log_time_ns,
            side,
            message_bytes,
            bytes,
        })))
    }
}

fn without_image(header: FrameHeader, log_time_ns: u64, side: Side) -> Option<Found> {
    Some(Found::Frame(FoundFrame {
        header,
        log_time_ns,
        side,
        message_bytes: 0,
        bytes: Bytes::None,
    }))
}
