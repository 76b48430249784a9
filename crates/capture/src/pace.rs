//! Decides when each frame is due. Deadlines are absolute, so that delays neither add up nor stay
//! hidden.
//!
//! Frame k is due at start + k periods, whatever happened before it. Capture puts pixels and truth
//! into their slot *before* that moment, sleeps until it, then stamps and sends the frame.
//! `exposed_ns` is the moment when the frame was due, not when it was sent. A chain that falls
//! behind thus shows up as latency instead of slowing its own clock (coordinated omission).
//!
//! If the source is more than 0.1 s late, all missed moments except the newest are given up. They
//! count as frames lost at the source. Otherwise a source too slow for its pace would stay late for
//! good. With `--lossless`, no moment is given up. With `--fps max`, a frame is due when it is
//! ready.

use std::str::FromStr;

const NS_PER_S: u64 = 1_000_000_000;
/// A frame later than this is of no use to a control loop. Delays caused by a busy kernel, or by a
/// host that preempts the cores, are mostly shorter. The source catches up after such delays.
const TOO_LATE_NS: u64 = NS_PER_S / 10;

/// Rate at which frames come.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pace {
    /// This many frames per second.
    Fps(f64),
    /// Each frame is due as soon as the previous frame has been sent.
    Max,
}

/// An invalid pace.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{0}` is not a frame rate: give frames per second, more than 0 and at most 1000000, or `max`"
)]
pub struct PaceError(String);

impl Pace {
    /// The time between two frames in nanoseconds; `None` for [`Pace::Max`].
    fn period_ns(self) -> Result<Option<f64>, PaceError> {
        match self {
            Self::Max => Ok(None),
            Self::Fps(fps) if fps > 0.0 && fps <= 1e6 => Ok(Some(NS_PER_S as f64 / fps)),
            Self::Fps(fps) => Err(PaceError(fps.to_string())),
        }
    }
}

impl FromStr for Pace {
    type Err = PaceError;

    /// Parses a number, or `max`.
    fn from_str(text: &str) -> Result<Self, PaceError> {
        let error = || PaceError(text.to_owned());
        let pace = match text.trim() {
            "max" => Self::Max,
            number => Self::Fps(number.parse().map_err(|_| error())?),
        };
        pace.period_ns().map_err(|_| error())?;
        Ok(pace)
    }
}

/// The schedule of frames.
///
/// The k-th frame (from 0) is due k periods after the first, whatever happened to the frames before
/// it. A late frame keeps its due time, so that its lateness counts as latency (no coordinated
/// omission). No frame is skipped to catch up, except by [`give_up`](Self::give_up).
#[derive(Debug, Clone)]
pub struct Pacer {
    period_ns: Option<f64>,
    start_ns: Option<u64>,
    count: u64,
}

impl Pacer {
    /// Creates a schedule that begins at its first use.
    ///
    /// # Errors
    /// A rate that is not above 0, or above 1 000 000 frames per second.
    pub fn new(pace: Pace) -> Result<Self, PaceError> {
        Ok(Self {
            period_ns: pace.period_ns()?,
            start_ns: None,
            count: 0,
        })
    }

    /// If the next due time is more than 0.1 s in the past, skips all due times up to `now_ns`
    /// except the last. Returns the number of skipped due times. Without this, a source that falls
    /// behind once would stay late for good.
    pub fn give_up(&mut self, now_ns: u64) -> u64 {
        let (Some(start_ns), Some(period_ns)) = (self.start_ns, self.period_ns) else {
            return 0;
        };
        let passed_ns = now_ns.saturating_sub(start_ns) as f64;
        if passed_ns - self.count as f64 * period_ns <= TOO_LATE_NS as f64 {
            return 0;
        }
        let newest = (passed_ns / period_ns) as u64;
        let missed = newest.saturating_sub(self.count);
        self.count += missed;
        missed
    }

    /// Returns when the next frame is due, and advances by one frame. The first frame is due at
    /// `now_ns`; at [`Pace::Max`], every frame is.
    pub fn next_due_ns(&mut self, now_ns: u64) -> u64 {
        let start_ns = *self.start_ns.get_or_insert(now_ns);
        let due_ns = match self.period_ns {
            // Exact to a nanosecond for 2⁵³ ns, about a hundred days.
            Some(period_ns) => {
                start_ns.saturating_add((self.count as f64 * period_ns).round() as u64)
            }
            None => now_ns,
        };
        self.count += 1;
        due_ns
    }

    /// Does the same as [`next_due_ns`](Self::next_due_ns) for frames with a pace of their own: the
    /// next one is due `after_ns` after the first. If `may_give_up`, a frame more than 0.1 s late
    /// delays all later frames. Returns the due time, and the number of moments that were missed
    /// until then at the mean pace.
    pub fn own_due_ns(&mut self, now_ns: u64, after_ns: u64, may_give_up: bool) -> (u64, u64) {
        let start_ns = *self.start_ns.get_or_insert(now_ns.saturating_sub(after_ns));
        let due_ns = start_ns.saturating_add(after_ns);
        let late_ns = now_ns.saturating_sub(due_ns);
        let is_too_late = may_give_up && late_ns > TOO_LATE_NS;
        let mean_ns = after_ns.checked_div(self.count).unwrap_or(0).max(1);
        self.count += 1;
        if !is_too_late {
            return (due_ns, 0);
        }
        let missed = late_ns / mean_ns;
        // The newest of the past moments.
        let put_off_ns = missed * mean_ns;
        self.start_ns = Some(start_ns + put_off_ns);
        (due_ns + put_off_ns, missed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_late_frame_keeps_its_due_time_and_none_is_skipped() {
        let mut pacer = Pacer::new(Pace::Fps(100.0)).unwrap();
        let late = [5_000, 5_000, 95_000_000, 95_000_000, 95_000_000];
        let due: Vec<u64> = late.map(|now_ns| pacer.next_due_ns(now_ns)).to_vec();
        assert_eq!(due, [5_000, 10_005_000, 20_005_000, 30_005_000, 40_005_000]);
    }

    #[test]
    fn moments_missed_by_more_than_a_tenth_of_a_second_are_given_up() {
        let mut pacer = Pacer::new(Pace::Fps(100.0)).unwrap();
        assert_eq!(pacer.give_up(7), 0, "nothing is due before the first");
        assert_eq!(pacer.next_due_ns(0), 0);
        assert_eq!(pacer.give_up(110_000_000), 0, "just in time");
        assert_eq!(pacer.give_up(119_000_000), 10, "the moments 1 to 10");
        assert_eq!(pacer.next_due_ns(119_000_000), 110_000_000);
        assert_eq!(pacer.give_up(119_000_000), 0);
        assert_eq!(pacer.next_due_ns(119_000_000), 120_000_000);
    }

    #[test]
    fn a_slow_period_is_given_up_only_for_a_newer_moment() {
        let mut pacer = Pacer::new(Pace::Fps(2.0)).unwrap();
        pacer.next_due_ns(0);
        assert_eq!(pacer.give_up(900_000_000), 0, "late, but the newest");
        assert_eq!(pacer.next_due_ns(900_000_000), 500_000_000);
    }

    #[test]
    fn frames_with_a_pace_of_their_own_are_due_as_far_apart_as_they_were() {
        let mut pacer = Pacer::new(Pace::Fps(30.0)).unwrap();
        for (now_ns, after_ns, due_ns) in [(1000, 0, 1000), (1005, 7, 1007), (1100, 9, 1009)] {
            assert_eq!(pacer.own_due_ns(now_ns, after_ns, true), (due_ns, 0));
        }
        let second = NS_PER_S;
        let mut pacer = Pacer::new(Pace::Max).unwrap();
        assert_eq!(pacer.own_due_ns(0, 0, true), (0, 0));
        assert_eq!(pacer.own_due_ns(0, second / 10, true), (second / 10, 0));
        // 0.35 s late at a mean interval of 0.1 s.
        let late_ns = second / 5 + second * 35 / 100;
        assert_eq!(pacer.own_due_ns(late_ns, second / 5, true), (second / 2, 3));
        assert_eq!(
            pacer.own_due_ns(0, second * 3 / 10, true),
            (second * 6 / 10, 0)
        );
        assert_eq!(pacer.own_due_ns(9 * second, second * 4 / 10, false).1, 0);
    }

    #[test]
    fn at_max_nothing_is_given_up() {
        let mut pacer = Pacer::new(Pace::Max).unwrap();
        pacer.next_due_ns(0);
        assert_eq!(pacer.give_up(u64::MAX), 0);
    }

    #[test]
    fn rounding_never_adds_up() {
        let mut pacer = Pacer::new(Pace::Fps(30.0)).unwrap();
        let due_ns = (0..=30 * 3600).map(|_| pacer.next_due_ns(7)).last();
        assert_eq!(due_ns, Some(7 + 3600 * NS_PER_S));
    }

    #[test]
    fn at_max_a_frame_is_due_when_it_is_asked_for() {
        let mut pacer = Pacer::new(Pace::Max).unwrap();
        assert_eq!(
            [3, 9, 10].map(|now_ns| pacer.next_due_ns(now_ns)),
            [3, 9, 10]
        );
    }

    #[test]
    fn a_rate_that_is_none_is_refused() {
        assert_eq!("max".parse(), Ok(Pace::Max));
        assert_eq!("29.97".parse(), Ok(Pace::Fps(29.97)));
        for text in ["0", "-1", "nan", "inf", "fast", "", "1e9"] {
            let error = text.parse::<Pace>().unwrap_err();
            assert!(error.to_string().contains(&format!("`{text}`")), "{error}");
        }
        assert!(Pacer::new(Pace::Fps(f64::NAN)).is_err());
    }
}
