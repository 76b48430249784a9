//! Detects that the error no longer falls. `J` may then be wrong in a way that the current motion
//! does not show, so the servo explores again.

use crate::options::Exploring;

/// Minimum share by which the error must fall to count as progress.
const PROGRESS: f64 = 0.05;

/// Minimum weight of elapsed time, even if the robot's limits leave a smaller share of the law's
/// wish. Without this minimum, a gripper that is stuck at a border would never count as stalled.
const LEAST_SHARE: f64 = 0.25;

/// The smallest error so far, and the time since it fell.
///
/// Time is weighted by the share of the law's wish that the robot's limits leave. A robot that
/// executes a tenth of the request takes ten times as long, even with a perfect `J`.
#[derive(Debug, Clone)]
pub(crate) struct Progress {
    best_px: f64,
    stalled_s: f64,
    last_ns: u64,
    patience_s: f64,
    left: u32,
}

impl Progress {
    pub(crate) fn new(exploring: &Exploring) -> Self {
        Self {
            best_px: f64::INFINITY,
            stalled_s: 0.0,
            last_ns: 0,
            patience_s: exploring.stalled_s,
            left: exploring.again,
        }
    }

    /// Resumes steering. Earlier time does not count.
    pub(crate) fn resume(&mut self, now_ns: u64) {
        self.stalled_s = 0.0;
        self.last_ns = now_ns;
    }

    /// Starts over: any error counts as progress.
    pub(crate) fn begin(&mut self, now_ns: u64) {
        self.best_px = f64::INFINITY;
        self.resume(now_ns);
    }

    /// Returns true if it is time to explore again, and uses up one exploration. `share` is the
    /// share of the law's wish that was executed since the last call.
    pub(crate) fn has_stalled(&mut self, error_px: f64, share: f64, now_ns: u64) -> bool {
        let since_s = now_ns.saturating_sub(self.last_ns) as f64 * 1e-9;
        self.stalled_s += share.clamp(LEAST_SHARE, 1.0) * since_s;
        self.last_ns = now_ns;
        if error_px < (1.0 - PROGRESS) * self.best_px {
            (self.best_px, self.stalled_s) = (error_px, 0.0);
        }
        let stalled = self.left > 0 && self.stalled_s > self.patience_s;
        if stalled {
            self.left -= 1;
            self.begin(now_ns);
        }
        stalled
    }
}
