//! When a recorder looks for messages without being woken.
//!
//! It is woken by descriptors alone: one wake a frame, when the frame's work is done, so that it never runs before a stage
//! that still has to. By then three frames have room to wait, and mostly one does. But a chain may be slow, or have no
//! fit: so it looks by itself one and a half frame periods after it last looked, before the third frame comes. Where
//! descriptors come with every frame, the next one wakes it first, and it is never this that does.

use std::time::Duration;

/// The longest between two looks: a rig that rests costs two a second.
const AT_REST: Duration = Duration::from_millis(500);
/// The shortest: a chain faster than this is not waited for by looking.
const SHORTEST: Duration = Duration::from_millis(1);

/// What is known of the frames' pace.
#[derive(Debug, Clone)]
pub(crate) struct Looks {
    /// Counter and moment of the last frame.
    last: Option<(u64, u64)>,
    /// Between two frames.
    period: Duration,
    /// Until the next look.
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

    /// A frame came: capture's counter, and when it was captured.
    pub(crate) fn frame(&mut self, captured: u64, captured_ns: u64) {
        if let Some((count, at_ns)) = self.last
            && captured > count
            && captured_ns > at_ns
        {
            self.period = Duration::from_nanos((captured_ns - at_ns) / (captured - count));
        }
        self.last = Some((captured, captured_ns));
    }

    /// It has looked. `came`: there was something.
    pub(crate) fn looked(&mut self, came: bool) {
        self.wait = if came {
            (self.period * 3 / 2).clamp(SHORTEST, AT_REST)
        } else {
            // Nothing comes: less and less is expected.
            (self.wait * 2).min(AT_REST)
        };
    }

    /// How long until the next look, if nothing wakes it.
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
        // Frames that it did not get have come all the same.
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
