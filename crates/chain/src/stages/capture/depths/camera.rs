//! A depth camera in addition to the camera that supplies the frames. The depth image of each frame
//! is the one nearest in time.
//!
//! It has its own thread, so that neither camera waits for the other. After capture has sent a
//! frame, it puts the frame's header into a nonblocking queue and wakes the thread with an eventfd.
//! The driver writes into slots of shared memory, like the other camera's driver, and the slot
//! itself is sent with its frame's header ([`Pairing`]). If a second frame may need the same image,
//! the first frame gets a copy and the second frame gets the slot.
//!
//! A frame without a depth image gets one of 0 × 0 pixels, so that fit does not wait for it.

use std::os::fd::{AsFd, OwnedFd};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, TrySendError, sync_channel};
use std::thread::JoinHandle;

use anyhow::{Context, anyhow, bail};
use lariat_capture::{Frame, FrameSource, MOST_IMAGES, Next, Paired, Pairing, Until};
use lariat_sink::DepthCounts;
use lariat_wire::{Domain, FrameHeader, Slot, Trace, WireError, Writer, now_ns};
use rustix::event::{EventfdFlags, eventfd};

use super::super::tell;
use crate::settings::{Settings, Stage, nanoseconds};
use crate::stages::Station;
use crate::stages::arrangement::{self, precise_timer};
use crate::stages::slot_lender::SlotLender;

/// Capacity of the queue of frames. The thread reads them immediately, so a full queue means that
/// it does not run.
const MOST_ON_THE_WAY: usize = 16;

/// Assumed period of a depth camera whose driver does not report one.
const USUAL_PERIOD_NS: u64 = 33_333_333;

/// Time limits for pairing. `within_ns` is the maximum time between a frame and its image; `None`
/// means three fifths of the depth camera's period, which is half of it plus jitter. `patience_ns`
/// is how long after a frame's capture its image is awaited.
#[derive(Debug, Clone, Copy)]
pub(in super::super) struct Bounds {
    pub(in super::super) within_ns: Option<u64>,
    pub(in super::super) patience_ns: u64,
}

impl Bounds {
    pub(super) fn of(settings: &Settings) -> Self {
        Self {
            within_ns: settings.capture.depth_within.map(nanoseconds),
            // Half of the time that fit waits. The other half is for the transport.
            patience_ns: nanoseconds(settings.camera.depth_deadline / 2),
        }
    }
}

/// A depth camera and its thread.
pub(in super::super) struct DepthCamera {
    /// `None` once no more frames follow.
    frames: Option<SyncSender<FrameHeader>>,
    bell: Arc<OwnedFd>,
    thread: Option<JoinHandle<anyhow::Result<DepthCounts>>>,
}

impl DepthCamera {
    /// Starts the thread, which has opened the channel when this returns. `domain` opens the rig's
    /// domain, which the thread joins separately.
    ///
    /// # Errors
    /// Returns an error if shared memory is too small for the images, or if the thread cannot be
    /// started.
    pub(in super::super) fn start(
        source: Box<dyn FrameSource>,
        bounds: Bounds,
        domain: fn() -> Result<Domain, WireError>,
        station: &Station,
    ) -> anyhow::Result<Self> {
        let flags = EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK;
        let bell = eventfd(0, flags).context("no eventfd could be made for the depth camera")?;
        let bell = Arc::new(bell);
        let (frames, taken) = sync_channel(MOST_ON_THE_WAY);
        let (ready, is_ready) = sync_channel(1);
        let post = Post {
            bounds,
            frames: taken,
            bell: bell.clone(),
        };
        let (rig, delivery) = (station.rig.clone(), station.delivery.clone());
        let arrangement = station.arrangement.clone();
        let run = move || {
            let domain = domain()?;
            let (bytes, wanted) = (source.largest_frame_bytes(), source.slots_wanted());
            // Slots for the images that wait for their frames, the newest image, and a copy.
            let writer = Writer::depths(&domain, &rig, &delivery, bytes, wanted + MOST_IMAGES + 2)?;
            let lender = SlotLender::new(source, &writer)?;
            // Capture itself reports which resources it lacks.
            let _ = arrangement::apply(&arrangement, Stage::Capture);
            precise_timer();
            let _ = ready.send(());
            post.work(lender, &writer)
        };
        let thread = std::thread::Builder::new().name("depth".to_owned());
        let thread = thread
            .spawn(run)
            .context("no thread for the depth camera")?;
        let mut camera = Self {
            frames: Some(frames),
            bell,
            thread: Some(thread),
        };
        match is_ready.recv() {
            Ok(()) => Ok(camera),
            Err(_) => Err(camera.fault()),
        }
    }

    /// Notes that a frame was sent.
    ///
    /// # Errors
    /// Returns an error if the thread has ended.
    pub(super) fn frame(&mut self, frame: &FrameHeader) -> anyhow::Result<()> {
        // A frame without an image does not get a depth image.
        let Some(frames) = self.frames.as_ref().filter(|_| frame.width > 0) else {
            return Ok(());
        };
        match frames.try_send(*frame) {
            Ok(()) => self.ring(),
            // Fit notices the missing image and counts it.
            Err(TrySendError::Full(_)) => {}
            Err(TrySendError::Disconnected(_)) => return Err(self.fault()),
        }
        Ok(())
    }

    /// Answers the waiting frames and stops the camera, because no more frames follow.
    ///
    /// # Errors
    /// Returns an error if the thread has failed.
    pub(super) fn end(mut self) -> anyhow::Result<DepthCounts> {
        self.join()
    }

    fn ring(&self) {
        // If the counter is full, the eventfd is readable anyway.
        let _ = rustix::io::write(&*self.bell, &1_u64.to_ne_bytes());
    }

    fn join(&mut self) -> anyhow::Result<DepthCounts> {
        drop(self.frames.take());
        self.ring();
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(ended)) => ended,
            Some(Err(panic)) => std::panic::resume_unwind(panic),
            None => Ok(DepthCounts::default()),
        }
    }

    /// Returns why the thread has ended. The thread does not end by itself.
    fn fault(&mut self) -> anyhow::Error {
        let ended = self.join();
        ended
            .err()
            .unwrap_or_else(|| anyhow!("the depth camera's thread has ended"))
    }
}

impl Drop for DepthCamera {
    fn drop(&mut self) {
        if self.thread.is_some() {
            // If this is dropped without `end`, another error came first, and that error is
            // reported.
            let _ = self.join();
        }
    }
}

/// An image that waits for its frame.
struct Image<'w> {
    frame: Frame,
    slot: Slot<'w, [u8]>,
}

/// Inputs of the thread.
struct Post {
    bounds: Bounds,
    frames: Receiver<FrameHeader>,
    bell: Arc<OwnedFd>,
}

impl Post {
    /// Pairs frames and images until the last frame has been answered.
    fn work<'w>(
        self,
        mut lender: SlotLender<'w>,
        writer: &'w Writer<[u8]>,
    ) -> anyhow::Result<DepthCounts> {
        let period_ns = lender.source.native_fps().map(|fps| (1e9 / fps) as u64);
        let usual_ns = period_ns.unwrap_or(USUAL_PERIOD_NS) / 5 * 3;
        let within_ns = self.bounds.within_ns.unwrap_or(usual_ns);
        let mut pairing = Pairing::new(within_ns, period_ns);
        let mut counts = DepthCounts::default();
        let mut last_sequence = None;
        loop {
            let until = Until::new(pairing.due_ns(), self.bell.as_fd());
            let next = lender.source.advance(&until);
            tell(lender.source.as_mut());
            match next.context("the depth camera ended with a fault")? {
                Next::Nothing => {}
                Next::End => bail!("the depth camera has ended"),
                Next::Frame(frame) => {
                    let before = last_sequence.replace(frame.sequence);
                    counts.lost +=
                        before.map_or(0, |before| frame.sequence.saturating_sub(before + 1));
                    if frame.width == 0 {
                        pairing.silence();
                    } else {
                        counts.images += 1;
                        let slot = lender.slot_of(&frame)?;
                        let exposed_ns = frame.exposed_ns.unwrap_or_else(now_ns);
                        pairing.image(Image { frame, slot }, exposed_ns);
                        lender.lend()?;
                    }
                }
            }
            let has_ended = self.take_frames(&mut pairing, writer)?;
            while let Some(paired) = pairing.next(now_ns()) {
                send(paired, &pairing, writer)?;
            }
            if has_ended && pairing.due_ns().is_none() {
                counts.unpaired = pairing.end().unpaired;
                return Ok(counts);
            }
        }
    }

    /// Queues new frames until their images arrive. Returns true if no more frames follow.
    fn take_frames(
        &self,
        pairing: &mut Pairing<FrameHeader, Image>,
        writer: &Writer<[u8]>,
    ) -> anyhow::Result<bool> {
        // Clear the eventfd before the queue is emptied, so that a later signal is not missed.
        let _ = rustix::io::read(&*self.bell, &mut [0; 8]);
        loop {
            match self.frames.try_recv() {
                Ok(frame) => {
                    let Trace {
                        exposed_ns,
                        captured_ns,
                        ..
                    } = frame.trace;
                    let until_ns = captured_ns.saturating_add(self.bounds.patience_ns);
                    if let Some(crowded) = pairing.frame(frame, exposed_ns, until_ns) {
                        send_none(&crowded, writer)?;
                    }
                }
                Err(TryRecvError::Empty) => return Ok(false),
                Err(TryRecvError::Disconnected) => return Ok(true),
            }
        }
    }
}

fn send<'w>(
    paired: Paired<FrameHeader, Image<'w>>,
    pairing: &Pairing<FrameHeader, Image<'w>>,
    writer: &'w Writer<[u8]>,
) -> anyhow::Result<()> {
    let (header, frame, slot) = match paired {
        Paired::Alone(header) => return send_none(&header, writer),
        Paired::With(header, Image { frame, slot }) => (header, frame, slot),
        Paired::Sharing(header) => {
            let shared = pairing.shared().context("a shared image is there")?;
            let mut copy = writer.frame_slot(shared.slot.len())?;
            copy.copy_from_slice(&shared.slot);
            (header, shared.frame, copy)
        }
    };
    let mut slot = slot;
    *slot.header_mut() = FrameHeader {
        stride: frame.stride,
        ..header.of_depth([frame.width, frame.height])
    };
    slot.send()?;
    Ok(())
}

/// Sends an empty depth image, so that fit does not wait.
fn send_none(header: &FrameHeader, writer: &Writer<[u8]>) -> anyhow::Result<()> {
    let mut slot = writer.frame_slot(0)?;
    *slot.header_mut() = header.of_depth([0; 2]);
    slot.send()?;
    Ok(())
}

#[cfg(test)]
mod tests;
