//! A camera as a source of frames, through whatever happens to it.
//!
//! It streams, or it is down: stopped by an error, or gone. When it is down it is started again, or opened again when its
//! name comes back, after pauses that double ([`Recovery`]); it is never given up once it has shown a frame. Whoever waits
//! for frames meanwhile is given *blank* ones ([`Frame::blank`]) as soon as the camera has been silent for too long
//! ([`Silence`]): with them the stages behind say what they know, which is that their ropes are lost from sight.

mod down;
mod frames;

use std::collections::VecDeque;

use lariat_message::{PixelFormat, SourceKind, now_ns};
use rustix::event::PollFlags;
use rustix::io::Errno;

use super::driver::{Driver, Memory};
use super::error::CameraError;
use super::hotplug::Hotplug;
use super::losses::Losses;
use super::recovery::Recovery;
use super::silence::Silence;
use super::stamp::{Sequence, Stamper};
use super::stream::Stream;
use crate::color_range::ColorRange;
use crate::lent::LentSlot;
use crate::mjpeg::Mjpeg;
use crate::source::{Frame, FrameSource, Next, SourceError};
use crate::until::{Until, Woken};

/// Slots in the driver's hands: one that is filled, and three for when a frame is late to be sent and replaced.
const SLOTS: usize = 4;

/// How frames come from the driver.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Io {
    /// Straight into shared memory if the driver can, else by one copy.
    #[default]
    Auto,
    /// Straight into shared memory (`V4L2_MEMORY_USERPTR`), or not at all.
    UserPointer,
    /// By one copy from the driver's own memory (`V4L2_MEMORY_MMAP`).
    Mapped,
}

/// What the camera is set to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Shape {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) stride: u32,
    pub(super) encoding: Encoding,
    /// The range of the driver's Y, U and V.
    pub(super) range: ColorRange,
    /// What the driver needs of memory that it is lent.
    pub(super) buffer_bytes: usize,
    pub(super) interval_ns: Option<u64>,
}

impl Shape {
    /// The most bytes of a frame.
    fn frame_bytes(&self) -> usize {
        match self.encoding {
            Encoding::Plain(format) => format.image_bytes(self.stride, self.height),
            // As `Rgb8`.
            Encoding::Jpeg => PixelFormat::Rgb8.row_bytes(self.width) * self.height as usize,
        }
    }

    /// Brings a frame's pixels into full range.
    fn expand(&self, pixels: &mut [u8]) {
        if let Encoding::Plain(format) = self.encoding {
            let bytes = self.frame_bytes().min(pixels.len());
            let pixels = &mut pixels[..bytes];
            self.range.expand(format, self.stride, self.height, pixels);
        }
    }

    /// The bytes up to the last row's last pixel: with fewer a frame is cut short. Padding behind it need not be there.
    fn least_bytes(&self) -> usize {
        match self.encoding {
            Encoding::Plain(format) => {
                let padding = self.stride as usize - format.row_bytes(self.width);
                format.image_bytes(self.stride, self.height) - padding
            }
            Encoding::Jpeg => 1,
        }
    }
}

/// How the driver's bytes make a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Plain(PixelFormat),
    Jpeg,
}

/// What opens the camera, the first time and again.
pub(super) trait Port: Send {
    type Driver: Driver;

    /// Reopens the camera with its first set-up, and returns what differs from it, if anything. Fails if the set-up cannot be
    /// restored.
    fn reopen(&mut self) -> Result<(Self::Driver, Option<String>), CameraError>;

    /// The error that a refused call means.
    fn refusal(&self, call: &'static str, errno: Errno) -> CameraError;

    /// The picture has settled: what is to be done then. A sentence on it.
    fn settled(&mut self, driver: &Self::Driver) -> Option<String>;

    /// The camera is not used any more.
    fn leave(&mut self, driver: &Self::Driver);
}

/// A call of the driver's that failed, and how.
pub(super) type Failure = (&'static str, Errno);

/// Whether there is a driver, and what it does.
#[derive(Debug)]
enum State<D: Driver> {
    Streaming(Stream<D>),
    Stopped(D),
    Gone,
}

/// The camera.
pub(super) struct Camera<P: Port> {
    // Dropped before the slots: the driver lets go of them.
    state: State<P::Driver>,
    port: P,
    shape: Shape,
    /// Of frames that come compressed.
    decoder: Option<Mjpeg>,
    memory: Memory,
    /// Whether the memory may be the driver's own if it does not take ours.
    may_map: bool,
    /// Slots that were lent and that the driver does not have.
    slots: Vec<LentSlot>,
    /// A lent slot that the driver refused.
    refused: Option<Failure>,
    /// The frame just made ready, for who lends no slot.
    spare: Vec<u8>,
    hotplug: Option<Hotplug>,
    sequence: Sequence,
    stamper: Stamper,
    silence: Silence,
    recovery: Recovery,
    damaged: Losses,
    undecoded: Losses,
    has_shown: bool,
    /// When the picture has settled.
    settles_ns: Option<u64>,
    /// When the exposure time is read next.
    exposure_at_ns: u64,
    told: Told,
}

/// What there is to say.
#[derive(Debug, Default)]
struct Told {
    /// What the camera is called in it.
    name: String,
    warnings: VecDeque<String>,
    news: VecDeque<String>,
}

impl Told {
    fn warn(&mut self, what: &str) {
        self.warnings.push_back(format!("{}: {what}", self.name));
    }

    fn news(&mut self, what: &str) {
        self.news.push_back(format!("{}: {what}", self.name));
    }
}

impl<P: Port> Camera<P> {
    /// A camera that was opened and set up, and streams when it is first asked for a frame.
    pub(super) fn new(
        name: String,
        driver: P::Driver,
        port: P,
        shape: Shape,
        io: Io,
        hotplug: Option<Hotplug>,
    ) -> Self {
        let mut camera = Self {
            port,
            shape,
            decoder: (shape.encoding == Encoding::Jpeg)
                .then(|| Mjpeg::new(shape.width, shape.height)),
            memory: Memory::Mapped,
            may_map: io != Io::UserPointer,
            slots: Vec::with_capacity(2 * SLOTS),
            refused: None,
            spare: Vec::new(),
            hotplug,
            sequence: Sequence::default(),
            stamper: Stamper::default(),
            silence: Silence::new(shape.interval_ns),
            recovery: Recovery::default(),
            damaged: Losses::default(),
            undecoded: Losses::default(),
            has_shown: false,
            settles_ns: None,
            exposure_at_ns: 0,
            told: Told {
                name,
                ..Told::default()
            },
            state: State::Stopped(driver),
        };
        // What is decoded is written by us anyway.
        if io != Io::Mapped && matches!(shape.encoding, Encoding::Plain(_)) {
            camera.memory = Memory::Lent;
        }
        camera
    }

    /// Has what is known from the start said.
    pub(super) fn tell(&mut self, news: String, warnings: Vec<String>) {
        self.told.news.push_back(news);
        self.told.warnings.extend(warnings);
    }
}

impl<P: Port> FrameSource for Camera<P> {
    fn kind(&self) -> SourceKind {
        SourceKind::Camera
    }

    fn largest_frame_bytes(&self) -> usize {
        self.shape.frame_bytes().max(match self.memory {
            Memory::Lent => self.shape.buffer_bytes,
            Memory::Mapped => 0,
        })
    }

    fn native_fps(&self) -> Option<f64> {
        self.shape.interval_ns.map(|ns| 1e9 / ns as f64)
    }

    fn slots_wanted(&self) -> usize {
        match self.memory {
            Memory::Lent => SLOTS,
            Memory::Mapped => 1,
        }
    }

    fn lend(&mut self, slot: LentSlot) {
        match &mut self.state {
            State::Streaming(stream) if self.memory == Memory::Lent => {
                if let Err((slot, failure)) = stream.lend(slot) {
                    self.slots.push(slot);
                    self.refused = Some(failure);
                }
            }
            _ => self.slots.push(slot),
        }
    }

    fn advance(&mut self, until: &Until) -> Result<Next, SourceError> {
        loop {
            let next = match self.state {
                State::Streaming(_) => self.take(until),
                State::Stopped(_) | State::Gone => self.rise(until)?,
            };
            if let Some(next) = next {
                return Ok(next);
            }
        }
    }

    fn write(&mut self, pixels: &mut [u8]) {
        let bytes = pixels.len().min(self.spare.len());
        pixels[..bytes].copy_from_slice(&self.spare[..bytes]);
    }

    fn take_warning(&mut self) -> Option<String> {
        self.told.warnings.pop_front()
    }

    fn take_news(&mut self) -> Option<String> {
        self.told.news.pop_front()
    }
}

impl<P: Port> Drop for Camera<P> {
    fn drop(&mut self) {
        // Stopped first: controls are put back on a camera at rest.
        match std::mem::replace(&mut self.state, State::Gone) {
            State::Streaming(stream) => {
                if let Some(driver) = stream.stop(&mut self.slots) {
                    self.port.leave(&driver);
                }
            }
            State::Stopped(driver) => self.port.leave(&driver),
            State::Gone => {}
        }
    }
}

#[cfg(test)]
mod tests;
