#![allow(unsafe_code)] // A writer may go to another thread, which the transport's own counters do not know.
//! A camera or a mask network of the user's own: images into a rig's shared memory, with a header and stamps that the chain
//! counts and times by.
//!
//! A writer of images takes the channel as it is, lossless or not; its slots are made for the largest image so far, and again for a larger one. Python's
//! arrays of a slot are views of it: they are counted, and while one lives the writer's memory stays mapped (closing waits for the last one, larger slots
//! are refused, as `mmap` has it). Frames in Python are copies, as messages are.

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

/// How a writer of images deals with slow readers.
#[derive(Clone, Default)]
pub struct Waiting {
    /// Whether each image is to reach every reader, for which its writer waits. `None`: as the chain is that runs; the newest
    /// wins where none does.
    pub lossless: Option<bool>,
    /// Set, it ends a lossless writer's wait within a few seconds.
    pub stop: Arc<AtomicBool>,
    /// What is called about every 50 ms during such a wait. It may set `stop`.
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

/// When an image was taken, and its number; what is left out is filled in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Stamp {
    /// When it was taken, on the clock of [`now_ns`]. `None`: when its slot was borrowed, which is never too young for an image
    /// that was there before.
    pub exposed_ns: Option<u64>,
    /// The camera's own number for it, from 1. A gap counts as frames lost at the source. `None`: one after the last.
    pub sequence: Option<u64>,
}

/// The images' end of a channel, whose slots grow with the largest image.
struct Images {
    // The slot before its writer, the writer before its domain: each lives in the next.
    on_loan: Option<KeptSlot>,
    /// With the most bytes of an image. `None` after a failure to make larger slots.
    writer: Option<(usize, Writer<[u8]>)>,
    domain: Domain,
    rig: Rig,
    channel: &'static Channel<[u8]>,
    delivery: Delivery,
    meanwhile: Option<Meanwhile>,
}

// SAFETY: as for `Reader`: what is not `Send` are counted references without atomics inside the transport's publisher (which a
// slot on loan shares), notifier and listener. Each is a field of this one struct and is lent out by a borrow of it only: all that
// share a count go to another thread together or not at all.
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
        // Room for no pixel yet: the channel has its writer from now on, and a second one is refused.
        images.make_room(1)?;
        Ok(images)
    }

    fn make_room(&mut self, bytes: usize) -> Result<&Writer<[u8]>, WireError> {
        self.on_loan = None;
        // One that is too small goes first: two writers at a time are one too many.
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

    /// The slot that is on loan instead, if one is, is given back unsent.
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

/// Writes the frames of a rig whose chain was started with `lariat run --source external`: any camera's, a simulator's, a
/// player's.
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
/// It may be opened before the chain runs, and outlives it. Frames are counted as a camera's: the chain knows from the stamps
/// what was lost, and where. A process that ends, or is killed, leaves the channel to the next one; meanwhile what readers know
/// of the ropes gets older ([`Seen::Stale`](crate::Seen::Stale)). It belongs to one thread at a time.
pub struct FrameWriter {
    images: Images,
    /// Of the frame on loan; its trace has the moment of the loan.
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
    /// Becomes the writer of a rig's frames: `"default"`, or what the chain was started with (`--rig NAME`).
    ///
    /// # Errors
    /// The rig has a writer; no such name, no shared memory, a chain of another release or of another user.
    pub fn open(rig: &str) -> Result<Self, WriteError> {
        Self::open_in(Domain::open()?, &rig.parse()?, Waiting::default())
    }

    /// The same, in a domain of one's own choice, and with a word on slow readers.
    ///
    /// # Errors
    /// As [`open`](Self::open); and the chain's readers are waited for, where they are not to be, or the other way around.
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

    /// Borrows the slot of the next frame, rows one after the other without gaps. It holds an earlier one's pixels. A slot that
    /// was borrowed and not sent is given back.
    ///
    /// Slots are made for the largest frame so far, at once for all that can be under way: the first frame of a larger size
    /// takes some milliseconds longer.
    ///
    /// # Errors
    /// An invalid size, no room for it in `/dev/shm`.
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

    /// Sends the frame on loan. `false`: it was lost, because waiting for a reader was given up.
    ///
    /// # Errors
    /// A stamp that cannot be, or nothing to send. The frame is then not sent, and not counted.
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

    /// The header of the frame that was sent last, as its readers have it: for a [`MaskWriter`] in the same process. Asked before
    /// the next loan, as it is the one of the frame on loan then.
    pub fn last_sent(&self) -> &FrameHeader {
        &self.header
    }

    /// Sends a frame without an image: the camera has none to give just now. Sent some ten times a second for as long as that
    /// is so, it has readers told that their ropes are lost from sight, and for how long.
    ///
    /// # Errors
    /// As [`send`](Self::send).
    pub fn send_blank(&mut self, stamp: Stamp) -> Result<bool, WriteError> {
        self.images.loan(0)?;
        self.header = blank(now_ns());
        self.send(stamp)
    }

    /// True if its slots have room for an image of this many bytes. Otherwise the next loan makes new slots, and borrowed memory
    /// becomes invalid.
    pub fn has_room(&self, bytes: usize) -> bool {
        self.images.has_room(bytes)
    }

    /// Whether it waits for slow readers, so that each of them has every frame.
    pub fn is_lossless(&self) -> bool {
        self.images.is_lossless()
    }

    fn stamped(&self, stamp: Stamp, borrowed_ns: u64) -> Result<Trace, WriteError> {
        let now_ns = now_ns();
        // Two loans within one tick of the clock were still one after the other.
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
