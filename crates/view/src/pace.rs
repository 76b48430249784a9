//! Decides when to poll the rig next: once per frame, after its last step, without being woken.

use std::time::Duration;

use lariat_wire::Trace;

/// Delay after the time when the next fit should be done, predicted from the last frame. It is
/// longer than most frames need, so that the poll does not interfere.
const AFTER_NS: u64 = 2_000_000;
/// Shortest interval between two polls; no screen shows more frames.
const SHORTEST_NS: u64 = 15_000_000;
/// Longest interval between two polls, for a rig that is idle.
const LONGEST_NS: u64 = 50_000_000;
/// Base of the delay before another poll for a late frame; the delay doubles with each miss.
const AGAIN_NS: u64 = 4_000_000;

/// The pace of frames, measured from their traces.
#[derive(Debug, Default)]
pub(crate) struct Pace {
    /// Counter of the last frame, and when it was fitted.
    last: Option<(u64, u64)>,
    period_ns: u64,
    /// Number of polls since something arrived.
    misses: u32,
}

impl Pace {
    /// Records that a poll found this trace to be the newest.
    pub(crate) fn saw(&mut self, trace: &Trace) {
        let now = (trace.fitted, trace.fitted_ns);
        if self.last == Some(now) {
            self.misses = self.misses.saturating_add(1);
            return;
        }
        if let Some((count, at_ns)) = self.last
            && now.0 > count
            && now.1 > at_ns
        {
            self.period_ns = (now.1 - at_ns) / (now.0 - count);
        }
        self.last = Some(now);
        self.misses = 0;
    }

    /// Returns the time until the next poll.
    pub(crate) fn wait(&self, now_ns: u64) -> Duration {
        let rest_ns = match self.last {
            None => LONGEST_NS,
            Some(_) if self.misses > 0 => (AGAIN_NS << self.misses.min(8)).min(LONGEST_NS),
            Some((_, at_ns)) => {
                let due_ns = at_ns + self.period_ns.min(LONGEST_NS) + AFTER_NS;
                // A chain that is faster than any screen is polled only every few frames.
                let least_ns = match self.period_ns {
                    ..SHORTEST_NS => SHORTEST_NS,
                    _ => AGAIN_NS,
                };
                due_ns.saturating_sub(now_ns).max(least_ns)
            }
        };
        Duration::from_nanos(rest_ns.min(LONGEST_NS + AFTER_NS))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    fn fitted(count: u64, at_ns: u64) -> Trace {
        Trace {
            fitted: count,
            fitted_ns: at_ns,
            ..Trace::EMPTY
        }
    }

    #[test]
    fn a_frame_is_looked_for_when_its_way_should_be_over() {
        let mut pace = Pace::default();
        pace.saw(&fitted(1, 100 * MS));
        pace.saw(&fitted(4, 199 * MS));
        assert_eq!(pace.wait(200 * MS), Duration::from_millis(33 + 2 - 1));
    }

    #[test]
    fn a_late_frame_is_looked_for_again_and_a_rig_that_rests_less_and_less() {
        let mut pace = Pace::default();
        pace.saw(&fitted(1, 100 * MS));
        let mut waits = Vec::new();
        for _ in 0..5 {
            pace.saw(&fitted(1, 100 * MS));
            waits.push(pace.wait(300 * MS).as_millis());
        }
        assert_eq!(waits, [8, 16, 32, 50, 50]);
    }

    #[test]
    fn a_chain_faster_than_a_screen_is_not_followed_frame_by_frame() {
        let mut pace = Pace::default();
        pace.saw(&fitted(1, 100 * MS));
        pace.saw(&fitted(100, 199 * MS));
        assert_eq!(pace.wait(199 * MS), Duration::from_millis(15));
    }
}
