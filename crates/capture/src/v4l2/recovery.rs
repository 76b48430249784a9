//! When to try again what has failed: at once, then after pauses that double.

/// The first pause.
const SHORTEST_NS: u64 = 50_000_000;
/// No pause is longer.
const LONGEST_NS: u64 = 5_000_000_000;
/// What goes well for so long after a failure has recovered; if it fails sooner, the pauses go on doubling.
const WELL_NS: u64 = 2_000_000_000;

/// The pauses between tries.
#[derive(Debug, Default)]
pub(super) struct Recovery {
    /// When to try next.
    at_ns: u64,
    pause_ns: u64,
    failures: u32,
    failed_ns: u64,
}

impl Recovery {
    /// It goes well: if it has for long enough, the next failure is the first again.
    pub(super) fn goes_well(&mut self, now_ns: u64) {
        if self.failures > 0 && now_ns.saturating_sub(self.failed_ns) >= WELL_NS {
            *self = Self::default();
        }
    }

    /// It has failed: when to try again.
    pub(super) fn failed(&mut self, now_ns: u64) {
        self.at_ns = now_ns + self.pause_ns;
        self.pause_ns = (2 * self.pause_ns).clamp(SHORTEST_NS, LONGEST_NS);
        self.failures = self.failures.saturating_add(1);
        self.failed_ns = now_ns;
    }

    /// Something has changed: it is tried at once.
    pub(super) fn hurry(&mut self) {
        self.at_ns = 0;
    }

    /// When to try.
    pub(super) fn at_ns(&self) -> u64 {
        self.at_ns
    }

    /// How often it has failed in a row.
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
