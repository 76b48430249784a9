//! A camera as a source of frames that recovers from errors.
//!
//! The camera either streams or is down: stopped by an error, or gone. When it is down, it is
//! started again, or opened again once its name is back, after pauses that double ([`Recovery`]). A
//! camera that has shown a frame is retried indefinitely. If it has been silent for too long
//! ([`Silence`]), the source yields *blank* frames ([`Frame::blank`]). They tell later stages that
//! their ropes are out of sight.

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

/// Number of slots that the driver holds: one being filled, and three in case a frame is sent and
/// replaced late.
const SLOTS: usize = 4;

/// How frames are transferred from the driver.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Io {
    /// Straight into shared memory if the driver supports it, otherwise with one copy.
    #[default]
    Auto,
    /// Straight into shared memory (`V4L2_MEMORY_USERPTR`), or fail.
    UserPointer,
    /// With one copy from the driver's own memory (`V4L2_MEMORY_MMAP`).
    Mapped,
}

/// Negotiated format of a camera's frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Shape {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) stride: u32,
    pub(super) encoding: Encoding,
    /// Range of the driver's Y, U and V.
    pub(super) range: ColorRange,
    /// Minimum size of a buffer that is lent to the driver, in bytes.
    pub(super) buffer_bytes: usize,
    pub(super) interval_ns: Option<u64>,
}

impl Shape {
    /// Maximum number of bytes in a frame.
    fn frame_bytes(&self) -> usize {
        match self.encoding {
            Encoding::Plain(format) => format.image_bytes(self.stride, self.height),
            // Decoded to `Rgb8`.
            Encoding::Jpeg => PixelFormat::Rgb8.row_bytes(self.width) * self.height as usize,
        }
    }

    /// Expands a frame's pixels to full range.
    fn expand(&self, pixels: &mut [u8]) {
        if let Encoding::Plain(format) = self.encoding {
            let bytes = self.frame_bytes().min(pixels.len());
            let pixels = &mut pixels[..bytes];
            self.range.expand(format, self.stride, self.height, pixels);
        }
    }

    /// Number of bytes up to the last row's last pixel. A frame with fewer bytes is cut short; the
    /// padding after that pixel may be missing.
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

/// Encoding of a frame in the driver's buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Plain(PixelFormat),
    Jpeg,
}

/// Opens the camera, and reopens it after a failure.
pub(super) trait Port: Send {
    type Driver: Driver;

    /// Reopens the camera with its first setup. Returns a sentence about any difference. Fails if
    /// the setup cannot be restored.
    fn reopen(&mut self) -> Result<(Self::Driver, Option<String>), CameraError>;

    /// The error for a refused call.
    fn refusal(&self, call: &'static str, errno: Errno) -> CameraError;

    /// Called once the picture has settled. Returns a sentence about what it did.
    fn settled(&mut self, driver: &Self::Driver) -> Option<String>;

    /// Called when the camera is no longer used.
    fn leave(&mut self, driver: &Self::Driver);
}

/// A failed call to the driver, and its error.
pub(super) type Failure = (&'static str, Errno);

/// State of the driver.
#[derive(Debug)]
enum State<D: Driver> {
    Streaming(Stream<D>),
    Stopped(D),
    Gone,
}

/// A camera that streams or recovers.
pub(super) struct Camera<P: Port> {
    // Dropped before the slots, so that the driver releases them.
    state: State<P::Driver>,
    port: P,
    shape: Shape,
    /// Decoder of compressed frames.
    decoder: Option<Mjpeg>,
    memory: Memory,
    /// True if the driver may use its own memory when it does not accept ours.
    may_map: bool,
    /// Lent slots that the driver does not hold.
    slots: Vec<LentSlot>,
    /// A lent slot that the driver refused.
    refused: Option<Failure>,
    /// The frame just made ready, for a caller that lends no slots.
    spare: Vec<u8>,
    hotplug: Option<Hotplug>,
    sequence: Sequence,
    stamper: Stamper,
    silence: Silence,
    recovery: Recovery,
    damaged: Losses,
    undecoded: Losses,
    has_shown: bool,
    /// When the picture will have settled.
    settles_ns: Option<u64>,
    /// When to read the exposure time next.
    exposure_at_ns: u64,
    told: Told,
}

/// Queued messages.
#[derive(Debug, Default)]
struct Told {
    /// The camera's name in messages.
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
    /// Creates a source from a camera that is open and set up. It starts to stream when the first
    /// frame is requested.
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
        // Decoded frames are copied in any case.
        if io != Io::Mapped && matches!(shape.encoding, Encoding::Plain(_)) {
            camera.memory = Memory::Lent;
        }
        camera
    }

    /// Queues messages that are known from the start.
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
        // Stop it first, so that controls are restored while it does not stream.
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
