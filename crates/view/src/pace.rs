//! When the rig is looked at next: once a frame, when its way is over, without being woken.

use std::time::Duration;

use lariat_wire::Trace;

/// How long after the moment at which the last frame's fit says that the next one's should be done: later than it mostly is, so
/// that the look is not in its way.
const AFTER_NS: u64 = 2_000_000;
/// No screen shows more than this.
const SHORTEST_NS: u64 = 15_000_000;
/// Between two looks of a rig that rests.
const LONGEST_NS: u64 = 50_000_000;
/// A frame that is late is looked for again so soon.
const AGAIN_NS: u64 = 4_000_000;

/// The frames' pace, by what the traces say of it.
#[derive(Debug, Default)]
pub(crate) struct Pace {
    /// The last frame's counter, and when it was fitted.
    last: Option<(u64, u64)>,
    period_ns: u64,
    /// Looks since something came.
    misses: u32,
}

impl Pace {
    /// A look found this to be the newest.
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

    /// How long until the next look.
    pub(crate) fn wait(&self, now_ns: u64) -> Duration {
        let rest_ns = match self.last {
            None => LONGEST_NS,
            Some(_) if self.misses > 0 => (AGAIN_NS << self.misses.min(8)).min(LONGEST_NS),
            Some((_, at_ns)) => {
                let due_ns = at_ns + self.period_ns.min(LONGEST_NS) + AFTER_NS;
                // Of a chain faster than any screen every so many frames.
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
