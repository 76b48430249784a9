//! When each frame of a source is due, and the header that it gets.

use crate::settings::{Capture, Fps};
use lariat_capture::{Frame, PaceError, Pacer};
use lariat_wire::{FrameHeader, SourceKind, Trace};

/// The moments of a source's frames: those at which they were exposed, its own pace, or the pace that is set.
pub struct Schedule {
    pacer: Pacer,
    /// Whether frames that have a pace of their own come at it.
    keeps_own_pace: bool,
    /// Whether each frame has its moment, however late it is.
    lossless: bool,
    /// Moments that passed without a frame, as the source was too slow.
    missed: u64,
}

impl Schedule {
    /// A schedule that begins with the first frame.
    ///
    /// # Errors
    /// The pace is zero or negative.
    pub fn new(settings: &Capture, lossless: bool) -> Result<Self, PaceError> {
        Ok(Self {
            pacer: Pacer::new(settings.pace())?,
            keeps_own_pace: settings.fps == Fps::Auto,
            lossless,
            missed: 0,
        })
    }

    /// When the next frame is due, which was ready at a moment of the same clock. `exposed_ns`: when it was exposed, if it was
    /// taken at a moment of its own; `after_ns`: how long after the first it is due at the source's own pace, if it has one.
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

    /// The number of a source's frame: a moment without one is a frame lost at the source.
    pub fn sequence(&self, frame: &Frame) -> u64 {
        frame.sequence + self.missed
    }
}

/// The header of a source's frame.
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
