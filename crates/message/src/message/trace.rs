//! The way of a frame through the chain.

#[cfg(feature = "transport")]
use iceoryx2::prelude::ZeroCopySend;

message! {
    /// The way of one frame through the chain. Every message carries it; every stage adds its own lines.
    ///
    /// The counters make every loss a difference: of two consecutive messages, what `sequence` advanced more than
    /// `captured` was lost at the source, what `captured` advanced more than `extracted` between capture and extract, and
    /// so on. All times are nanoseconds of `CLOCK_MONOTONIC`, 0 before they are known.
    #[derive(Eq)]
    pub struct Trace = "lariat.Trace.v3" {
        /// The source's own frame number, from 1.
        sequence: u64 = 0 => number,
        /// How many frames capture has sent, this one included.
        captured: u64 = 0 => number,
        /// How many frames extract has sent, this one included.
        extracted: u64 = 0 => number,
        /// How many frames fit has sent, this one included.
        fitted: u64 = 0 => number,
        /// How many messages of this channel a bridge has written on this machine, this one included; 0 if it came over none, and
        /// for pictures.
        bridged: u64 = 0 => number,
        /// When the image was taken: the driver's timestamp, or the moment a file's frame was due.
        exposed_ns: u64 = 0 => number,
        /// When capture had the frame ready to send.
        captured_ns: u64 = 0 => number,
        /// When extract began.
        extract_started_ns: u64 = 0 => number,
        /// When extract had its result ready to send.
        extracted_ns: u64 = 0 => number,
        /// When fit began.
        fit_started_ns: u64 = 0 => number,
        /// When fit had its result ready to send.
        fitted_ns: u64 = 0 => number,
        /// By which settings the stage that sent this message went: 0 by those that its chain began with, one more for each
        /// change since.
        settings: u32 = 0 => number,
        /// Restarts of capture, extract and fit, modulo 256, one byte each from the lowest:
        /// [`restarts`](Self::restarts).
        restarts: u32 = 0 => number,
    }
}

impl Trace {
    /// Restarts of capture, extract and fit before they sent this, modulo 256.
    pub const fn restarts(&self) -> [u8; 3] {
        let [capture, extract, fit, _] = self.restarts.to_le_bytes();
        [capture, extract, fit]
    }

    /// Says how often a stage was restarted: capture is 0, extract 1, fit 2.
    pub const fn set_restarts(&mut self, stage: usize, restarts: u64) {
        let mut all = self.restarts.to_le_bytes();
        all[stage] = restarts as u8;
        self.restarts = u32::from_le_bytes(all);
    }
}
