//! Detects that a camera has been silent for too long. The silence is reported once, and repeated
//! blank frames tell the readers of ropes that the image is missing.
//!
//! The limit is three periods. The period is the camera's own, or the last interval if that was
//! longer, as with longer exposure in the dark.

/// Number of periods without a frame that make a stall.
const STALL_PERIODS: u64 = 3;
/// Time that a camera may take to start.
const FIRST_FRAME_NS: u64 = 3_000_000_000;
/// Longest interval between two frames that counts as the camera's pace, unless the interval that
/// the camera reports is longer.
const LONGEST_PAUSE_NS: u64 = 500_000_000;
/// Period if the driver does not report it.
const UNTOLD_NS: u64 = 200_000_000;
/// Interval between blank frames: the age of lost ropes is known to a tenth of a second, at little
/// cost.
const BLANK_NS: u64 = 100_000_000;

/// Minimum time between reports about a camera that stalls repeatedly.
const REPORT_NS: u64 = 5_000_000_000;

/// Watches for missing frames.
#[derive(Debug)]
pub(super) struct Silence {
    nominal_ns: u64,
    period_ns: u64,
    /// When the last frame came, or the camera was started.
    since_ns: u64,
    /// True if this stream has shown a frame.
    has_begun: bool,
    /// When [`due`](Self::due) has a result next.
    next_ns: u64,
    /// True if this silence has led to a blank frame.
    is_told: bool,
    /// True if this silence was reported, here or elsewhere.
    is_reported: bool,
    /// When the next report is allowed.
    report_at_ns: u64,
}

/// The camera is silent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Silent {
    /// Time without a frame, if it is to be reported.
    pub(super) report_ns: Option<u64>,
}

impl Silence {
    /// `interval_ns`: the camera's interval between frames, if it reports one.
    pub(super) fn new(interval_ns: Option<u64>) -> Self {
        let nominal_ns = interval_ns.unwrap_or(UNTOLD_NS);
        Self {
            nominal_ns,
            period_ns: nominal_ns,
            since_ns: 0,
            has_begun: false,
            next_ns: u64::MAX,
            is_told: false,
            is_reported: false,
            report_at_ns: 0,
        }
    }

    /// Notes that the camera starts to stream.
    pub(super) fn start(&mut self, now_ns: u64) {
        self.has_begun = false;
        // A silence that continues keeps its schedule.
        if !self.is_told {
            self.since_ns = now_ns;
            self.next_ns = now_ns + self.patience_ns();
        }
    }

    /// Handles a new frame. Returns how long the camera was silent, if the silence was reported.
    pub(super) fn end(&mut self, now_ns: u64) -> Option<u64> {
        let pause_ns = now_ns.saturating_sub(self.since_ns);
        if self.has_begun {
            let longest_ns = LONGEST_PAUSE_NS.max(self.nominal_ns);
            self.period_ns = pause_ns.clamp(self.nominal_ns, longest_ns);
        }
        (self.since_ns, self.has_begun) = (now_ns, true);
        self.next_ns = now_ns + self.patience_ns();
        self.is_told = false;
        std::mem::take(&mut self.is_reported).then_some(pause_ns)
    }

    /// Notes that no frame can come, for a reason that is reported elsewhere. The next blank frame
    /// is due at once.
    pub(super) fn broken(&mut self, now_ns: u64) {
        (self.is_told, self.is_reported) = (true, true);
        self.next_ns = now_ns;
    }

    /// When to ask [`due`](Self::due) again.
    pub(super) fn next_ns(&self) -> u64 {
        self.next_ns
    }

    /// Returns whether a blank frame is due now, and what to report.
    pub(super) fn due(&mut self, now_ns: u64) -> Option<Silent> {
        if now_ns < self.next_ns {
            return None;
        }
        self.next_ns = now_ns + BLANK_NS;
        self.is_told = true;
        let reports = !self.is_reported && now_ns >= self.report_at_ns;
        if reports {
            self.is_reported = true;
            self.report_at_ns = now_ns + REPORT_NS;
        }
        Some(Silent {
            report_ns: reports.then(|| now_ns.saturating_sub(self.since_ns)),
        })
    }

    fn patience_ns(&self) -> u64 {
        let stall_ns = STALL_PERIODS * self.period_ns;
        if self.has_begun {
            stall_ns
        } else {
            stall_ns.max(FIRST_FRAME_NS)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    /// A camera with 25 frames per second whose last frame came at 1 s.
    fn streaming() -> Silence {
        let mut silence = Silence::new(Some(40 * MS));
        silence.start(0);
        assert_eq!(silence.end(960 * MS), None);
        assert_eq!(silence.end(1000 * MS), None);
        silence
    }

    #[test]
    fn a_stall_is_reported_once_after_three_periods_and_told_on_and_on() {
        let mut silence = streaming();
        assert_eq!(silence.next_ns(), 1120 * MS);
        assert_eq!(silence.due(1119 * MS), None);
        let report_ns = Some(120 * MS);
        assert_eq!(silence.due(1120 * MS), Some(Silent { report_ns }));
        assert_eq!(silence.due(1121 * MS), None);
        for beat in 1..20 {
            let now_ns = 1120 * MS + beat * BLANK_NS;
            assert_eq!(silence.next_ns(), now_ns);
            assert_eq!(silence.due(now_ns), Some(Silent { report_ns: None }));
        }
        assert_eq!(silence.end(5000 * MS), Some(4000 * MS));
        assert_eq!(silence.end(5040 * MS), None);
    }

    #[test]
    fn a_camera_that_slows_down_is_reported_once_and_one_that_stood_still_again() {
        let mut silence = streaming();
        assert!(silence.due(1120 * MS).is_some());
        assert_eq!(silence.end(1133 * MS), Some(133 * MS));
        assert_eq!(silence.next_ns(), (1133 + 3 * 133) * MS);
        assert_eq!(silence.end(9000 * MS), None);
        assert_eq!(silence.next_ns(), 9000 * MS + 3 * LONGEST_PAUSE_NS);
    }

    #[test]
    fn a_camera_that_stumbles_is_told_of_each_time_and_reported_now_and_then() {
        let mut silence = streaming();
        let (mut told, mut reported, mut ended) = (0, 0, 0);
        for stumble in 0..100 {
            let came_ns = (1000 + 200 * stumble) * MS;
            let silent = silence.due(came_ns + 130 * MS);
            told += u64::from(silent.is_some());
            reported += u64::from(silent.is_some_and(|silent| silent.report_ns.is_some()));
            ended += u64::from(silence.end(came_ns + 160 * MS).is_some());
            assert_eq!(silence.end(came_ns + 200 * MS), None);
        }
        // In 20 s.
        assert_eq!((told, reported, ended), (100, 4, 4));
    }

    #[test]
    fn a_start_takes_its_time() {
        let mut silence = Silence::new(Some(40 * MS));
        silence.start(0);
        assert_eq!(silence.due(2999 * MS), None);
        assert!(
            silence
                .due(3000 * MS)
                .is_some_and(|silent| silent.report_ns.is_some())
        );
    }

    #[test]
    fn a_camera_that_is_gone_is_told_of_at_once_and_not_reported_as_a_stall() {
        let mut silence = streaming();
        silence.broken(1010 * MS);
        assert_eq!(silence.due(1010 * MS), Some(Silent { report_ns: None }));
        // It streams again but yields no frame yet.
        silence.start(1050 * MS);
        assert_eq!(silence.due(1110 * MS), Some(Silent { report_ns: None }));
        assert_eq!(
            silence.end(1200 * MS),
            Some(200 * MS),
            "since the last frame"
        );
    }
}
