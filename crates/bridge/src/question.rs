//! The far side's questions and the near side's answers: the time, the number of messages sent, and
//! what the far side wants. Both have the same length, so nobody receives an answer longer than the
//! question.

use crate::args::Also;
use crate::datagram::Kind;

/// A question of the far side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Question {
    /// Random number that the answer repeats, which proves that the answer was made after the
    /// question.
    pub(crate) token: u64,
    /// Cookie of the last answer, which proves that the answer arrived; 0 before the first.
    pub(crate) cookie: u64,
    /// Channels wanted in addition to descriptors, one bit each.
    pub(crate) also: u8,
    /// Interval between wanted frames in ms; 0 if none are wanted.
    pub(crate) frames_ms: u16,
}

/// An answer of the near side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Answer {
    /// Token of the question.
    pub(crate) token: u64,
    /// Times when the question arrived and when it was answered, on the near side's clock.
    pub(crate) got_ns: u64,
    pub(crate) answered_ns: u64,
    /// Number of [messages](Kind::COUNTED) sent on each channel.
    pub(crate) sent: [u64; Kind::COUNTED.len()],
    /// Cookie that the next question has to repeat.
    pub(crate) cookie: u64,
    /// True if the cookie was right. From then on the asker receives all messages, too.
    pub(crate) is_heard: bool,
}

/// Length in bytes of a question or an answer.
const SIZE: usize = 8 * (4 + Kind::COUNTED.len()) + 1;

/// Returns the bit of a channel.
pub(crate) fn bit(also: Also) -> u8 {
    1 << also as u8
}

impl Question {
    pub(crate) fn write(&self, to: &mut Vec<u8>) {
        let end = to.len() + SIZE;
        to.extend(self.token.to_le_bytes());
        to.extend(self.cookie.to_le_bytes());
        to.push(self.also);
        to.extend(self.frames_ms.to_le_bytes());
        to.resize(end, 0);
    }

    pub(crate) fn read(bytes: &[u8]) -> Option<Self> {
        let bytes: &[u8; SIZE] = bytes.try_into().ok()?;
        let number = |at: usize| u64::from_le_bytes(std::array::from_fn(|i| bytes[at + i]));
        Some(Self {
            token: number(0),
            cookie: number(8),
            also: bytes[16],
            frames_ms: u16::from_le_bytes([bytes[17], bytes[18]]),
        })
    }
}

impl Answer {
    pub(crate) fn write(&self, to: &mut Vec<u8>) {
        let numbers = [self.token, self.got_ns, self.answered_ns, self.cookie];
        for number in numbers.iter().chain(&self.sent) {
            to.extend(number.to_le_bytes());
        }
        to.push(self.is_heard.into());
    }

    pub(crate) fn read(bytes: &[u8]) -> Option<Self> {
        let (numbers, &[is_heard @ (0 | 1)]) = bytes.as_chunks::<8>() else {
            return None;
        };
        let numbers: &[_; SIZE / 8] = numbers.try_into().ok()?;
        let [token, got_ns, answered_ns, cookie, sent @ ..] = numbers.map(u64::from_le_bytes);
        Some(Self {
            token,
            got_ns,
            answered_ns,
            sent,
            cookie,
            is_heard: is_heard == 1,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn questions_and_answers_come_back_and_nothing_else_is_one() {
        let question = Question {
            token: u64::MAX - 1,
            cookie: u64::MAX - 2,
            also: bit(Also::Truth),
            frames_ms: 40,
        };
        let answer = Answer {
            token: 1,
            got_ns: 2,
            answered_ns: 3,
            sent: [4, 5, 6, u64::MAX],
            cookie: 9,
            is_heard: true,
        };
        let [mut asked, mut answered] = [Vec::new(), Vec::new()];
        question.write(&mut asked);
        answer.write(&mut answered);
        assert_eq!(
            (Question::read(&asked), Answer::read(&answered)),
            (Some(question), Some(answer))
        );
        assert_eq!(asked.len(), answered.len());
        for length in 0..2 * SIZE {
            let bytes = vec![0; length];
            assert_eq!(Question::read(&bytes).is_some(), length == asked.len());
            assert_eq!(Answer::read(&bytes).is_some(), length == answered.len());
        }
    }
}
