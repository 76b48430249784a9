//! Poll schedule of a recorder.
//!
//! Only descriptors wake the recorder: once per frame, when the frame's work is done, so that it
//! never runs before a stage that still has work. Three frames have room to wait by then, and
//! usually one waits. A chain may be slow or have no fit stage. The recorder therefore also polls,
//! one and a half frame periods after its last poll and before the third frame comes. If
//! descriptors come with every frame, the next one always wakes the recorder first.

use std::time::Duration;

/// Longest poll interval: an idle rig costs two polls a second.
const AT_REST: Duration = Duration::from_millis(500);
/// Shortest poll interval. Polling does not keep up with a faster chain.
const SHORTEST: Duration = Duration::from_millis(1);

/// Estimates the frame period and schedules the next poll.
#[derive(Debug, Clone)]
pub(crate) struct Looks {
    /// Counter and capture time of the last frame.
    last: Option<(u64, u64)>,
    /// Frame period.
    period: Duration,
    /// Time until the next poll.
    wait: Duration,
}

impl Looks {
    pub(crate) fn new() -> Self {
        Self {
            last: None,
            period: AT_REST,
            wait: AT_REST,
        }
    }

    /// Registers a frame: capture's counter, and its capture time.
    pub(crate) fn frame(&mut self, captured: u64, captured_ns: u64) {
        if let Some((count, at_ns)) = self.last
            && captured > count
            && captured_ns > at_ns
        {
            self.period = Duration::from_nanos((captured_ns - at_ns) / (captured - count));
        }
        self.last = Some((captured, captured_ns));
    }

    /// Registers a poll. `came`: true if messages were waiting.
    pub(crate) fn looked(&mut self, came: bool) {
        self.wait = if came {
            (self.period * 3 / 2).clamp(SHORTEST, AT_REST)
        } else {
            // Nothing came, so the interval grows.
            (self.wait * 2).min(AT_REST)
        };
    }

    /// Time until the next poll if nothing wakes the recorder.
    pub(crate) fn wait(&self) -> Duration {
        self.wait
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    #[test]
    fn it_looks_before_more_frames_wait_than_there_is_room_for() {
        let mut looks = Looks::new();
        for count in 1..=3 {
            looks.frame(count, count * 16 * MS);
        }
        looks.looked(true);
        assert_eq!(looks.wait(), Duration::from_millis(24));
        // Frames that the recorder missed also count for the period.
        looks.frame(13, 13 * 16 * MS);
        looks.looked(true);
        assert_eq!(looks.wait(), Duration::from_millis(24));
    }

    #[test]
    fn a_rig_that_rests_is_looked_at_less_and_less() {
        let mut looks = Looks::new();
        assert_eq!(looks.wait(), AT_REST);
        looks.frame(1, MS);
        looks.frame(2, 11 * MS);
        looks.looked(true);
        for expected_ms in [30, 60, 120, 240, 480, 500, 500] {
            looks.looked(false);
            assert_eq!(looks.wait(), Duration::from_millis(expected_ms));
        }
    }

    #[test]
    fn a_capture_that_begins_again_is_no_pace() {
        let mut looks = Looks::new();
        looks.frame(100, 10 * MS);
        looks.frame(101, 20 * MS);
        looks.frame(1, 5000 * MS);
        looks.looked(true);
        assert_eq!(looks.wait(), Duration::from_millis(15));
    }
}
