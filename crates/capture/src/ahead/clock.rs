//! The time of frames that were timed when they were recorded, from one pass over them to the next.

/// The time of frames that have a time, on from one pass to the next.
#[derive(Debug, Default)]
pub(super) struct OwnClock {
    /// When the pass began.
    began_ns: u64,
    /// The last frame's time in its pass, and how many frames that had before.
    after_ns: u64,
    before: u64,
    /// When the frame is due, counted from the first of all.
    pub(super) due_ns: u64,
    has_begun: bool,
}

/// Between two frames where there is but one: the thirtieth of a second.
const ALONE_NS: u64 = 1_000_000_000 / 30;

impl OwnClock {
    /// Goes on to a frame so long after its pass's first.
    pub(super) fn advance(&mut self, after_ns: u64) {
        if self.has_begun && after_ns <= self.after_ns {
            // From the last frame to the first it is as long as between two.
            let interval_ns = self.after_ns.checked_div(self.before);
            let round_ns = self
                .after_ns
                .saturating_add(interval_ns.unwrap_or(ALONE_NS));
            self.began_ns = self.began_ns.saturating_add(round_ns);
            self.before = 0;
        } else if self.has_begun {
            self.before += 1;
        }
        self.has_begun = true;
        self.after_ns = after_ns;
        self.due_ns = self.began_ns.saturating_add(after_ns);
    }
}
