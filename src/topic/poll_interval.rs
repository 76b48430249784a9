//! Poll interval of a reader that is not woken.

use std::time::Duration;

/// Shortest interval. A shorter one is mostly wake-up time, so a faster channel loses some
/// messages, which is reported.
const SHORTEST: Duration = Duration::from_micros(250);
/// Longest interval. Twenty polls a second cost nothing, so a longer interval has no benefit even
/// on a slow channel.
const LONGEST: Duration = Duration::from_millis(50);
/// First interval, short enough that a fast channel does not overflow before its rate is known.
const FIRST: Duration = Duration::from_millis(1);

/// Poll interval that follows the rate of the channel. The buffer should be a quarter full at each
/// poll, so that an interval four times too long still loses nothing.
#[derive(Debug)]
pub(super) struct PollInterval {
    /// Number of messages that can wait.
    buffer: usize,
    length: Duration,
}

impl PollInterval {
    /// Makes the interval of a channel on which this many messages can wait.
    pub(super) fn new(buffer: usize) -> Self {
        Self {
            buffer,
            length: FIRST,
        }
    }

    /// Takes the number of messages that came during the last interval. Returns the length of the
    /// next interval.
    pub(super) fn after(&mut self, came: usize) -> Duration {
        let length = if 2 * came > self.buffer {
            self.length / 2
        } else if 4 * came < self.buffer {
            self.length * 5 / 4
        } else {
            self.length
        };
        self.length = length.clamp(SHORTEST, LONGEST);
        self.length
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Counts the messages that overflow a buffer between 1 s and 2 s, and the polls in that
    /// second.
    fn lost(buffer: usize, per_s: f64) -> (usize, usize) {
        let (mut poll_interval, mut now_s, mut seen) = (PollInterval::new(buffer), 0.0, 0_usize);
        let (mut lost, mut polls, mut came) = (0, 0, 0);
        while now_s < 2.0 {
            let length = poll_interval.after(came);
            now_s += length.as_secs_f64();
            let sent = (now_s * per_s) as usize;
            came = (sent - seen).min(buffer);
            if now_s > 1.0 {
                lost += sent - seen - came;
                polls += 1;
            }
            seen = sent;
        }
        (lost, polls)
    }

    #[test]
    fn no_buffer_overflows_between_two_looks_and_a_slow_channel_is_left_alone() {
        for buffer in [3, 4, 8] {
            for per_s in [1.0, 30.0, 120.0, 1000.0, 2500.0] {
                let (lost, polls) = lost(buffer, per_s);
                assert_eq!(lost, 0, "{per_s}/s, {buffer} may wait");
                assert!(
                    polls as f64 <= 25.0 + 1.5 * per_s,
                    "{polls} polls at {per_s}/s"
                );
            }
        }
    }
}
