//! Gathers the messages of all channels about one frame of a recording.
//!
//! Each channel is recorded in its own order, and a frame's messages may be several frames apart. A
//! frame is complete when every channel of the recording has a message about it or about a later
//! frame.

use super::pixels::Pixels;
use anyhow::Result;
use lariat_record::{Entry, Frame, Messages, Recording, Span};
use lariat_wire::{Centerlines, Descriptors, FrameHeader, Trace};
use std::collections::VecDeque;

/// Maximum number of bytes kept for incomplete frames.
const MOST_BYTES: usize = 1 << 30;
/// Maximum number of incomplete frames: many times more than a chain ever has in progress.
const MOST_FRAMES: usize = 1024;

/// Order in which frames were captured: by time, or by number for sources without time.
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

/// Header and bytes of a frame or a mask.
#[derive(Debug, Clone)]
pub struct Copied {
    /// Header of the frame.
    pub header: FrameHeader,
    /// Encoding of the bytes.
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

/// Everything that was recorded about one frame. Channels that `has` does not mark contain stale
/// data.
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

    /// Returns the frame itself.
    pub fn frame(&self) -> Option<&Copied> {
        self.told(Channel::Frames, &self.frame)
    }

    /// Returns its mask, if an external process made it.
    pub fn mask(&self) -> Option<&Copied> {
        self.told(Channel::Masks, &self.mask)
    }

    /// Returns its centerlines, from extract.
    pub fn centerlines(&self) -> Option<&Centerlines> {
        self.told(Channel::Centerlines, &*self.centerlines)
    }

    /// Returns its descriptors, from fit.
    pub fn descriptors(&self) -> Option<&Descriptors> {
        self.told(Channel::Descriptors, &*self.descriptors)
    }

    /// Returns its true centerlines.
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
    /// Incomplete frames, by ascending key.
    waiting: VecDeque<Gathered>,
    /// The last frame in each channel; `None` if the recording does not have the channel.
    last: [Option<Key>; CHANNELS],
    /// The frame that was returned last.
    given: Gathered,
    spare: Vec<Gathered>,
    ended: bool,
}

impl Gather {
    /// Starts at the beginning of a part of the recording.
    ///
    /// # Errors
    /// Returns an error if the recording cannot be read, or if it does not have that part.
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

    /// Returns the next frame, or `None` after the last. After an error, the next call continues
    /// behind the damage.
    ///
    /// # Errors
    /// Returns an error if the recording is damaged.
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

    /// Returns true if the first waiting frame is complete, or if there are no more frames.
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
        // The frame was already returned.
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
