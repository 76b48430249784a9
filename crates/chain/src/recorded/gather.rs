//! A recording frame by frame: what the channels said of one frame, brought together.
//!
//! Each channel is recorded in its own order, but a frame's messages come some frames apart. A frame is complete when every
//! channel that the recording has either told of it or has gone on to a later one.

use super::pixels::Pixels;
use anyhow::Result;
use lariat_record::{Entry, Frame, Messages, Recording, Span};
use lariat_wire::{Centerlines, Descriptors, FrameHeader, Trace};
use std::collections::VecDeque;

/// So many bytes of frames that are not complete are kept at most.
const MOST_BYTES: usize = 1 << 30;
/// And so many frames: more than the chain has under way, many times over.
const MOST_FRAMES: usize = 1024;

/// Frames in the order in which they were captured: by time, and, for sources that have none, by number.
type Key = (u64, u64);

fn key(trace: &Trace) -> Key {
    (trace.captured_ns, trace.captured)
}

/// The channels of a recording.
#[derive(Debug, Clone, Copy)]
enum Channel {
    Frames,
    Masks,
    Centerlines,
    Descriptors,
    Truth,
}

const CHANNELS: usize = 5;

/// A frame's, or a mask's, header and bytes.
#[derive(Debug, Clone)]
pub struct Copied {
    /// What stood beside its bytes.
    pub header: FrameHeader,
    /// How the bytes make its pixels.
    pub pixels: Pixels,
    /// The bytes as they were recorded.
    pub bytes: Vec<u8>,
}

impl Default for Copied {
    fn default() -> Self {
        Self {
            header: FrameHeader::default(),
            pixels: Pixels::None,
            bytes: Vec::new(),
        }
    }
}

/// What was recorded of one frame. What of it `has` does not tell of is stale.
#[derive(Debug)]
pub struct Gathered {
    key: Key,
    has: [bool; CHANNELS],
    frame: Copied,
    mask: Copied,
    centerlines: Box<Centerlines>,
    descriptors: Box<Descriptors>,
    truth: Box<Centerlines>,
}

impl Gathered {
    fn new() -> Self {
        Self {
            key: (0, 0),
            has: [false; CHANNELS],
            frame: Copied::default(),
            mask: Copied::default(),
            centerlines: Box::new(Centerlines::EMPTY),
            descriptors: Box::new(Descriptors::EMPTY),
            truth: Box::new(Centerlines::EMPTY),
        }
    }

    fn told<T>(&self, channel: Channel, value: T) -> Option<T> {
        self.has[channel as usize].then_some(value)
    }

    /// The frame itself.
    pub fn frame(&self) -> Option<&Copied> {
        self.told(Channel::Frames, &self.frame)
    }

    /// Its mask, if it was made elsewhere.
    pub fn mask(&self) -> Option<&Copied> {
        self.told(Channel::Masks, &self.mask)
    }

    /// What extract said of it.
    pub fn centerlines(&self) -> Option<&Centerlines> {
        self.told(Channel::Centerlines, &*self.centerlines)
    }

    /// What fit said of it.
    pub fn descriptors(&self) -> Option<&Descriptors> {
        self.told(Channel::Descriptors, &*self.descriptors)
    }

    /// The true centerlines in it.
    pub fn truth(&self) -> Option<&Centerlines> {
        self.told(Channel::Truth, &*self.truth)
    }

    fn bytes(&self) -> usize {
        self.frame.bytes.len() + self.mask.bytes.len()
    }
}

/// A cursor over the frames of a recording.
pub struct Gather {
    messages: Messages,
    /// By key, ascending.
    waiting: VecDeque<Gathered>,
    /// Of each channel the last frame it told of; `None` if the recording does not have it.
    last: [Option<Key>; CHANNELS],
    /// What was given out last.
    given: Gathered,
    spare: Vec<Gathered>,
    ended: bool,
}

impl Gather {
    /// # Errors
    /// The recording cannot be read, or there is no such part of it.
    pub fn new(recording: &Recording, span: Span) -> Result<Self> {
        let mut last = [None; CHANNELS];
        let topics = recording.topics()?;
        let ours = recording.has_traces();
        for topic in topics.iter().filter(|topic| ours && topic.messages > 0) {
            let channel = match topic.name.rsplit('/').next() {
                Some("frames") => Channel::Frames,
                Some("masks") => Channel::Masks,
                Some("centerlines") => Channel::Centerlines,
                Some("descriptors") => Channel::Descriptors,
                Some("truth") => Channel::Truth,
                _ => continue,
            };
            last[channel as usize] = Some((0, 0));
        }
        if !ours {
            last[Channel::Frames as usize] = Some((0, 0));
        }
        Ok(Self {
            messages: recording.messages(span)?,
            waiting: VecDeque::new(),
            last,
            given: Gathered::new(),
            spare: Vec::new(),
            ended: false,
        })
    }

    /// The next frame; `None` after the last. After an error the next call goes on behind it.
    ///
    /// # Errors
    /// The recording is damaged.
    #[allow(
        clippy::should_implement_trait,
        reason = "an iterator could not lend what it gives"
    )]
    pub fn next(&mut self) -> Result<Option<&Gathered>> {
        while !self.is_ready() {
            self.read()?;
        }
        let Some(next) = self.waiting.pop_front() else {
            return Ok(None);
        };
        let before = std::mem::replace(&mut self.given, next);
        self.spare.push(before);
        Ok(Some(&self.given))
    }

    /// Whether the first of those that wait is complete, or none will come.
    fn is_ready(&self) -> bool {
        let Some(first) = self.waiting.front() else {
            return self.ended;
        };
        let is_told = |channel: usize| {
            first.has[channel] || self.last[channel].is_none_or(|last| last > first.key)
        };
        let bytes: usize = self.waiting.iter().map(Gathered::bytes).sum();
        self.ended
            || (0..CHANNELS).all(is_told)
            || self.waiting.len() > MOST_FRAMES
            || bytes > MOST_BYTES
    }

    fn read(&mut self) -> Result<()> {
        let Self {
            messages,
            waiting,
            last,
            spare,
            given,
            ..
        } = self;
        let Some(entry) = messages.next()? else {
            self.ended = true;
            return Ok(());
        };
        let (channel, trace) = match &entry {
            Entry::Frame(frame) => (Channel::Frames, &frame.header.trace),
            Entry::Mask(mask) => (Channel::Masks, &mask.header.trace),
            Entry::Centerlines(message) => (Channel::Centerlines, &message.trace),
            Entry::Descriptors(message) => (Channel::Descriptors, &message.trace),
            Entry::Truth(message) => (Channel::Truth, &message.trace),
            Entry::Losses(_) => return Ok(()),
        };
        let key = key(trace);
        last[channel as usize] = last[channel as usize].max(Some(key));
        // Too late for a frame that was given out already.
        if key <= given.key {
            return Ok(());
        }
        let place = waiting.partition_point(|gathered| gathered.key < key);
        if waiting
            .get(place)
            .is_none_or(|gathered| gathered.key != key)
        {
            let mut new = spare.pop().unwrap_or_else(Gathered::new);
            new.key = key;
            new.has = [false; CHANNELS];
            waiting.insert(place, new);
        }
        let gathered = &mut waiting[place];
        gathered.has[channel as usize] = true;
        match entry {
            Entry::Frame(frame) => copy(&frame, &mut gathered.frame),
            Entry::Mask(mask) => copy(&mask, &mut gathered.mask),
            Entry::Centerlines(message) => gathered.centerlines.copy_meant(message),
            Entry::Descriptors(message) => gathered.descriptors.copy_meant(message),
            Entry::Truth(message) => gathered.truth.copy_meant(message),
            Entry::Losses(_) => {}
        }
        Ok(())
    }
}

fn copy(frame: &Frame, to: &mut Copied) {
    let (pixels, bytes) = Pixels::split(frame.pixels);
    to.header = frame.header;
    to.pixels = pixels;
    to.bytes.clear();
    to.bytes.extend_from_slice(bytes);
}
