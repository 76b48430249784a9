//! Whether the error still falls. Where it does not, `J` may be wrong in a way that no motion of now shows, and is looked for anew.

use crate::options::Exploring;

/// Falling by less than this share in all of the time is none.
const PROGRESS: f64 = 0.05;

/// The least error so far.
#[derive(Debug, Clone)]
pub(crate) struct Progress {
    best_px: f64,
    since_ns: u64,
    patience_ns: u64,
    left: u32,
}

impl Progress {
    pub(crate) fn new(exploring: &Exploring) -> Self {
        Self {
            best_px: f64::INFINITY,
            since_ns: 0,
            patience_ns: (exploring.stalled_s * 1e9) as u64,
            left: exploring.again,
        }
    }

    /// Steering goes on from here: time before does not count.
    pub(crate) fn resume(&mut self, now_ns: u64) {
        self.since_ns = now_ns;
    }

    /// Any error is progress from here on.
    pub(crate) fn begin(&mut self, now_ns: u64) {
        self.best_px = f64::INFINITY;
        self.since_ns = now_ns;
    }

    /// Whether it is time to explore anew; that often is then one less.
    pub(crate) fn has_stalled(&mut self, error_px: f64, now_ns: u64) -> bool {
        if error_px < (1.0 - PROGRESS) * self.best_px {
            (self.best_px, self.since_ns) = (error_px, now_ns);
        }
        let stalled = self.left > 0 && now_ns.saturating_sub(self.since_ns) > self.patience_ns;
        if stalled {
            self.left -= 1;
            self.begin(now_ns);
        }
        stalled
    }
}
