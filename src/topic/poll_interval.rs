//! How long a reader that is not woken may be away before it looks again.

use std::time::Duration;

/// Below this a poll_interval is mostly the waking up: such a channel is read at the price of some losses, which are said.
const SHORTEST: Duration = Duration::from_micros(250);
/// Twenty looks a second cost nothing, and a slow channel need not wait longer.
const LONGEST: Duration = Duration::from_millis(50);
/// So that a fast channel does not overflow before its pace is known.
const FIRST: Duration = Duration::from_millis(1);

/// A poll_interval whose length follows the channel: a buffer should be a quarter full when it ends, so that one that lasts four
/// times too long loses nothing.
#[derive(Debug)]
pub(super) struct PollInterval {
    /// Messages that may wait.
    buffer: usize,
    length: Duration,
}

impl PollInterval {
    /// For a channel on which so many messages may wait.
    pub(super) fn new(buffer: usize) -> Self {
        Self {
            buffer,
            length: FIRST,
        }
    }

    /// So many messages had come when the last poll_interval ended. Returns how long the next one may be.
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

    /// The messages that overflow a buffer in the second that follows the first, and polls in it.
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
