//! What the sink is told: before the first frame, and after the last.

/// How the sink counts. The default: no period, no deadline, joined late.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Options {
    /// The time between two frames of the source, in nanoseconds, if it has a fixed one.
    pub period_ns: Option<u64>,
    /// How old a descriptor may be when the reader has it, in nanoseconds after the exposure. `None`: the period; without
    /// a period there is no deadline.
    pub deadline_ns: Option<u64>,
    /// Whether the sink was there before the first frame.
    ///
    /// `true`: every counter began at 1, and what is missing up to the first message was lost. `false`: the counting
    /// begins at the first message, which may be the newest of before the sink came (the service keeps one), so that it
    /// is received but says nothing about latency.
    pub from_start: bool,
}

impl Options {
    /// The deadline in force, in nanoseconds.
    pub fn deadline_ns(&self) -> Option<u64> {
        self.deadline_ns.or(self.period_ns)
    }
}

/// What each stage says it has sent in all, known when the chain has stopped. `None`: the stage did not live to say.
///
/// With it the frames that were under way when the chain stopped are lost too, on the link where they were: without a
/// stage's word, on the link before it, as far as later stages do not prove that it sent them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct FinalCounts {
    /// The source's number and capture's count before the first frame, if the frames are not the chain's own: whoever writes
    /// them may have begun long before.
    pub before_first: Option<[u64; 2]>,
    /// The source's last frame number, sent or not.
    pub last_sequence: Option<u64>,
    /// How many frames capture sent.
    pub captured: Option<u64>,
    /// How many frames extract sent.
    pub extracted: Option<u64>,
    /// How many frames fit sent.
    pub fitted: Option<u64>,
    /// How many frames extract skipped, as their masks, made by another process, came too late.
    pub masks_late: Option<u64>,
    /// How many frames fit had no depth image or second view for, if it reads those.
    pub depthless: Option<u64>,
    /// What capture says of its depth camera, if it has one.
    pub depths: Option<DepthCounts>,
}

/// What became of a depth camera's images.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct DepthCounts {
    /// How many it gave.
    pub images: u64,
    /// How many it numbered and did not give.
    pub lost: u64,
    /// How many of those it gave were no frame's.
    pub unpaired: u64,
}
