//! Measures how far the other machine's clock is ahead of this one's, by round trips. Pure: the
//! caller passes the times.
//!
//! A question leaves here at `asked`, arrives there at `got`, is answered there at `sent`, and the
//! answer arrives here at `heard`. Nothing arrives before it was sent, so with `θ` = there − here
//!
//! ```text
//! θ(asked) ≤ got − asked          θ(heard) ≥ sent − heard
//! ```
//!
//! for any delay in either direction. Over some seconds two clocks drift apart linearly,
//! `θ(t) = a + b t`, so each inequality is a half plane of `(a, b)`. Together they confine `θ(now)`
//! to an interval. Its middle is the estimate, and half its length is the bound (Zhang, Liu, Xia,
//! *Clock synchronization algorithms for network measurements*, INFOCOM 2002). The shortest round
//! trips determine the interval and the drift. A change of the drift itself loosens each constraint
//! by `½ w age²` ([`WANDER`]).
//!
//! The bound holds for any delay. The estimate is right if both directions take equally long. If
//! one is slower, the estimate is off by half the difference, within the bound.

/// Maximum drift in ns per second: two crystals of 100 ppm each, and a clock that is slewed by
/// 500 ppm.
const DRIFT: f64 = 700e3;
/// Maximum change of the drift per second, in ns per second: 1 ppm per second, a crystal that warms
/// by several degrees per second.
const WANDER: f64 = 1e3;
/// Length of a time span. Only the shortest round trip in each span is kept.
const BUCKET_NS: u64 = 250_000_000;
/// Number of round trips that are kept: those of 8 s.
const KEPT: usize = 32;
/// Number of steps that narrow an interval of drifts to less than 1 ns per second.
const HALVINGS: usize = 40;

/// A question and its answer, in nanoseconds of the two clocks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct RoundTrip {
    /// When the question left, on this clock.
    pub(crate) asked: u64,
    /// When the question arrived, on the other clock.
    pub(crate) got: u64,
    /// When the answer left, on the other clock.
    pub(crate) sent: u64,
    /// When the answer arrived, on this clock.
    pub(crate) heard: u64,
}

impl RoundTrip {
    /// Returns the time in transit, both ways; `None` if no clocks can have shown these times.
    fn way_ns(&self) -> Option<u64> {
        let here = self.heard.checked_sub(self.asked)?;
        here.checked_sub(self.sent.checked_sub(self.got)?)
    }
}

/// The other clock's lead and drift, as far as they are known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Offset {
    /// Time on this clock for which `from_to` holds.
    at: u64,
    /// Minimum and maximum lead of the other clock at that time, in ns.
    from_to: [f64; 2],
    /// Minimum and maximum drift of the other clock, in ns per second.
    drift: [f64; 2],
}

impl Offset {
    /// Returns the lead of the other clock at a time on this one, in ns.
    fn ahead(&self, here: u64) -> f64 {
        middle(self.from_to) + middle(self.drift) * seconds(self.at, here)
    }

    /// Returns the maximum error of timestamps at a time on this clock, in ns.
    pub(crate) fn bound_ns(&self, here: u64) -> f64 {
        let away = seconds(self.at, here).abs();
        half(self.from_to) + half(self.drift) * away + 0.5 * WANDER * away * away
    }

    /// Returns what this clock showed when the other one showed `there`.
    pub(crate) fn here(&self, there: u64) -> u64 {
        // The first step uses the offset at a nearby time, the second that at the time found. A
        // drift of 700 ppm leaves an error of its square.
        let first = shifted(there, -middle(self.from_to));
        shifted(there, -self.ahead(first))
    }

    /// Returns what the other clock shows when this one shows `here`.
    pub(crate) fn there(&self, here: u64) -> u64 {
        shifted(here, self.ahead(here))
    }
}

/// The last round trips, and the offset that they determine.
#[derive(Debug, Default)]
pub(crate) struct Clock {
    /// The shortest round trip of each span of time, the oldest first.
    kept: Vec<RoundTrip>,
    offset: Option<Offset>,
}

impl Clock {
    /// Returns the offset; `None` before the first round trip.
    pub(crate) fn offset(&self) -> Option<Offset> {
        self.offset
    }

    /// Adds a round trip. Impossible ones are ignored.
    pub(crate) fn add(&mut self, trip: RoundTrip) {
        let Some(way_ns) = trip.way_ns() else {
            return;
        };
        self.kept.push(trip);
        // If no line fits, a clock was set or a machine slept. Then only the newest round trips
        // count.
        self.offset = self.solve(trip.heard);
        while self.offset.is_none() && self.kept.len() > 1 {
            self.kept.remove(0);
            self.offset = self.solve(trip.heard);
        }
        // Keep the shortest round trip of each span.
        if let [.., last, _] = self.kept[..]
            && last.heard / BUCKET_NS == trip.heard / BUCKET_NS
        {
            let is_less = last.way_ns().is_some_and(|least| way_ns < least);
            self.kept
                .remove(self.kept.len() - if is_less { 2 } else { 1 });
        }
        if self.kept.len() > KEPT {
            self.kept.remove(0);
        }
    }

    /// Returns the offset at a time, as far as the kept round trips determine it; `None` if they
    /// contradict each other.
    fn solve(&self, now: u64) -> Option<Offset> {
        let base = *self.kept.last()?;
        // A difference between the two clocks may have any size, but two such differences are
        // nearly equal.
        let ahead = |there: u64, here: u64| i128::from(there) - i128::from(here);
        let zero = ahead(base.got, base.asked);
        let line = |there: u64, here: u64, slack: f64| {
            let age = seconds(now, here);
            let value = (ahead(there, here) - zero) as f64;
            (age, value + slack * (0.5 * WANDER * age * age))
        };
        let upper = |drift: f64| {
            let lines = self.kept.iter().map(|trip| line(trip.got, trip.asked, 1.0));
            lines.fold(f64::INFINITY, |least, (age, value)| {
                least.min(value - drift * age)
            })
        };
        let lower = |drift: f64| {
            let lines = self
                .kept
                .iter()
                .map(|trip| line(trip.sent, trip.heard, -1.0));
            lines.fold(f64::NEG_INFINITY, |most, (age, value)| {
                most.max(value - drift * age)
            })
        };
        // It is concave, because `upper` and the negative of `lower` are minima of lines.
        let room = |drift: f64| upper(drift) - lower(drift);
        let whole = [-DRIFT, DRIFT];
        let best = argmax(room, whole);
        if room(best) < 0.0 {
            return None;
        }
        let drift = [edge(room, best, -DRIFT), edge(room, best, DRIFT)];
        let from = lower(argmax(|drift| -lower(drift), drift));
        let to = upper(argmax(upper, drift));
        Some(Offset {
            at: now,
            from_to: [from + zero as f64, to + zero as f64],
            drift,
        })
    }
}

/// Returns where a concave function is largest.
fn argmax(f: impl Fn(f64) -> f64, [mut from, mut to]: [f64; 2]) -> f64 {
    for _ in 0..HALVINGS {
        let third = (to - from) / 3.0;
        let [left, right] = [from + third, to - third];
        if f(left) < f(right) {
            from = left;
        } else {
            to = right;
        }
    }
    0.5 * (from + to)
}

/// Returns how far from `inside` toward `end` a concave function stays nonnegative.
fn edge(f: impl Fn(f64) -> f64, inside: f64, end: f64) -> f64 {
    if f(end) >= 0.0 {
        return end;
    }
    let (mut inside, mut outside) = (inside, end);
    for _ in 0..HALVINGS {
        let between = 0.5 * (inside + outside);
        if f(between) >= 0.0 {
            inside = between;
        } else {
            outside = between;
        }
    }
    // Return the outer end, so that the interval contains the true drift.
    outside
}

fn middle([from, to]: [f64; 2]) -> f64 {
    0.5 * (from + to)
}

fn half([from, to]: [f64; 2]) -> f64 {
    0.5 * (to - from).abs()
}

fn seconds(from: u64, to: u64) -> f64 {
    (i128::from(to) - i128::from(from)) as f64 * 1e-9
}

fn shifted(ns: u64, by_ns: f64) -> u64 {
    let shifted = i128::from(ns) + by_ns.round() as i128;
    u64::try_from(shifted.max(0)).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two machines, and the link between them.
    struct Simulated {
        now: u64,
        /// Lead of the other clock at 0, and its drift.
        ahead: i128,
        drift: f64,
        /// Minimum delay each way, and the maximum that is added to it.
        delay: [u64; 2],
        jitter: u64,
        random: u64,
    }

    impl Simulated {
        fn there(&self, here: u64) -> u64 {
            let drifted = (here as f64 * self.drift).round() as i128;
            u64::try_from(i128::from(here) + self.ahead + drifted).expect("a time")
        }

        fn random(&mut self, below: u64) -> u64 {
            self.random = self
                .random
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (self.random >> 33) % below.max(1)
        }

        fn round_trip(&mut self, clock: &mut Clock) {
            let asked = self.now;
            let out = self.delay[0] + self.random(self.jitter);
            let work = self.random(50_000);
            let back = self.delay[1] + self.random(self.jitter);
            self.now += 50_000_000;
            clock.add(RoundTrip {
                asked,
                got: self.there(asked + out),
                sent: self.there(asked + out + work),
                heard: asked + out + work + back,
            });
        }

        /// Returns the error of a timestamp that is taken now, and the bound.
        fn error(&self, clock: &Clock) -> (f64, f64) {
            let offset = clock.offset().expect("known");
            let here = offset.here(self.there(self.now));
            (seconds(self.now, here) * 1e9, offset.bound_ns(self.now))
        }
    }

    fn simulated(delay: [u64; 2], jitter: u64, drift: f64, seed: u64) -> Simulated {
        Simulated {
            now: 1_000_000_000,
            ahead: 86_400_000_000_000 * (1 + seed as i128),
            drift,
            delay,
            jitter,
            random: seed,
        }
    }

    #[test]
    fn stamps_are_right_to_the_stated_bound_whatever_delay_jitter_and_drift() {
        for seed in 0..3 {
            for (delay, jitter) in [
                ([100_000, 100_000], 50_000),
                ([50_000_000, 50_000_000], 10_000_000),
                ([50_000_000, 1_000_000], 10_000_000),
                ([0, 0], 2_000_000),
            ] {
                for drift in [0.0, 40e-6, -170e-6, 600e-6] {
                    let mut world = simulated(delay, jitter, drift, seed);
                    let mut clock = Clock::default();
                    for _ in 0..300 {
                        world.round_trip(&mut clock);
                        let (error, bound) = world.error(&clock);
                        assert!(
                            error.abs() <= bound + 1.0,
                            "{error} ± {bound}: {delay:?} {jitter} {drift}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn the_bound_is_that_of_the_least_round_trips_and_the_estimate_is_closer() {
        // Both directions take equally long: at least 0.1 ms, and up to 2 ms more.
        let mut world = simulated([100_000, 100_000], 2_000_000, 80e-6, 7);
        let mut clock = Clock::default();
        for _ in 0..400 {
            world.round_trip(&mut clock);
        }
        let (error, bound) = world.error(&clock);
        assert!(bound < 400_000.0, "{bound}");
        assert!(error.abs() < 150_000.0, "{error}");
        let offset = clock.offset().expect("known");
        // In ns per second.
        assert!(
            (middle(offset.drift) - 80e3).abs() <= half(offset.drift),
            "{offset:?}"
        );
        assert!(half(offset.drift) < 150e3, "{offset:?}");
    }

    #[test]
    fn the_bound_grows_while_nothing_is_heard() {
        let mut world = simulated([100_000, 100_000], 50_000, 80e-6, 3);
        let mut clock = Clock::default();
        for _ in 0..100 {
            world.round_trip(&mut clock);
        }
        let mut last = 0.0;
        for _ in 0..20 {
            world.now += 1_000_000_000;
            let (error, bound) = world.error(&clock);
            assert!(error.abs() <= bound && bound > last, "{error} ± {bound}");
            last = bound;
        }
    }

    #[test]
    fn a_clock_that_was_set_is_followed_at_once() {
        let mut world = simulated([100_000, 100_000], 50_000, 0.0, 5);
        let mut clock = Clock::default();
        for step in [0, 3_600_000_000_000, -7_200_000_000_000] {
            world.ahead += step;
            for _ in 0..50 {
                world.round_trip(&mut clock);
                let (error, bound) = world.error(&clock);
                assert!(error.abs() <= bound, "{error} ± {bound}");
            }
        }
    }

    #[test]
    fn what_no_clock_can_have_read_is_not_gone_by() {
        let mut clock = Clock::default();
        let trip = |asked, got, sent, heard| RoundTrip {
            asked,
            got,
            sent,
            heard,
        };
        clock.add(trip(100, 5, 4, 200));
        clock.add(trip(100, 5, 500, 200));
        clock.add(trip(200, 5, 6, 100));
        assert_eq!(clock.offset(), None);
        // Extreme timestamps must not panic.
        clock.add(trip(0, u64::MAX - 1, u64::MAX, 10));
        let offset = clock.offset().expect("known");
        assert_eq!((offset.here(0), offset.there(u64::MAX)), (0, u64::MAX));
    }

    #[test]
    fn there_and_back_is_here() {
        let mut world = simulated([300_000, 100_000], 50_000, -120e-6, 11);
        let mut clock = Clock::default();
        for _ in 0..100 {
            world.round_trip(&mut clock);
        }
        let offset = clock.offset().expect("known");
        assert!(offset.here(offset.there(world.now)).abs_diff(world.now) <= 2);
    }
}
