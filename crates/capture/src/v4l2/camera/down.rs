//! Handles a camera that is down: starts it again, or waits for it.

use std::os::fd::AsFd;

use super::*;
use crate::v4l2::error::CameraError;
use crate::v4l2::stream::NotStarted;

/// Number of consecutive failures to start after which the device is reopened.
const FAILURES_BEFORE_REOPENING: u32 = 3;

impl<P: Port> Camera<P> {
    /// Handles the end of the stream. Returns `None`, so that the caller asks again.
    pub(super) fn fall(&mut self, (call, errno): Failure) -> Option<Next> {
        let now_ns = now_ns();
        let State::Streaming(stream) = std::mem::replace(&mut self.state, State::Gone) else {
            return None;
        };
        let driver = stream.stop(&mut self.slots);
        self.silence.broken(now_ns);
        self.recovery.failed(now_ns);
        match driver.filter(|_| errno != Errno::NODEV) {
            Some(driver) => {
                self.told.warn(&format!(
                    "its stream broke ({call}: {errno}) and is restarted"
                ));
                self.state = State::Stopped(driver);
            }
            None => self.told.warn(&format!(
                "it does not answer any more ({call}: {errno}); it is waited for until it comes back"
            )),
        }
        None
    }

    /// Starts the camera, or waits until the next attempt is due. `None` means that the caller
    /// should ask again.
    ///
    /// # Errors
    /// The camera cannot be started and has never shown a frame.
    pub(super) fn rise(&mut self, until: &Until) -> Result<Option<Next>, SourceError> {
        let now_ns = now_ns();
        let at_ns = self.recovery.at_ns();
        if now_ns >= at_ns {
            return match std::mem::replace(&mut self.state, State::Gone) {
                State::Stopped(driver) => self.start(driver, now_ns).map(|()| None),
                _ => {
                    self.reopen(now_ns);
                    Ok(None)
                }
            };
        }
        let is_gone = matches!(self.state, State::Gone);
        let event = self.hotplug.as_ref().filter(|_| is_gone);
        let event = event.map(|hotplug| (hotplug.as_fd(), PollFlags::IN));
        let moment_ns = at_ns.min(self.silence.next_ns());
        Ok(match until.wait(event, Some(moment_ns)) {
            Woken::Interrupted => Some(Next::Nothing),
            Woken::Moment => self.blank_if_due(lariat_message::now_ns()),
            Woken::Ready(_) => {
                if let Some(hotplug) = &self.hotplug {
                    hotplug.drain();
                }
                self.recovery.hurry();
                None
            }
        })
    }

    fn start(&mut self, driver: P::Driver, now_ns: u64) -> Result<(), SourceError> {
        self.sequence.restart();
        self.stamper.start(now_ns);
        self.refused = None;
        // Without slots there is nothing to lend to the driver.
        if self.slots.is_empty() && self.memory == Memory::Lent {
            self.memory = Memory::Mapped;
        }
        let failed = match Stream::start(driver, self.memory, &mut self.slots) {
            Ok(stream) => {
                self.silence.start(now_ns);
                if !self.has_shown {
                    self.told.news(&self.how(&stream));
                }
                self.state = State::Streaming(stream);
                return Ok(());
            }
            Err(failed) => failed,
        };
        let NotStarted {
            call,
            errno,
            driver,
        } = failed;
        if self.memory == Memory::Lent && self.may_map && !self.has_shown {
            // The driver accepts only its own memory, or does not accept memory of this kind.
            self.memory = Memory::Mapped;
        } else if !self.has_shown {
            return Err(self.port.refusal(call, errno).into());
        } else {
            self.recovery.failed(now_ns);
            if self.recovery.failures() == FAILURES_BEFORE_REOPENING {
                self.told.warn(&format!(
                    "it cannot be started ({call}: {errno}); it is reopened"
                ));
            }
        }
        self.state = match driver {
            Some(driver) if self.recovery.failures() < FAILURES_BEFORE_REOPENING => {
                State::Stopped(driver)
            }
            _ => State::Gone,
        };
        Ok(())
    }

    fn reopen(&mut self, now_ns: u64) {
        match self.port.reopen() {
            Ok((driver, but)) => {
                self.told.news("it is there again");
                if let Some(but) = but {
                    self.told.warn(&but);
                }
                self.state = State::Stopped(driver);
            }
            Err(error) => {
                self.recovery.failed(now_ns);
                // Reported once, because the error may suggest a remedy, for example if another
                // program uses the camera.
                if !matches!(error, CameraError::Absent { .. } | CameraError::Gone { .. })
                    && self.recovery.failures() == FAILURES_BEFORE_REOPENING
                {
                    self.told.warnings.push_back(error.to_string());
                }
            }
        }
    }

    /// Describes how frames are transferred, as a sentence.
    fn how(&self, stream: &Stream<P::Driver>) -> String {
        let Shape { stride, .. } = self.shape;
        let rows = match self.shape.encoding {
            Encoding::Plain(_) => format!("rows of {stride} bytes"),
            Encoding::Jpeg => "each frame decoded".to_owned(),
        };
        let count = stream.count();
        match stream.memory() {
            Memory::Lent => format!(
                "{rows}, straight into shared memory (USERPTR, {} slots)",
                SLOTS.min(count)
            ),
            Memory::Mapped => format!("{rows}, by one copy (MMAP, {count} buffers)"),
        }
    }
}
