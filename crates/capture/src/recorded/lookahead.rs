//! The truth of a frame stands somewhere behind it in the recording: a few messages are read ahead for it.

use std::collections::VecDeque;

use lariat_message::{Centerlines, FrameHeader, Trace};
use lariat_record::{Entry, Frame, Messages, Pixels, RecordingError};

/// Frames that are read ahead at most: a truth that is not there by then was not recorded. The recorder takes both up
/// within a wake of each other.
const FRAMES: usize = 4;
/// Truths that wait for their frame.
const TRUTHS: usize = 16;

/// A frame that was met on the way to a truth.
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

/// What was read and not yet shown.
pub(super) struct Lookahead {
    has_truth: bool,
    frames: VecDeque<Stashed>,
    /// Room for frames.
    spare: Vec<Vec<u8>>,
    /// In the order of their frames.
    truths: VecDeque<Box<Centerlines>>,
    /// The frame whose truth is asked for.
    asked: Trace,
    /// What was wrong on the way.
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

    /// Forgets all.
    pub(super) fn clear(&mut self) {
        self.truths.clear();
        while let Some(stashed) = self.frames.pop_front() {
            self.keep_room(stashed);
        }
    }

    /// What was wrong with the messages that were passed, to be said.
    pub(super) fn take_error(&mut self) -> Option<RecordingError> {
        self.error.take()
    }

    /// The first of the frames that were met, to be given back as [room](Self::keep_room).
    pub(super) fn next_frame(&mut self) -> Option<Stashed> {
        self.frames.pop_front()
    }

    pub(super) fn keep_room(&mut self, stashed: Stashed) {
        self.spare.push(stashed.bytes);
    }

    pub(super) fn truth_came(&mut self, truth: &Centerlines) {
        // The oldest make room.
        let old = (self.truths.len() >= TRUTHS).then(|| self.truths.pop_front());
        let mut room = old
            .flatten()
            .unwrap_or_else(|| Box::new(Centerlines::EMPTY));
        room.copy_meant(truth);
        self.truths.push_back(room);
    }

    /// Reads on until the truth of this frame has come, or cannot come any more.
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

    /// Whether the truth has come, or that of a later frame.
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

    /// The truth of the frame that was asked for.
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
