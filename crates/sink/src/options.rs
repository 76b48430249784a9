//! Inputs of the sink besides messages: its options, and the final counts.

/// Options for counting. By default, period and deadline are unset, and the sink has joined late.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Options {
    /// Time between two frames of a source with a fixed rate, in nanoseconds.
    pub period_ns: Option<u64>,
    /// Maximum age of a descriptor when the reader receives it, in nanoseconds after the exposure.
    /// `None` means the period. Without a period, frames are never late.
    pub deadline_ns: Option<u64>,
    /// True if the sink was running before the first frame.
    ///
    /// Then every counter began at 1, and everything missing before the first message was lost. If
    /// false, counting begins at the first message. The service keeps the newest message, so the
    /// first one may be older than the sink. It counts as received, but says nothing about latency.
    pub from_start: bool,
}

impl Options {
    /// Returns the deadline in force, in nanoseconds.
    pub fn deadline_ns(&self) -> Option<u64> {
        self.deadline_ns.or(self.period_ns)
    }
}

/// Totals that each stage reports when the chain has stopped. `None` means that the stage did not
/// live to report.
///
/// With the totals, frames that were in progress when the chain stopped count as lost on the link
/// where they were. If a stage did not report, they count as lost on the link before it, unless
/// later stages prove that it sent them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct FinalCounts {
    /// The source's number and capture's count before the first frame, for frames from an external
    /// writer, which may have started long before the chain.
    pub before_first: Option<[u64; 2]>,
    /// The source's last frame number, sent or not.
    pub last_sequence: Option<u64>,
    /// Number of frames that capture sent.
    pub captured: Option<u64>,
    /// Number of frames that extract sent.
    pub extracted: Option<u64>,
    /// Number of frames that fit sent.
    pub fitted: Option<u64>,
    /// Number of frames that extract skipped because their external masks were late.
    pub masks_late: Option<u64>,
    /// Number of frames without a depth image or second view, if fit reads those.
    pub depthless: Option<u64>,
    /// Counts of the depth camera, if capture has one.
    pub depths: Option<DepthCounts>,
}

/// Counts of a depth camera's images.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct DepthCounts {
    /// Images that the camera delivered.
    pub images: u64,
    /// Images that the camera numbered but did not deliver.
    pub lost: u64,
    /// Delivered images that belonged to no frame.
    pub unpaired: u64,
}
