//! Converts a driver's frame numbers and times to what the interface promises: numbers that
//! increase from 1, and times in the past.

use super::sys;

/// A camera's frame numbers. The driver's have 32 bits and restart at 0 with each stream.
#[derive(Debug, Default)]
pub(super) struct Sequence {
    /// The driver's number of the last frame in this stream.
    driver: Option<u32>,
    last: u64,
}

impl Sequence {
    /// Returns a frame's number, which grows by the same step as the driver's. If the driver does
    /// not count, or counts from the start again, it grows by one.
    pub(super) fn of(&mut self, driver: u32) -> u64 {
        let step = match self.driver.replace(driver) {
            // Modulo 2³², so that a wrap is a step like any other; half of that or more is a step
            // back.
            Some(before) => driver.wrapping_sub(before),
            None => 1,
        };
        self.last += match step {
            0 | 0x8000_0000.. => 1,
            step => u64::from(step),
        };
        self.last
    }

    /// The number of a frame that does not come from the driver.
    pub(super) fn own(&mut self) -> u64 {
        self.last += 1;
        self.last
    }

    /// Notes that the driver starts to stream again. Its losses in between are unknown.
    pub(super) fn restart(&mut self) {
        self.driver = None;
    }
}

/// A frame's time as reported by a driver.
#[derive(Debug, Clone, Copy)]
pub(super) struct DriverTime {
    /// `V4L2_BUF_FLAG_*`.
    pub(super) flags: u32,
    pub(super) s: i64,
    pub(super) us: i64,
}

/// A fault in a driver's times. Each is reported once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Doubt {
    /// Its clock is not reported, or is not the monotonic one.
    Clock,
    /// It stamps the ends of frames, and the exposure time is unknown.
    Exposure,
    /// A time in the future.
    Future,
    /// A time long before the camera was started.
    Past,
}

impl Doubt {
    const COUNT: usize = 4;

    /// A sentence about the fault and its consequence.
    pub(super) fn sentence(self) -> &'static str {
        match self {
            Self::Clock => {
                "its driver does not say by which clock its timestamps are: frames are taken to be exposed when they \
                 arrive, which makes latencies shorter than they are"
            }
            Self::Exposure => {
                "its driver stamps the ends of frames, and neither exposure nor readout time are known: latencies count \
                 from the end of a frame, and are shorter than they are by these"
            }
            Self::Future => {
                "its driver stamps frames with moments that are still to come: such a frame is taken to be exposed when \
                 it arrives, which makes latencies shorter than they are"
            }
            Self::Past => {
                "its driver stamps frames with moments long before the camera was started: such a frame is taken to be \
                 exposed when it arrives, which makes latencies shorter than they are"
            }
        }
    }
}

/// Maximum time before the start of the stream at which an image may have been exposed. Some
/// cameras expose all the time.
const BEFORE_START_NS: i128 = 1_000_000_000;

/// Determines when frames were exposed.
#[derive(Debug, Default)]
pub(super) struct Stamper {
    started_ns: u64,
    /// Exposure time of frames, if known.
    pub(super) exposure_ns: Option<u64>,
    said: [bool; Doubt::COUNT],
    unsaid: [bool; Doubt::COUNT],
}

impl Stamper {
    /// Notes that the camera starts to stream now.
    pub(super) fn start(&mut self, now_ns: u64) {
        self.started_ns = now_ns;
    }

    /// Returns whether frames with these flags need the exposure time.
    pub(super) fn needs_exposure(flags: u32) -> bool {
        flags & sys::BUF_FLAG_TIMESTAMP_MASK == sys::BUF_FLAG_TIMESTAMP_MONOTONIC
            && flags & sys::BUF_FLAG_TSTAMP_SRC_MASK != sys::BUF_FLAG_TSTAMP_SRC_SOE
    }

    /// Returns when the frame dequeued at `dequeued_ns` was exposed: never later than that.
    pub(super) fn exposed_ns(&mut self, time: DriverTime, dequeued_ns: u64) -> u64 {
        if time.flags & sys::BUF_FLAG_TIMESTAMP_MASK != sys::BUF_FLAG_TIMESTAMP_MONOTONIC {
            self.doubt(Doubt::Clock);
            return dequeued_ns;
        }
        let stamped_ns = i128::from(time.s) * 1_000_000_000 + i128::from(time.us) * 1_000;
        // The stamp itself must not be in the future, so it is checked before the exposure time is
        // subtracted.
        let exposed_ns = if stamped_ns > i128::from(dequeued_ns) {
            self.doubt(Doubt::Future);
            i128::from(dequeued_ns)
        } else if stamped_ns < i128::from(self.started_ns) - BEFORE_START_NS {
            self.doubt(Doubt::Past);
            i128::from(dequeued_ns)
        } else {
            stamped_ns
        };
        let exposed_ns = u64::try_from(exposed_ns).unwrap_or(dequeued_ns);
        match (Self::needs_exposure(time.flags), self.exposure_ns) {
            (false, _) => exposed_ns,
            (true, Some(exposure_ns)) => exposed_ns.saturating_sub(exposure_ns),
            (true, None) => {
                self.doubt(Doubt::Exposure);
                exposed_ns
            }
        }
    }

    fn doubt(&mut self, doubt: Doubt) {
        let index = doubt as usize;
        self.unsaid[index] |= !self.said[index];
        self.said[index] = true;
    }

    /// Returns a fault that was not reported yet.
    pub(super) fn take_doubt(&mut self) -> Option<Doubt> {
        const ALL: [Doubt; Doubt::COUNT] =
            [Doubt::Clock, Doubt::Exposure, Doubt::Future, Doubt::Past];
        let index = self.unsaid.iter().position(|&unsaid| unsaid)?;
        self.unsaid[index] = false;
        Some(ALL[index])
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const START: u32 = sys::BUF_FLAG_TIMESTAMP_MONOTONIC | sys::BUF_FLAG_TSTAMP_SRC_SOE;
    const END: u32 = sys::BUF_FLAG_TIMESTAMP_MONOTONIC | sys::BUF_FLAG_TSTAMP_SRC_EOF;

    fn numbers(driver: &[u32]) -> Vec<u64> {
        let mut sequence = Sequence::default();
        driver.iter().map(|&number| sequence.of(number)).collect()
    }

    /// The exposure time for a stamp in microseconds. The camera started at 5 s, and the frame is
    /// dequeued at 15 s.
    fn exposed_ns(stamper: &mut Stamper, flags: u32, stamped_us: i64) -> u64 {
        stamper.start(5_000_000_000);
        let time = DriverTime {
            flags,
            s: stamped_us.div_euclid(1_000_000),
            us: stamped_us.rem_euclid(1_000_000),
        };
        stamper.exposed_ns(time, 15_000_000_000)
    }

    fn doubts(stamper: &mut Stamper) -> Vec<Doubt> {
        std::iter::from_fn(|| stamper.take_doubt()).collect()
    }

    #[test]
    fn numbers_are_from_1_and_gaps_stay_gaps() {
        assert_eq!(numbers(&[0, 1, 2, 5, 6]), [1, 2, 3, 6, 7]);
        assert_eq!(numbers(&[7, 8]), [1, 2]);
    }

    #[test]
    fn a_wrap_is_a_step_like_any_other() {
        let last = u32::MAX;
        assert_eq!(numbers(&[last - 1, last, 0, 3]), [1, 2, 3, 6]);
    }

    #[test]
    fn a_driver_that_does_not_count_or_begins_again_has_the_next_number() {
        assert_eq!(numbers(&[0, 0, 0]), [1, 2, 3]);
        assert_eq!(numbers(&[100, 101, 0, 1]), [1, 2, 3, 4]);
    }

    #[test]
    fn after_a_new_start_and_frames_of_its_own_it_goes_on() {
        let mut sequence = Sequence::default();
        assert_eq!([sequence.of(0), sequence.of(1)], [1, 2]);
        assert_eq!([sequence.own(), sequence.own()], [3, 4]);
        assert_eq!(sequence.of(4), 7, "two were lost in between");
        sequence.restart();
        assert_eq!([sequence.of(0), sequence.of(2)], [8, 10]);
    }

    #[test]
    fn the_start_of_exposure_is_taken_as_it_is() {
        let mut stamper = Stamper::default();
        assert_eq!(exposed_ns(&mut stamper, START, 14_990_000), 14_990_000_000);
        stamper.exposure_ns = Some(5_000_000);
        assert_eq!(exposed_ns(&mut stamper, START, 14_990_000), 14_990_000_000);
        assert_eq!(doubts(&mut stamper), []);
    }

    #[test]
    fn of_a_frames_end_the_exposure_is_taken_off_or_missed_once() {
        let mut stamper = Stamper::default();
        for _ in 0..3 {
            assert_eq!(exposed_ns(&mut stamper, END, 14_990_000), 14_990_000_000);
        }
        assert_eq!(doubts(&mut stamper), [Doubt::Exposure]);
        stamper.exposure_ns = Some(5_000_000);
        assert_eq!(exposed_ns(&mut stamper, END, 14_990_000), 14_985_000_000);
        assert_eq!(doubts(&mut stamper), []);
    }

    #[test]
    fn what_cannot_be_is_the_moment_of_arrival_and_said_once() {
        // Late, early, and as `vivid` wraps its clock: 2⁶³ ns, then a negative number of seconds.
        for (stamped_us, doubt) in [
            (15_000_001, Doubt::Future),
            (3_999_999, Doubt::Past),
            (9_223_372_020_890_000, Doubt::Future),
            (-9_223_372_036_000_000, Doubt::Past),
            (i64::MAX, Doubt::Future),
        ] {
            let mut stamper = Stamper::default();
            for _ in 0..3 {
                assert_eq!(
                    exposed_ns(&mut stamper, START, stamped_us),
                    15_000_000_000,
                    "{stamped_us}"
                );
            }
            assert_eq!(doubts(&mut stamper), [doubt], "{stamped_us}");
        }
    }

    #[test]
    fn a_clock_that_is_not_told_is_not_believed() {
        for flags in [0, sys::BUF_FLAG_TIMESTAMP_COPY] {
            let mut stamper = Stamper::default();
            assert_eq!(exposed_ns(&mut stamper, flags, 14_990_000), 15_000_000_000);
            assert_eq!(doubts(&mut stamper), [Doubt::Clock]);
        }
    }

    proptest! {
        #[test]
        fn numbers_grow_whatever_a_driver_says(driver in proptest::collection::vec(any::<u32>(), 1..50)) {
            let mut last = 0;
            for number in numbers(&driver) {
                prop_assert!(number > last);
                last = number;
            }
        }

        #[test]
        fn no_latency_is_negative_nor_longer_than_the_stream(
            s in any::<i64>(), us in any::<i64>(), flags in any::<u32>(),
            near in any::<bool>(), exposure_ns in proptest::option::of(0_u64..1_000_000_000),
        ) {
            let (started_ns, now_ns) = (50_000_000_000, 60_000_000_000);
            let mut stamper = Stamper { exposure_ns, ..Stamper::default() };
            stamper.start(started_ns);
            let (s, us) = if near { (s % 100, us % 1_000_000) } else { (s, us) };
            let exposed_ns = stamper.exposed_ns(DriverTime { flags, s, us }, now_ns);
            prop_assert!(exposed_ns <= now_ns);
            prop_assert!(exposed_ns >= started_ns - 2_000_000_000);
        }
    }
}
