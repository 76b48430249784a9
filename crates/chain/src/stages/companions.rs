//! Images that come beside frames: masks that another process makes, and depth. Each is paired with its frame, and not waited for when
//! the frame is too old.
//!
//! Each carries its frame's trace, as capture made it. It is waited for until a deadline after the frame's capture, so that frames that
//! wait behind each other do not add up their waits; earlier it is given up when a later frame's comes. Waiting counts as waiting,
//! not as a stage's work.
//!
//! `mask = "external"`: a mask is a `Gray8` image of its frame's size (`FrameHeader::of_mask`), the higher the likelier rope. Who makes masks
//! reads the newest frame (`wire::FrameReader`, `MaskWriter`; `examples/mask_network.rs`), and may be slower than the camera: then extract's own buffer
//! overflows meanwhile, by the backlog rule it goes to the newest frame when the mask comes, and that is the one the other
//! has just taken up. A `--lossless` chain needs a `--lossless` maker of masks. A frame without its mask is skipped, and counted.
//!
//! `[camera] depth`: a depth image is a `Gray16` of its own size (`FrameHeader::of_depth`), which fit reads. A frame without one has its
//! curves in the image, and in space the word that there was none. One of 0 × 0 pixels says that none will come, so that it is not waited for.

use std::os::fd::AsFd;
use std::time::{Duration, Instant};

use lariat_wire::{Channel, Message, Receiver, Trace, WireError, now_ns};

use super::Station;
use crate::stop::Stop;

/// Told to stop, a frame's mask is waited for no longer than this: the few frames that are left then end in time.
const AFTER_STOP: Duration = Duration::from_secs(1);

/// Frames in a row without a companion after which the warning repeats.
const IN_A_ROW: u64 = 10;

/// How they are spoken of.
#[derive(Debug, Clone, Copy)]
pub(super) struct Words {
    /// What one of them is called.
    pub(super) what: &'static str,
    /// What becomes of a frame that has none.
    pub(super) without: &'static str,
    /// The setting that says how long one is waited for.
    pub(super) setting: &'static str,
}

/// What a rig has beside its frames.
pub(super) struct Companions {
    reader: Receiver<[u8]>,
    channel: String,
    words: Words,
    deadline: Duration,
    /// The newest that came. It may be for a frame that is still to come.
    held: Option<Message<[u8]>>,
    late: u64,
    in_a_row: u64,
    is_told: bool,
}

impl Companions {
    /// Becomes a reader of them.
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

    /// That of the frame, waited for if need be; `None`, and the frame is counted, if it does not come in
    /// time after the frame was captured, or if one for a later frame comes instead.
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
        // A fault of every frame would fill the screen.
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

    /// How many frames had none.
    pub(super) fn late(&self) -> u64 {
        self.late
    }

    /// Whether the held one is now the frame's.
    fn wait_for(&mut self, frame: &Trace, stop: &Stop) -> Result<bool, WireError> {
        let age = Duration::from_nanos(now_ns().saturating_sub(frame.captured_ns));
        let deadline = Instant::now() + self.deadline.saturating_sub(age);
        let mut last = None;
        loop {
            if let Some(held) = &self.held {
                let held = &held.header().trace;
                // A restarted capture counts from 1 again; its clock continues.
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
            // Once the signal has come, its pipe would wake again and again.
            let also = last.is_none().then(|| stop.as_fd());
            self.reader.sleep(Some(until), also)?;
        }
    }
}

/// Whether both are of one frame, whatever stages have added since.
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
