//! A depth camera beside the one whose frames are sent: each frame's depth image is the one nearest to it in time.
//!
//! It has a thread of its own, so that neither camera waits for the other: capture hands it the headers of the frames that were sent, by
//! a queue that is never waited at, and an eventfd that wakes it. The driver writes into slots of shared memory, as that of
//! the other camera does, and the slot itself is sent with its frame's header ([`Pairing`]); only where a second frame may want the image,
//! too, that frame has the slot and the first a copy.
//!
//! A frame without a depth image gets one of 0 × 0 pixels, so that fit need not wait to know it.

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

/// Frames that may be on their way to the thread. It takes them at once: more means that it does not run.
const MOST_ON_THE_WAY: usize = 16;

/// What a depth camera's period is taken to be if its driver does not tell it.
const USUAL_PERIOD_NS: u64 = 33_333_333;

/// How far in time a frame may be from its image (`None`: three fifths of the depth camera's period, which is half of it and some jitter),
/// and how long after its capture the image is waited for.
#[derive(Debug, Clone, Copy)]
pub(in super::super) struct Bounds {
    pub(in super::super) within_ns: Option<u64>,
    pub(in super::super) patience_ns: u64,
}

impl Bounds {
    pub(super) fn of(settings: &Settings) -> Self {
        Self {
            within_ns: settings.capture.depth_within.map(nanoseconds),
            // Half of what fit waits: the other half is for the way there.
            patience_ns: nanoseconds(settings.camera.depth_deadline / 2),
        }
    }
}

/// A depth camera, and the thread that it has.
pub(in super::super) struct DepthCamera {
    /// `None` once no frame is to come.
    frames: Option<SyncSender<FrameHeader>>,
    bell: Arc<OwnedFd>,
    thread: Option<JoinHandle<anyhow::Result<DepthCounts>>>,
}

impl DepthCamera {
    /// Starts the thread, which has the channel when this returns. `domain`: where the rig lives, which the thread joins by itself.
    ///
    /// # Errors
    /// There is no room for the images in shared memory, or no thread to be had.
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
            // Those that wait for their frames, the one that has just come, and a copy.
            let writer = Writer::depths(&domain, &rig, &delivery, bytes, wanted + MOST_IMAGES + 2)?;
            let lender = SlotLender::new(source, &writer)?;
            // What capture may not have of its place it says itself.
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

    /// A frame was sent.
    ///
    /// # Errors
    /// The thread has ended.
    pub(super) fn frame(&mut self, frame: &FrameHeader) -> anyhow::Result<()> {
        // There is none beside a frame without an image.
        let Some(frames) = self.frames.as_ref().filter(|_| frame.width > 0) else {
            return Ok(());
        };
        match frames.try_send(*frame) {
            Ok(()) => self.ring(),
            // Fit sees that its image does not come, and counts it.
            Err(TrySendError::Full(_)) => {}
            Err(TrySendError::Disconnected(_)) => return Err(self.fault()),
        }
        Ok(())
    }

    /// No frame is to come: those that wait are answered, and the camera is stopped.
    ///
    /// # Errors
    /// The thread had ended with a fault.
    pub(super) fn end(mut self) -> anyhow::Result<DepthCounts> {
        self.join()
    }

    fn ring(&self) {
        // Full it rings anyway.
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

    /// Why the thread has ended, which it does not by itself.
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
            // Whoever drops it without its end has an error of its own.
            let _ = self.join();
        }
    }
}

/// An image that waits for its frame.
struct Image<'w> {
    frame: Frame,
    slot: Slot<'w, [u8]>,
}

/// What comes to the thread.
struct Post {
    bounds: Bounds,
    frames: Receiver<FrameHeader>,
    bell: Arc<OwnedFd>,
}

impl Post {
    /// Pairs until no frame is to come and none waits.
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

    /// Has the frames that came wait for their images. Whether none is to come any more.
    fn take_frames(
        &self,
        pairing: &mut Pairing<FrameHeader, Image>,
        writer: &Writer<[u8]>,
    ) -> anyhow::Result<bool> {
        // Emptied before the queue is: who rings afterwards is heard.
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

/// Fit need not wait for what will not come.
fn send_none(header: &FrameHeader, writer: &Writer<[u8]>) -> anyhow::Result<()> {
    let mut slot = writer.frame_slot(0)?;
    *slot.header_mut() = header.of_depth([0; 2]);
    slot.send()?;
    Ok(())
}

#[cfg(test)]
mod tests;
