//! Schedules the frames of a source and builds their headers.

use crate::settings::{Capture, Fps};
use lariat_capture::{Frame, PaceError, Pacer};
use lariat_wire::{FrameHeader, SourceKind, Trace};

/// The times at which a source's frames are due: their exposure times, the source's own pace, or
/// the pace in the settings.
pub struct Schedule {
    pacer: Pacer,
    /// True if frames follow the source's own pace, if it has one.
    keeps_own_pace: bool,
    /// True if no frame is skipped, however late it is.
    lossless: bool,
    /// Number of due times that passed without a frame because the source was too slow.
    missed: u64,
}

impl Schedule {
    /// Creates a schedule that begins with the first frame.
    ///
    /// # Errors
    /// Returns an error if the pace is zero or negative.
    pub fn new(settings: &Capture, lossless: bool) -> Result<Self, PaceError> {
        Ok(Self {
            pacer: Pacer::new(settings.pace())?,
            keeps_own_pace: settings.fps == Fps::Auto,
            lossless,
            missed: 0,
        })
    }

    /// Returns when the next frame is due. `ready_ns` is when it was ready, on the same clock.
    /// `exposed_ns` is its exposure time, if it has one. `after_ns` is its time after the first
    /// frame at the source's own pace, if the source has one.
    pub fn due_ns(&mut self, ready_ns: u64, exposed_ns: Option<u64>, after_ns: Option<u64>) -> u64 {
        if let Some(exposed_ns) = exposed_ns {
            return exposed_ns;
        }
        if let Some(after_ns) = after_ns.filter(|_| self.keeps_own_pace) {
            let (due_ns, missed) = self.pacer.own_due_ns(ready_ns, after_ns, !self.lossless);
            self.missed += missed;
            return due_ns;
        }
        if !self.lossless {
            self.missed += self.pacer.give_up(ready_ns);
        }
        self.pacer.next_due_ns(ready_ns)
    }

    /// Returns the number of a source's frame. A due time without a frame counts as a frame lost at
    /// the source.
    pub fn sequence(&self, frame: &Frame) -> u64 {
        frame.sequence + self.missed
    }
}

/// Returns the header of a source's frame.
pub fn frame_header(frame: &Frame, source: SourceKind, trace: Trace) -> FrameHeader {
    FrameHeader {
        trace,
        width: frame.width,
        height: frame.height,
        stride: frame.stride,
        pixel_format: frame.format as u32,
        source: source as u32,
        reserved: [0; 3],
    }
}
