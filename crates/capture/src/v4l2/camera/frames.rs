//! Handles a camera that streams: takes the next frame from the driver, or yields a blank one.

use super::*;
use crate::v4l2::driver::Filled;
use crate::v4l2::stamp::Doubt;

/// Time that automatic controls take to settle after the first frame.
const SETTLED_NS: u64 = 1_000_000_000;
/// Interval at which the exposure time is read, if it is needed. Automatic exposure changes it
/// slowly.
const EXPOSURE_NS: u64 = 1_000_000_000;

impl<P: Port> Camera<P> {
    /// Waits for the driver's next frame. `None` means that the caller should ask again.
    pub(super) fn take(&mut self, until: &Until) -> Option<Next> {
        if let Some(failure) = self.refused.take() {
            self.fall(failure);
            return None;
        }
        let State::Streaming(stream) = &mut self.state else {
            return None;
        };
        let moment_ns = self.silence.next_ns();
        let event = stream.driver().map(|driver| (driver.fd(), PollFlags::IN));
        match until.wait(event, Some(moment_ns)) {
            Woken::Interrupted => Some(Next::Nothing),
            Woken::Moment => self.blank_if_due(now_ns()),
            Woken::Ready(events) => match stream.dequeue() {
                Ok(filled) => self.filled(&filled, now_ns()),
                Err(Errno::AGAIN) if !events.intersects(PollFlags::ERR | PollFlags::HUP) => None,
                // An error without a code is fatal.
                Err(Errno::AGAIN) => self.fall(("poll", Errno::IO)),
                Err(errno) => self.fall(("VIDIOC_DQBUF", errno)),
            },
        }
    }

    /// Makes a frame from a filled buffer.
    fn filled(&mut self, filled: &Filled, now_ns: u64) -> Option<Next> {
        // Frames that cannot be used also have numbers, which become gaps.
        let sequence = self.sequence.of(filled.sequence);
        let is_short = filled.bytes < self.shape.least_bytes();
        if filled.is_damaged || is_short {
            if let Some((new, total)) = self.damaged.add(now_ns) {
                let how = if filled.is_damaged {
                    "damaged, as its driver says".to_owned()
                } else {
                    format!("cut short, the last to {} bytes", filled.bytes)
                };
                self.told.warn(&format!("{}, {how}", lost(new, total)));
            }
            return self.requeue(filled);
        }
        let mut frame = self.frame(sequence);
        match self.memory {
            Memory::Lent => {
                let State::Streaming(stream) = &mut self.state else {
                    return None;
                };
                let mut slot = stream.take_slot(filled)?;
                self.shape.expand(&mut slot);
                frame.slot = Some(slot.give_back());
            }
            Memory::Mapped => {
                let read = self.read(filled, &mut frame, now_ns);
                self.requeue(filled);
                if !read {
                    return None;
                }
            }
        }
        frame.exposed_ns = Some(self.stamper.exposed_ns(filled.time, now_ns));
        self.after_frame(filled, now_ns);
        Some(Next::Frame(frame))
    }

    fn frame(&self, sequence: u64) -> Frame {
        let Shape {
            width,
            height,
            stride,
            encoding,
            ..
        } = self.shape;
        let (format, stride) = match encoding {
            Encoding::Plain(format) => (format, stride),
            Encoding::Jpeg => (PixelFormat::Rgb8, PixelFormat::Rgb8.row_bytes(width) as u32),
        };
        Frame {
            sequence,
            width,
            height,
            stride,
            format,
            exposed_ns: None,
            slot: None,
        }
    }

    /// Copies or decodes a frame from the driver's memory into a lent slot or the spare buffer.
    /// Returns whether that worked.
    fn read(&mut self, filled: &Filled, frame: &mut Frame, now_ns: u64) -> bool {
        let State::Streaming(stream) = &self.state else {
            return false;
        };
        let bytes = stream.mapped(filled);
        let mut slot = self.slots.pop();
        let into: &mut [u8] = match &mut slot {
            Some(slot) => slot,
            None => {
                self.spare.resize(self.shape.frame_bytes(), 0);
                &mut self.spare
            }
        };
        let Some(decoder) = &mut self.decoder else {
            let count = bytes.len().min(into.len());
            into[..count].copy_from_slice(&bytes[..count]);
            self.shape.expand(&mut into[..count]);
            frame.slot = slot.map(LentSlot::give_back);
            return true;
        };
        match decoder.decode(bytes, into) {
            Ok(format) => {
                frame.format = format;
                frame.stride = format.row_bytes(frame.width) as u32;
                frame.slot = slot.map(LentSlot::give_back);
                true
            }
            Err(error) => {
                self.slots.extend(slot);
                if let Some((new, total)) = self.undecoded.add(now_ns) {
                    self.told.warn(&format!("{}, as {error}", lost(new, total)));
                }
                false
            }
        }
    }

    /// Queues a buffer again.
    fn requeue(&mut self, filled: &Filled) -> Option<Next> {
        if let State::Streaming(stream) = &mut self.state
            && let Err(failure) = stream.requeue(filled)
        {
            self.refused = Some(failure);
        }
        None
    }

    /// Work after a frame that is not urgent.
    fn after_frame(&mut self, filled: &Filled, now_ns: u64) {
        if let Some(pause_ns) = self.silence.end(now_ns) {
            self.told.news(&format!(
                "frames come again, after {} ms without",
                pause_ns / 1_000_000
            ));
        }
        self.has_shown = true;
        self.recovery.goes_well(now_ns);
        let State::Streaming(stream) = &mut self.state else {
            return;
        };
        let mended = stream.take_mended();
        if let Some((call, errno)) = mended.last {
            self.told.warn(&format!(
                "{call} failed ({errno}) and then did not; calls that had to be tried twice: {}",
                mended.count
            ));
        }
        if Stamper::needs_exposure(filled.time.flags) && now_ns >= self.exposure_at_ns {
            self.exposure_at_ns = now_ns + EXPOSURE_NS;
            self.stamper.exposure_ns = stream.driver().and_then(Driver::exposure_ns);
        }
        let settles_ns = *self.settles_ns.get_or_insert(now_ns + SETTLED_NS);
        if now_ns >= settles_ns {
            self.settles_ns = Some(u64::MAX);
            if let Some(sentence) = stream.driver().and_then(|driver| self.port.settled(driver)) {
                self.told.news.push_back(sentence);
            }
        }
        while let Some(doubt) = self.stamper.take_doubt() {
            self.told.warn(Doubt::sentence(doubt));
        }
    }

    /// Yields a blank frame if one is due.
    pub(super) fn blank_if_due(&mut self, now_ns: u64) -> Option<Next> {
        let silent = self.silence.due(now_ns)?;
        if let Some(silent_ns) = silent.report_ns {
            self.told.warn(&format!(
                "no frame has come for {} ms, which is more than three of its periods",
                silent_ns / 1_000_000
            ));
        }
        // Before the first frame, no rope can be lost.
        let number = self.has_shown.then(|| self.sequence.own())?;
        Some(Next::Frame(Frame::blank(number, now_ns)))
    }
}

/// Start of a sentence about lost frames.
fn lost(new: u64, total: u64) -> String {
    let frames = if new == 1 {
        "a frame was".to_owned()
    } else {
        format!("{new} frames were")
    };
    format!("{frames} lost at the source ({total} in all)")
}
