//! Reads a few messages ahead, because a frame's truth comes after the frame in a recording.

use std::collections::VecDeque;

use lariat_message::{Centerlines, FrameHeader, Trace};
use lariat_record::{Entry, Frame, Messages, Pixels, RecordingError};

/// Maximum number of frames read ahead. If a truth has not come by then, the recording lacks it:
/// the recorder collects a frame and its truth at most one wakeup apart.
const FRAMES: usize = 4;
/// Maximum number of truths that wait for their frame.
const TRUTHS: usize = 16;

/// A frame read while looking for a truth.
pub(super) struct Stashed {
    pub(super) header: FrameHeader,
    pub(super) log_time_ns: u64,
    bytes: Vec<u8>,
    kind: Kind,
}

#[derive(Clone, Copy)]
enum Kind {
    None,
    Raw,
    Png,
    Jpeg,
    Other,
}

impl Stashed {
    pub(super) fn pixels(&self) -> Pixels<'_> {
        match self.kind {
            Kind::None => Pixels::None,
            Kind::Raw => Pixels::Raw(&self.bytes),
            Kind::Png => Pixels::Png(&self.bytes),
            Kind::Jpeg => Pixels::Jpeg(&self.bytes),
            Kind::Other => Pixels::Other(&self.bytes),
        }
    }
}

/// Messages that were read but not yet shown.
pub(super) struct Lookahead {
    has_truth: bool,
    frames: VecDeque<Stashed>,
    /// Spare buffers for frames.
    spare: Vec<Vec<u8>>,
    /// Truths, in the order of their frames.
    truths: VecDeque<Box<Centerlines>>,
    /// The frame whose truth is requested.
    asked: Trace,
    /// Error of the last read ahead.
    error: Option<RecordingError>,
}

impl Lookahead {
    pub(super) fn new(has_truth: bool) -> Self {
        Self {
            has_truth,
            frames: VecDeque::new(),
            spare: Vec::new(),
            truths: VecDeque::new(),
            asked: Trace::EMPTY,
            error: None,
        }
    }

    /// Discards all frames and truths.
    pub(super) fn clear(&mut self) {
        self.truths.clear();
        while let Some(stashed) = self.frames.pop_front() {
            self.keep_room(stashed);
        }
    }

    /// Returns the error that ended the last read ahead, so that it can be reported.
    pub(super) fn take_error(&mut self) -> Option<RecordingError> {
        self.error.take()
    }

    /// The first frame read ahead. Give its buffer back through [`keep_room`](Self::keep_room).
    pub(super) fn next_frame(&mut self) -> Option<Stashed> {
        self.frames.pop_front()
    }

    pub(super) fn keep_room(&mut self, stashed: Stashed) {
        self.spare.push(stashed.bytes);
    }

    pub(super) fn truth_came(&mut self, truth: &Centerlines) {
        // Reuse the oldest one's memory.
        let old = (self.truths.len() >= TRUTHS).then(|| self.truths.pop_front());
        let mut room = old
            .flatten()
            .unwrap_or_else(|| Box::new(Centerlines::EMPTY));
        room.copy_meant(truth);
        self.truths.push_back(room);
    }

    /// Reads ahead until the truth of this frame has come, or can no longer come.
    pub(super) fn look_for_truth(&mut self, frame: &FrameHeader, messages: &mut Messages) {
        self.asked = frame.trace;
        while self.has_truth && !self.is_settled() && self.frames.len() < FRAMES {
            match messages.next() {
                Ok(Some(Entry::Truth(truth))) => self.truth_came(truth),
                Ok(Some(Entry::Frame(frame))) => self.stash(&frame),
                Ok(Some(_)) => {}
                Err(error) => {
                    self.error = Some(error);
                    break;
                }
                Ok(None) => break,
            }
        }
    }

    /// Returns whether the truth of this frame, or of a later one, has come.
    fn is_settled(&self) -> bool {
        let captured = self.asked.captured;
        let newest = self.truths.back();
        newest.is_some_and(|truth| truth.trace.captured >= captured)
    }

    fn stash(&mut self, frame: &Frame) {
        let (kind, found) = match frame.pixels {
            Pixels::None => (Kind::None, &[][..]),
            Pixels::Raw(bytes) => (Kind::Raw, bytes),
            Pixels::Png(bytes) => (Kind::Png, bytes),
            Pixels::Jpeg(bytes) => (Kind::Jpeg, bytes),
            Pixels::Other(bytes) => (Kind::Other, bytes),
        };
        let mut bytes = self.spare.pop().unwrap_or_default();
        bytes.clear();
        bytes.extend_from_slice(found);
        self.frames.push_back(Stashed {
            header: frame.header,
            log_time_ns: frame.log_time_ns,
            bytes,
            kind,
        });
    }

    /// Copies the truth of the requested frame.
    pub(super) fn truth(&mut self, into: &mut Centerlines) -> bool {
        let asked = self.asked;
        let is_it = |truth: &Centerlines| {
            (truth.trace.sequence, truth.trace.captured) == (asked.sequence, asked.captured)
        };
        let Some(truth) = self.truths.iter().find(|truth| is_it(truth)) else {
            return false;
        };
        into.copy_meant(truth);
        true
    }
}
