//! Continuous time for recorded frames that are shown in several passes.

/// Continues the time of recorded frames from one pass to the next.
#[derive(Debug, Default)]
pub(super) struct OwnClock {
    /// When the pass began.
    began_ns: u64,
    /// Time of the last frame in its pass; `before` counts the frames before it.
    after_ns: u64,
    before: u64,
    /// When the current frame is due, relative to the first frame of the first pass.
    pub(super) due_ns: u64,
    has_begun: bool,
}

/// Interval after a pass of a single frame: a thirtieth of a second.
const ALONE_NS: u64 = 1_000_000_000 / 30;

impl OwnClock {
    /// Advances to the frame that comes `after_ns` after the first frame of its pass.
    pub(super) fn advance(&mut self, after_ns: u64) {
        if self.has_begun && after_ns <= self.after_ns {
            // The last frame is shown for the mean interval of its pass.
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
