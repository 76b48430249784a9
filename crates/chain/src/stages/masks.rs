//! Masks that another process makes: each frame's own, waited for until the frame is too old.
//!
//! `mask = "external"`: a frame is seen through the mask that carries its trace, to the last bit. A mask is a `Gray8` image
//! of its frame's size with the frame's header (`FrameHeader::of_mask`), the higher the likelier rope. Extract waits for it until
//! `mask_deadline_us` after the frame's capture, so that frames that wait behind each other do not add up their waits; it
//! gives up earlier when a later frame's mask comes. Waiting counts as waiting, not as extraction's work. Who makes masks
//! reads the newest frame (`wire::FrameReader`, `MaskWriter`; `examples/mask_network.rs`), and may be slower than the camera: then extract's own buffer
//! overflows meanwhile, by the backlog rule it goes to the newest frame when the mask comes, and that is the one the other
//! has just taken up. A `--lossless` chain needs a `--lossless` maker of masks.

use std::os::fd::AsFd;
use std::time::{Duration, Instant};

use lariat_extract::Mask;
use lariat_wire::{FrameHeader, MASKS, Message, Receiver, WireError, now_ns};

use super::Station;
use crate::settings::Settings;
use crate::stop::Stop;

/// Told to stop, a frame's mask is waited for no longer than this: the few frames that are left then end in time.
const AFTER_STOP: Duration = Duration::from_secs(1);

/// The masks of a rig.
pub(super) struct Masks {
    reader: Receiver<[u8]>,
    channel: String,
    deadline: Duration,
    /// The newest that came. It may be for a frame that is still to come.
    held: Option<Message<[u8]>>,
    late: u64,
}

impl Masks {
    /// Becomes a reader of the masks, if the settings ask for masks from elsewhere.
    pub(super) fn open(settings: &Settings, station: &Station) -> anyhow::Result<Option<Self>> {
        if settings.extract.mask != Mask::External {
            return Ok(None);
        }
        let Station {
            domain,
            rig,
            delivery,
            ..
        } = station;
        Ok(Some(Self {
            reader: Receiver::create(domain, rig, &MASKS, Some(delivery))?,
            channel: MASKS.on(rig),
            deadline: settings.extract.mask_deadline,
            held: None,
            late: 0,
        }))
    }

    /// The mask of the frame, waited for if need be; `None`, and the frame counts as skipped, if it does not come in
    /// time after the frame was captured, or if one for a later frame comes instead.
    pub(super) fn of(
        &mut self,
        frame: &FrameHeader,
        stop: &Stop,
    ) -> Result<Option<&Message<[u8]>>, WireError> {
        let found = self.wait_for(frame, stop)?;
        if !found {
            self.late += 1;
        }
        // Said once: a fault of every frame would fill the screen.
        if !found && self.late == 1 {
            tracing::warn!(
                "frame {} was skipped: no mask of it came within {:?} of its capture, or a later frame's came first. Is a \
                 process running that writes {}, and is mask_deadline_us long enough for it?",
                frame.trace.sequence,
                self.deadline,
                self.channel
            );
        }
        Ok(self.held.as_ref().filter(|_| found))
    }

    /// How many frames were skipped.
    pub(super) fn late(&self) -> u64 {
        self.late
    }

    /// Whether the held mask is now the frame's.
    fn wait_for(&mut self, frame: &FrameHeader, stop: &Stop) -> Result<bool, WireError> {
        let age = Duration::from_nanos(now_ns().saturating_sub(frame.trace.captured_ns));
        let deadline = Instant::now() + self.deadline.saturating_sub(age);
        let mut last = None;
        loop {
            if let Some(mask) = &self.held {
                let mask = &mask.header().trace;
                // A capture that began anew counts from 1 again; its clock goes on.
                if mask.captured_ns > frame.trace.captured_ns {
                    return Ok(false);
                }
                if *mask == frame.trace {
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
