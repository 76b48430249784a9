//! Converts stamps to the clock of the rig, and keeps the original stamps for messages about the
//! same frames.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use lariat_record::Clock;

use super::Trouble;

/// A stamp ahead by no more than this is explained by reading the clocks one after the other.
const CLOCKS_APART_NS: u64 = 1_000_000;
/// Interval at which the clocks are compared again, because the wall clock is adjusted.
const MEASURED_FOR_NS: u64 = 1_000_000_000;
/// Number of frames whose stamps are stored: more than any chain processes at once.
const KNOWN: usize = 256;

/// Converts ROS stamps to times of `CLOCK_MONOTONIC`.
pub(crate) struct Stamps {
    clock: Clock,
    measured_ns: u64,
    by_arrival: bool,
}

impl Stamps {
    /// With `by_arrival`, stamps are ignored.
    pub(crate) fn new(by_arrival: bool) -> Self {
        Self {
            clock: Clock::now(),
            measured_ns: lariat_wire::now_ns(),
            by_arrival,
        }
    }

    /// Converts the stamp of a message that arrived at `now_ns`. The result is never later than
    /// `now_ns`. If it differs from the stamp, also returns the reason.
    ///
    /// # Errors
    /// The stamp is older than `oldest_ns`.
    pub(crate) fn moment(
        &mut self,
        stamp_ns: u64,
        now_ns: u64,
        oldest_ns: u64,
    ) -> Result<(u64, Option<Trouble>), Trouble> {
        if self.by_arrival {
            return Ok((now_ns, None));
        }
        if stamp_ns == 0 {
            return Ok((now_ns, Some(Trouble::NoStamp)));
        }
        if now_ns.saturating_sub(self.measured_ns) > MEASURED_FOR_NS {
            self.clock = Clock::now();
            self.measured_ns = now_ns;
        }
        let arrived_ns = self.clock.wall_ns(now_ns);
        match arrived_ns.checked_sub(stamp_ns) {
            // A time before the machine started is too old, whatever the limit.
            Some(age_ns) if age_ns <= oldest_ns => now_ns
                .checked_sub(age_ns)
                .map(|moment_ns| (moment_ns, None))
                .ok_or(Trouble::Old { age_ns }),
            Some(age_ns) => Err(Trouble::Old { age_ns }),
            None => {
                let ahead_ns = stamp_ns - arrived_ns;
                let trouble = (ahead_ns > CLOCKS_APART_NS).then_some(Trouble::Ahead { ahead_ns });
                Ok((now_ns, trouble))
            }
        }
    }
}

/// The original stamps of the newest frames, by exposure time. A message about the same frame
/// carries exactly the same stamp, as ROS's synchronizers require.
#[derive(Clone, Default)]
pub(crate) struct Originals(Arc<Mutex<VecDeque<[u64; 2]>>>);

impl Originals {
    pub(super) fn add(&self, exposed_ns: u64, stamp_ns: u64) {
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if known.len() == KNOWN {
            known.pop_front();
        }
        known.push_back([exposed_ns, stamp_ns]);
    }

    /// The stamp of the frame with this exposure time, if it came with one.
    pub(crate) fn of(&self, exposed_ns: u64) -> Option<u64> {
        let known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let mut newest_first = known.iter().rev();
        let found = newest_first.find(|[exposed, _]| *exposed == exposed_ns);
        found.map(|[_, stamp_ns]| *stamp_ns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: u64 = 1_000_000_000;

    fn stamps() -> Stamps {
        Stamps {
            clock: Clock {
                monotonic_to_wall_ns: 1_700_000_000 * S as i64,
            },
            measured_ns: 100 * S,
            by_arrival: false,
        }
    }

    #[test]
    fn a_stamp_is_the_moment_that_it_says_and_never_one_to_come() {
        let wall = |ns: u64| 1_700_000_000 * S + ns;
        let moment = |stamp_ns| stamps().moment(stamp_ns, 100 * S, 10 * S);
        assert_eq!(moment(wall(99 * S)), Ok((99 * S, None)));
        assert_eq!(moment(wall(100 * S + 1000)), Ok((100 * S, None)));
        let ahead_ns = S;
        assert_eq!(
            moment(wall(101 * S)),
            Ok((100 * S, Some(Trouble::Ahead { ahead_ns })))
        );
        assert_eq!(moment(0), Ok((100 * S, Some(Trouble::NoStamp))));
        assert_eq!(moment(wall(89 * S)), Err(Trouble::Old { age_ns: 11 * S }));
        // A simulated clock begins at 0.
        assert!(matches!(moment(5 * S), Err(Trouble::Old { .. })));
        let before_the_start = stamps().moment(wall(0) - 1, 100 * S, 1000 * S);
        assert!(matches!(before_the_start, Err(Trouble::Old { .. })));
        let mut by_arrival = stamps();
        by_arrival.by_arrival = true;
        assert_eq!(by_arrival.moment(5, 7, 0), Ok((7, None)));
    }

    #[test]
    fn the_stamp_of_a_frame_is_known_for_as_long_as_it_can_be_under_way() {
        let originals = Originals::default();
        (0..300).for_each(|i| originals.add(i, 1000 + i));
        assert_eq!(originals.of(299), Some(1299));
        assert_eq!(originals.of(44), Some(1044));
        assert_eq!(originals.of(43), None);
    }
}
