//! What the far side asks, and what it is answered: the time, how much was sent, and what it wants.

use crate::args::Also;
use crate::datagram::Kind;

/// Of the far side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Question {
    /// A random number, which comes back: an answer to it was made after it was asked.
    pub(crate) token: u64,
    /// A bit each: what is wanted beside descriptors.
    pub(crate) also: u8,
    /// How long it is to be from one frame to the next, ms; 0: none are wanted.
    pub(crate) frames_ms: u16,
}

/// Of the near side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Answer {
    /// The question's.
    pub(crate) token: u64,
    /// When it was heard, and when it was answered, on the near side's clock.
    pub(crate) got_ns: u64,
    pub(crate) answered_ns: u64,
    /// How many [messages](Kind::COUNTED) of each channel have been sent.
    pub(crate) sent: [u64; Kind::COUNTED.len()],
}

/// The bit of a channel.
pub(crate) fn bit(also: Also) -> u8 {
    1 << also as u8
}

impl Question {
    pub(crate) fn write(&self, to: &mut Vec<u8>) {
        to.extend(self.token.to_le_bytes());
        to.push(self.also);
        to.extend(self.frames_ms.to_le_bytes());
    }

    pub(crate) fn read(bytes: &[u8]) -> Option<Self> {
        let (token, rest) = bytes.split_first_chunk()?;
        let [also, period @ ..]: [u8; 3] = rest.try_into().ok()?;
        Some(Self {
            token: u64::from_le_bytes(*token),
            also,
            frames_ms: u16::from_le_bytes(period),
        })
    }
}

impl Answer {
    pub(crate) fn write(&self, to: &mut Vec<u8>) {
        let numbers = [self.token, self.got_ns, self.answered_ns];
        for number in numbers.iter().chain(&self.sent) {
            to.extend(number.to_le_bytes());
        }
    }

    pub(crate) fn read(bytes: &[u8]) -> Option<Self> {
        let (numbers, []) = bytes.as_chunks::<8>() else {
            return None;
        };
        let numbers: [_; 7] = numbers.try_into().ok()?;
        let [token, got_ns, answered_ns, sent @ ..] = numbers.map(u64::from_le_bytes);
        Some(Self {
            token,
            got_ns,
            answered_ns,
            sent,
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
            also: bit(Also::Truth),
            frames_ms: 40,
        };
        let answer = Answer {
            token: 1,
            got_ns: 2,
            answered_ns: 3,
            sent: [4, 5, 6, u64::MAX],
        };
        let [mut asked, mut answered] = [Vec::new(), Vec::new()];
        question.write(&mut asked);
        answer.write(&mut answered);
        assert_eq!(
            (Question::read(&asked), Answer::read(&answered)),
            (Some(question), Some(answer))
        );
        for length in 0..60 {
            let bytes = vec![0; length];
            assert_eq!(Question::read(&bytes).is_some(), length == asked.len());
            assert_eq!(Answer::read(&bytes).is_some(), length == answered.len());
        }
    }
}
