//! Converts the clock of the traces to the time of day, which orders recordings.

use std::time::{SystemTime, UNIX_EPOCH};

use lariat_message::now_ns;

/// Offset from `CLOCK_MONOTONIC` to Unix time. It is fixed when a recording begins and stored in
/// it, so the conversion can be undone exactly. If the system time is set meanwhile, log times do
/// not jump.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Clock {
    /// The offset in nanoseconds.
    pub monotonic_to_wall_ns: i64,
}

impl Clock {
    /// Measures the current offset of the clocks.
    pub fn now() -> Self {
        let offset = || {
            let before = now_ns();
            let wall = SystemTime::now().duration_since(UNIX_EPOCH);
            let after = now_ns();
            let wall_ns = wall.map_or(0, |wall| wall.as_nanos() as i64);
            let monotonic_ns = before + (after - before) / 2;
            (after - before, wall_ns - monotonic_ns as i64)
        };
        // Uses the measurement that took the least time, because it was interrupted least.
        let best = (0..8).map(|_| offset()).min_by_key(|(took, _)| *took);
        Self {
            monotonic_to_wall_ns: best.map_or(0, |(_, offset)| offset),
        }
    }

    /// Converts a `CLOCK_MONOTONIC` time to Unix time.
    pub const fn wall_ns(self, monotonic_ns: u64) -> u64 {
        monotonic_ns.wrapping_add_signed(self.monotonic_to_wall_ns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_log_time_can_be_undone_to_the_bit() {
        let clock = Clock::now();
        let at_ns = now_ns();
        let log_ns = clock.wall_ns(at_ns);
        assert_eq!(
            log_ns.wrapping_add_signed(-clock.monotonic_to_wall_ns),
            at_ns
        );
        // After 2020: the time of day rather than the time since boot.
        assert!(log_ns > 1_577_836_800_000_000_000);
    }
}
