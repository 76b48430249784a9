//! Images that accompany frames: masks from another process, and depth images. Each is paired with
//! its frame. A frame that is too old is not paired.
//!
//! Each image carries its frame's trace as capture made it. It is awaited until a deadline after
//! the frame's capture, so that the waits of queued frames do not add up. The wait ends early if
//! the image of a later frame arrives. The wait does not count as a stage's work.
//!
//! `mask = "external"`: a mask is a `Gray8` image of its frame's size (`FrameHeader::of_mask`),
//! with higher levels where rope is more likely. The maker of masks reads the newest frame
//! (`wire::FrameReader`, `MaskWriter`; `examples/mask_network.rs`) and may be slower than the
//! camera. Extract's own buffer then overflows. When the mask arrives, the backlog rule makes
//! extract continue with the newest frame, which the mask maker has just taken. A `--lossless`
//! chain needs a `--lossless` maker of masks. A frame without its mask is skipped and counted.
//!
//! `[camera] depth`: a depth image is a `Gray16` image of its own size (`FrameHeader::of_depth`),
//! which fit reads. A frame without one has its curves in the image only, and its 3-D message says
//! that the depth image is missing. A depth image of 0 × 0 pixels says that none will come, so that
//! fit does not wait.

use std::os::fd::AsFd;
use std::time::{Duration, Instant};

use lariat_wire::{Channel, Message, Receiver, Trace, WireError, now_ns};

use super::Station;
use crate::stop::Stop;

/// Maximum wait for a mask after a stop was requested, so that the few remaining frames finish in
/// time.
const AFTER_STOP: Duration = Duration::from_secs(1);

/// Number of consecutive frames without a companion after which the warning repeats.
const IN_A_ROW: u64 = 10;

/// Words for the warnings.
#[derive(Debug, Clone, Copy)]
pub(super) struct Words {
    /// Name of a companion.
    pub(super) what: &'static str,
    /// Consequence for a frame without a companion.
    pub(super) without: &'static str,
    /// Name of the setting for the deadline.
    pub(super) setting: &'static str,
}

/// Reads the companions of a rig's frames.
pub(super) struct Companions {
    reader: Receiver<[u8]>,
    channel: String,
    words: Words,
    deadline: Duration,
    /// The newest companion. Its frame may still be to come.
    held: Option<Message<[u8]>>,
    late: u64,
    in_a_row: u64,
    is_told: bool,
}

impl Companions {
    /// Opens a reader of the companions.
    pub(super) fn open(
        channel: &'static Channel<[u8]>,
        words: Words,
        deadline: Duration,
        station: &Station,
    ) -> anyhow::Result<Self> {
        let Station {
            domain,
            rig,
            delivery,
            ..
        } = station;
        Ok(Self {
            reader: Receiver::create(domain, rig, channel, Some(delivery))?,
            channel: channel.on(rig),
            words,
            deadline,
            held: None,
            late: 0,
            in_a_row: 0,
            is_told: false,
        })
    }

    /// Returns the companion of a frame, waiting for it if necessary. Counts the frame and returns
    /// `None` if it is late, or if the companion of a later frame arrives first.
    pub(super) fn of(
        &mut self,
        frame: &Trace,
        stop: &Stop,
    ) -> Result<Option<&Message<[u8]>>, WireError> {
        let came = self.wait_for(frame, stop)?;
        let is_image = |held: &Message<[u8]>| held.header().width > 0;
        let found = came && self.held.as_ref().is_some_and(is_image);
        self.late += u64::from(!found);
        self.in_a_row = if came { 0 } else { self.in_a_row + 1 };
        // Warn only once, because a fault in every frame would fill the screen.
        let is_first = !came && !std::mem::replace(&mut self.is_told, true);
        if is_first || self.in_a_row == IN_A_ROW {
            let row = match is_first {
                true => String::new(),
                false => format!(", and {} before it", IN_A_ROW - 1),
            };
            let Words {
                what,
                without,
                setting,
            } = self.words;
            tracing::warn!(
                "frame {} {without}{row}: no {what} of it came within {:?} of its capture, or a later frame's came first. Is a \
                 process running that writes {}, and is {setting} long enough for it?",
                frame.sequence,
                self.deadline,
                self.channel
            );
        }
        Ok(self.held.as_ref().filter(|_| found))
    }

    /// Returns the number of frames without a companion.
    pub(super) fn late(&self) -> u64 {
        self.late
    }

    /// Waits for the frame's companion. Returns true if it arrived and is in `held`.
    fn wait_for(&mut self, frame: &Trace, stop: &Stop) -> Result<bool, WireError> {
        let age = Duration::from_nanos(now_ns().saturating_sub(frame.captured_ns));
        let deadline = Instant::now() + self.deadline.saturating_sub(age);
        let mut last = None;
        loop {
            if let Some(held) = &self.held {
                let held = &held.header().trace;
                // A restarted capture counts from 1 again, but its clock continues.
                if held.captured_ns > frame.captured_ns {
                    return Ok(false);
                }
                if is_of(held, frame) {
                    return Ok(true);
                }
                self.held = None;
            }
            self.held = self.reader.next()?;
            if self.held.is_some() {
                continue;
            }
            if stop.asked() {
                last.get_or_insert_with(|| deadline.min(Instant::now() + AFTER_STOP));
            }
            let until = last.unwrap_or(deadline);
            if Instant::now() >= until {
                return Ok(false);
            }
            // After the signal, the pipe stays readable and would end every sleep at once.
            let also = last.is_none().then(|| stop.as_fd());
            self.reader.sleep(Some(until), also)?;
        }
    }
}

/// Returns true if both traces belong to the same frame, whatever later stages have added.
fn is_of(held: &Trace, frame: &Trace) -> bool {
    let of = |trace: &Trace| {
        [
            trace.sequence,
            trace.captured,
            trace.exposed_ns,
            trace.captured_ns,
        ]
    };
    of(held) == of(frame)
}
