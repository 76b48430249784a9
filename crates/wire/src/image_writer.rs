#![allow(unsafe_code)] // Writers move between threads despite their non-atomic counters.
//! Writers for the images of a user's own camera or mask network. They put images into a rig's
//! shared memory, with a header and stamps, so that the chain can count and time them.
//!
//! A writer of images accepts the channel as it is, lossless or not. Its slots fit the largest
//! image to date, and are replaced when a larger image comes. Arrays in Python are views of a slot
//! and are counted. While a view exists, the writer's memory stays mapped: closing waits for the
//! last view, and larger slots are refused, as with `mmap`. Frames in Python are copies, like
//! messages.

mod beside;

pub use beside::{DepthWriter, MaskWriter};

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use crate::channel::{Channel, FRAMES};
use crate::error::MAX_SIDE;
use crate::patience::Meanwhile;
use crate::writer::KeptSlot;
use crate::{
    Delivery, Domain, FrameHeader, PixelFormat, Rig, SourceKind, Trace, WireError, WriteError,
    Writer, now_ns,
};

/// Behavior of an image writer towards slow readers.
#[derive(Clone, Default)]
pub struct Waiting {
    /// True if each image must reach every reader, so that the writer waits. `None` follows the
    /// running chain; without one, the newest image wins.
    pub lossless: Option<bool>,
    /// Ends a lossless writer's wait within a few seconds when set.
    pub stop: Arc<AtomicBool>,
    /// Called about every 50 ms during such a wait. It may set `stop`.
    pub meanwhile: Option<Arc<dyn Fn() + Send + Sync>>,
}

impl fmt::Debug for Waiting {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_struct("Waiting")
            .field("lossless", &self.lossless)
            .field("stop", &self.stop)
            .finish_non_exhaustive()
    }
}

/// Exposure time and number of an image; missing values are filled in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Stamp {
    /// Exposure time on the clock of [`now_ns`]. `None` means the time at which the slot was
    /// borrowed. This is correct for an image taken afterwards, and too recent for an image taken
    /// earlier.
    pub exposed_ns: Option<u64>,
    /// The camera's own number for the image, from 1. A gap counts as frames lost at the source.
    /// `None` means one more than the last.
    pub sequence: Option<u64>,
}

/// Writing end of an image channel, whose slots grow with the largest image.
struct Images {
    // Fields drop in order: the slot before its writer, the writer before its domain.
    on_loan: Option<KeptSlot>,
    /// The writer and the size of its largest image in bytes. `None` after a failure to make larger
    /// slots.
    writer: Option<(usize, Writer<[u8]>)>,
    domain: Domain,
    rig: Rig,
    channel: &'static Channel<[u8]>,
    delivery: Delivery,
    meanwhile: Option<Meanwhile>,
}

// SAFETY: as for `Reader`, only reference counts without atomics are not `Send`: those in the
// transport's publisher, which a slot on loan shares, its notifier and its listener. All are fields
// of this one struct and only borrowed from it, so everything that shares a count moves to another
// thread together.
unsafe impl Send for Images {}

impl Images {
    fn open(
        domain: Domain,
        rig: &Rig,
        channel: &'static Channel<[u8]>,
        waiting: Waiting,
    ) -> Result<Self, WireError> {
        let delivery = channel.delivery(&domain, rig, waiting.lossless, &waiting.stop)?;
        let mut images = Self {
            on_loan: None,
            writer: None,
            domain,
            rig: rig.clone(),
            channel,
            delivery,
            meanwhile: waiting.meanwhile,
        };
        // Open the channel with a tiny slot, so that it has its writer from now on and refuses a
        // second one.
        images.make_room(1)?;
        Ok(images)
    }

    fn make_room(&mut self, bytes: usize) -> Result<&Writer<[u8]>, WireError> {
        self.on_loan = None;
        // First drop a writer that is too small, because the channel allows only one writer.
        let large_enough = self.writer.take().filter(|(largest, _)| *largest >= bytes);
        let writer = match large_enough {
            Some(writer) => writer,
            None => {
                let writer = Writer::images(
                    &self.domain,
                    &self.rig,
                    self.channel,
                    &self.delivery,
                    bytes,
                    1,
                    self.meanwhile.clone(),
                )?;
                (bytes, writer)
            }
        };
        Ok(&self.writer.insert(writer).1)
    }

    /// Borrows a slot. A slot already on loan is returned unsent.
    fn loan(&mut self, bytes: usize) -> Result<&mut [u8], WireError> {
        let slot = self.make_room(bytes)?.frame_slot(bytes)?.keep();
        Ok(self.on_loan.insert(slot).bytes_mut())
    }

    fn send(&mut self, header: FrameHeader) -> Result<bool, WriteError> {
        match (self.on_loan.take(), &self.writer) {
            (Some(slot), Some((_, writer))) => {
                let mut slot = slot.back_to(writer);
                *slot.header_mut() = header;
                Ok(slot.send()?)
            }
            _ => Err(WriteError::NothingOnLoan),
        }
    }

    fn has_room(&self, bytes: usize) -> bool {
        (self.writer.as_ref()).is_some_and(|&(largest, _)| largest >= bytes)
    }

    fn is_lossless(&self) -> bool {
        matches!(self.delivery, Delivery::Lossless { .. })
    }
}

/// Writes the frames of a rig whose chain was started with `lariat run --source external`, from any
/// camera, simulator or player.
///
/// ```no_run
/// use lariat_wire::{FrameWriter, PixelFormat, Stamp};
///
/// let mut frames = FrameWriter::open("default")?;
/// loop {
///     let pixels = frames.loan(640, 480, PixelFormat::Rgb8)?; // in shared memory, rows without gaps
///     let exposed_ns = read_camera(pixels);
///     frames.send(Stamp { exposed_ns, ..Stamp::default() })?;
/// }
/// # fn read_camera(_: &mut [u8]) -> Option<u64> { None }
/// # #[allow(unreachable_code)]
/// # Ok::<(), lariat_wire::WriteError>(())
/// ```
///
/// It may be opened before the chain runs, and outlives it. Frames are counted like a camera's: the
/// stamps tell the chain how many frames were lost, and where. If its process ends or is killed,
/// the channel is free for another writer. Until another writer starts, readers report ropes of
/// growing age ([`Seen::Stale`](crate::Seen::Stale)). A writer belongs to one thread at a time.
pub struct FrameWriter {
    images: Images,
    /// Header of the frame on loan; its trace holds the time of the loan.
    header: FrameHeader,
    last: Trace,
}

impl fmt::Debug for FrameWriter {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_struct("FrameWriter")
            .field("last", &self.last)
            .finish_non_exhaustive()
    }
}

impl FrameWriter {
    /// Opens the writer of a rig's frames. The rig is `"default"`, or the one that the chain was
    /// started with (`--rig NAME`).
    ///
    /// # Errors
    /// The rig already has a writer, its name is invalid, shared memory is missing, or the chain is
    /// of another release or another user.
    pub fn open(rig: &str) -> Result<Self, WriteError> {
        Self::open_in(Domain::open()?, &rig.parse()?, Waiting::default())
    }

    /// Opens the writer in a given domain, with a given behavior towards slow readers.
    ///
    /// # Errors
    /// As for [`open`](Self::open), or the chain is open with the other setting of `lossless`.
    pub fn open_in(domain: Domain, rig: &Rig, waiting: Waiting) -> Result<Self, WriteError> {
        let images = Images::open(domain, rig, &FRAMES, waiting).map_err(|cause| match cause {
            WireError::SecondWriter { channel } => WriteError::FramesTaken { channel },
            cause => cause.into(),
        })?;
        Ok(Self {
            images,
            header: FrameHeader::default(),
            last: Trace::EMPTY,
        })
    }

    /// Borrows the slot of the next frame, with rows without gaps. It still holds the pixels of an
    /// earlier frame. A slot that was borrowed and not sent is returned.
    ///
    /// Slots are as large as the largest frame to date, and there is one slot for each frame that
    /// can be in flight. The first frame of a larger size therefore takes some milliseconds longer.
    ///
    /// # Errors
    /// The size is invalid, or `/dev/shm` lacks the space.
    pub fn loan(
        &mut self,
        width: u32,
        height: u32,
        format: PixelFormat,
    ) -> Result<&mut [u8], WriteError> {
        let sides = 1..=MAX_SIDE;
        if !sides.contains(&width) || !sides.contains(&height) {
            return Err(WriteError::Size { width, height });
        }
        let stride = format.row_bytes(width) as u32;
        self.header = FrameHeader {
            width,
            height,
            stride,
            pixel_format: format as u32,
            ..blank(now_ns())
        };
        Ok(self.images.loan(format.image_bytes(stride, height))?)
    }

    /// Sends the frame on loan. Returns `false` if it was lost because the writer gave up waiting
    /// for a reader.
    ///
    /// # Errors
    /// The stamp is invalid, or no frame is on loan. The frame is then neither sent nor counted.
    pub fn send(&mut self, stamp: Stamp) -> Result<bool, WriteError> {
        let borrowed_ns = self.header.trace.exposed_ns;
        let trace = self.stamped(stamp, borrowed_ns).inspect_err(|_| {
            self.images.on_loan = None;
        })?;
        let sent = self.images.send(FrameHeader {
            trace,
            ..self.header
        })?;
        self.header.trace = trace;
        self.last = trace;
        Ok(sent)
    }

    /// Header of the frame sent last, as its readers see it, for a [`MaskWriter`] in the same
    /// process. Call this before the next loan. After a loan, it returns the header of the frame on
    /// loan.
    pub fn last_sent(&self) -> &FrameHeader {
        &self.header
    }

    /// Sends a frame without an image, for times when the camera delivers none. If one is sent
    /// about ten times a second, readers learn that their ropes are lost, and for how long.
    ///
    /// # Errors
    /// As for [`send`](Self::send).
    pub fn send_blank(&mut self, stamp: Stamp) -> Result<bool, WriteError> {
        self.images.loan(0)?;
        self.header = blank(now_ns());
        self.send(stamp)
    }

    /// Returns whether the slots have room for an image of this many bytes. Otherwise the next loan
    /// makes new slots, and borrowed memory becomes invalid.
    pub fn has_room(&self, bytes: usize) -> bool {
        self.images.has_room(bytes)
    }

    /// Returns whether this writer waits for slow readers, so that each of them receives every
    /// frame.
    pub fn is_lossless(&self) -> bool {
        self.images.is_lossless()
    }

    fn stamped(&self, stamp: Stamp, borrowed_ns: u64) -> Result<Trace, WriteError> {
        let now_ns = now_ns();
        // Two loans within one tick of the clock still get different times.
        let exposed_ns = stamp.exposed_ns;
        let exposed_ns = exposed_ns.unwrap_or(borrowed_ns.max(self.last.exposed_ns + 1));
        if exposed_ns > now_ns && stamp.exposed_ns.is_some() {
            let ahead_ns = exposed_ns - now_ns;
            return Err(WriteError::Future { ahead_ns });
        }
        if exposed_ns <= self.last.exposed_ns {
            let behind_ns = self.last.exposed_ns - exposed_ns;
            return Err(WriteError::Backwards { behind_ns });
        }
        let last = self.last.sequence;
        let sequence = stamp.sequence.unwrap_or(last + 1);
        if sequence <= last {
            let given = sequence;
            return Err(WriteError::Sequence { given, last });
        }
        Ok(Trace {
            sequence,
            captured: self.last.captured + 1,
            exposed_ns,
            captured_ns: now_ns,
            ..Trace::EMPTY
        })
    }
}

fn blank(exposed_ns: u64) -> FrameHeader {
    FrameHeader {
        trace: Trace {
            exposed_ns,
            ..Trace::EMPTY
        },
        source: SourceKind::Camera as u32,
        ..FrameHeader::default()
    }
}
