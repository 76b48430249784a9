//! Counters and times of a frame on its way through the chain.

#[cfg(feature = "transport")]
use iceoryx2::prelude::ZeroCopySend;

message! {
    /// Counters and times of one frame on its way through the chain. Every message carries it, and
    /// every stage adds its own.
    ///
    /// The counters show losses as differences between two consecutive messages. If `sequence`
    /// advanced by more than `captured`, the source lost the difference. If `captured` advanced by
    /// more than `extracted`, the difference was lost between capture and extract, and so forth.
    /// All times are nanoseconds of `CLOCK_MONOTONIC`, 0 before they are known.
    #[derive(Eq)]
    pub struct Trace = "lariat.Trace.v3" {
        /// Frame number of the source, from 1.
        sequence: u64 = 0 => number,
        /// Frames sent by capture, including this one.
        captured: u64 = 0 => number,
        /// Frames sent by extract, including this one.
        extracted: u64 = 0 => number,
        /// Frames sent by fit, including this one.
        fitted: u64 = 0 => number,
        /// Messages of this channel that a local bridge has written, including this one; 0 without
        /// a bridge, and for images.
        bridged: u64 = 0 => number,
        /// Exposure time: the driver's timestamp, or the due time of a file's frame.
        exposed_ns: u64 = 0 => number,
        /// End of capture, before sending.
        captured_ns: u64 = 0 => number,
        /// Start of extract.
        extract_started_ns: u64 = 0 => number,
        /// End of extract, before sending.
        extracted_ns: u64 = 0 => number,
        /// Start of fit.
        fit_started_ns: u64 = 0 => number,
        /// End of fit, before sending.
        fitted_ns: u64 = 0 => number,
        /// Settings version of the sender: number of changes since the chain's start.
        settings: u32 = 0 => number,
        /// [Restarts](Self::restarts) of capture, extract and fit modulo 256, one byte each,
        /// capture in the lowest.
        restarts: u32 = 0 => number,
    }
}

impl Trace {
    /// Restarts of capture, extract and fit before they sent this, modulo 256.
    pub const fn restarts(&self) -> [u8; 3] {
        let [capture, extract, fit, _] = self.restarts.to_le_bytes();
        [capture, extract, fit]
    }

    /// Sets the restarts of a stage: capture is 0, extract 1, fit 2.
    pub const fn set_restarts(&mut self, stage: usize, restarts: u64) {
        let mut all = self.restarts.to_le_bytes();
        all[stage] = restarts as u8;
        self.restarts = u32::from_le_bytes(all);
    }
}
