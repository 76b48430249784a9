//! Schedules retries after a failure: at once, then after pauses that double.

/// The first pause.
const SHORTEST_NS: u64 = 50_000_000;
/// The longest pause.
const LONGEST_NS: u64 = 5_000_000_000;
/// Time without a failure after which the camera has recovered. A failure before that doubles the
/// pause again.
const WELL_NS: u64 = 2_000_000_000;

/// The pauses between retries.
#[derive(Debug, Default)]
pub(super) struct Recovery {
    /// When to retry.
    at_ns: u64,
    pause_ns: u64,
    failures: u32,
    failed_ns: u64,
}

impl Recovery {
    /// Reports success. If it lasts long enough, the next failure counts as the first again.
    pub(super) fn goes_well(&mut self, now_ns: u64) {
        if self.failures > 0 && now_ns.saturating_sub(self.failed_ns) >= WELL_NS {
            *self = Self::default();
        }
    }

    /// Reports a failure, and schedules the next retry.
    pub(super) fn failed(&mut self, now_ns: u64) {
        self.at_ns = now_ns + self.pause_ns;
        self.pause_ns = (2 * self.pause_ns).clamp(SHORTEST_NS, LONGEST_NS);
        self.failures = self.failures.saturating_add(1);
        self.failed_ns = now_ns;
    }

    /// Retries at once, because something has changed.
    pub(super) fn hurry(&mut self) {
        self.at_ns = 0;
    }

    /// When to retry.
    pub(super) fn at_ns(&self) -> u64 {
        self.at_ns
    }

    /// Number of consecutive failures.
    pub(super) fn failures(&self) -> u32 {
        self.failures
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_tried_at_once_and_then_ever_less_often() {
        let mut recovery = Recovery::default();
        let mut now_ns = 1_000;
        let mut pauses_ms = Vec::new();
        for _ in 0..10 {
            recovery.failed(now_ns);
            pauses_ms.push((recovery.at_ns() - now_ns) / 1_000_000);
            now_ns = recovery.at_ns();
        }
        assert_eq!(
            pauses_ms,
            [0, 50, 100, 200, 400, 800, 1600, 3200, 5000, 5000]
        );
        assert_eq!(recovery.failures(), 10);
        recovery.hurry();
        assert!(recovery.at_ns() <= now_ns);
        recovery.failed(now_ns);
        recovery.goes_well(now_ns + WELL_NS - 1);
        assert_eq!(recovery.failures(), 11, "it has failed a moment ago");
        recovery.goes_well(now_ns + WELL_NS);
        recovery.failed(now_ns);
        assert_eq!(recovery.at_ns(), now_ns);
    }
}
