//! The state of the link to the other side: its process, its clock, what it sent, and how much of
//! that arrived. Pure: the caller passes the times.

use std::collections::VecDeque;

use crate::args::Place;
use crate::clock::{Clock, Offset, RoundTrip};
use crate::datagram::{Datagram, Kind};
use crate::question::Answer;
use crate::tally::Tally;

use super::SILENCE_NS;

/// Maximum number of unanswered questions: those of 1.6 s.
const ASKED: usize = 32;

/// Result of handling an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Took {
    Yes,
    /// The answer was not accepted: it belongs to no open question, or another process sent it.
    No,
    /// The answer was accepted, but another process has answered, too.
    Both,
}

/// The process at the other end.
#[derive(Debug)]
struct Near {
    process: u64,
    clock: Clock,
    answered_ns: u64,
    tallies: [Tally; Kind::COUNTED.len()],
}

/// Number of messages sent and received on each channel.
type Totals = [[u64; 2]; Kind::COUNTED.len()];

/// The link to the other side.
#[derive(Debug, Default)]
pub(super) struct Link {
    /// Unanswered questions and their times, the oldest first.
    asked: VecDeque<(u64, u64)>,
    near: Option<Near>,
    /// True if another process has answered since the current one last did. `has_told` is true if
    /// that was reported.
    is_rivalled: bool,
    has_told: bool,
    /// Totals of earlier processes.
    before: Totals,
}

impl Link {
    /// Records a question that leaves.
    pub(super) fn ask(&mut self, token: u64, now_ns: u64) {
        if self.asked.len() == ASKED {
            self.asked.pop_front();
        }
        self.asked.push_back((token, now_ns));
    }

    /// Handles an answer that arrived at `heard`, on this clock.
    pub(super) fn answer(&mut self, process: u64, answer: &Answer, heard: u64) -> Took {
        let Some(at) = self
            .asked
            .iter()
            .position(|(token, _)| *token == answer.token)
        else {
            return Took::No;
        };
        let (_, asked) = self.asked[at];
        // Later answers to earlier questions are ignored: they were overtaken.
        self.asked.drain(..=at);
        let lives = |near: &Near| heard.saturating_sub(near.answered_ns) < SILENCE_NS / 2;
        match &self.near {
            Some(near) if near.process == process => {}
            Some(near) if lives(near) => {
                self.is_rivalled = true;
                return Took::No;
            }
            _ => self.change(process, heard),
        }
        let Some(near) = &mut self.near else {
            return Took::No;
        };
        near.answered_ns = heard;
        near.clock.add(RoundTrip {
            asked,
            got: answer.got_ns,
            sent: answer.answered_ns,
            heard,
        });
        // Messages sent before the near side received a question from this side were for others.
        let told = if answer.is_heard {
            &answer.sent[..]
        } else {
            &[]
        };
        for (tally, sent) in near.tallies.iter_mut().zip(told) {
            tally.tell(*sent);
        }
        if std::mem::take(&mut self.is_rivalled) && !std::mem::replace(&mut self.has_told, true) {
            return Took::Both;
        }
        Took::Yes
    }

    /// Switches to another process.
    fn change(&mut self, process: u64, now_ns: u64) {
        self.before = self.totals();
        self.is_rivalled = false;
        self.near = Some(Near {
            process,
            clock: Clock::default(),
            answered_ns: now_ns,
            tallies: Default::default(),
        });
    }

    /// Counts a datagram. Returns its sender's clock if the datagram is to be accepted: if it comes
    /// from the process that answers, and is newer than all datagrams before it.
    pub(super) fn receive(&mut self, datagram: &Datagram) -> Option<Offset> {
        let at = Kind::COUNTED
            .iter()
            .position(|kind| *kind == datagram.kind)?;
        let near = self
            .near
            .as_mut()
            .filter(|near| near.process == datagram.process)?;
        let offset = near.clock.offset()?;
        near.tallies[at].receive(datagram.count).then_some(offset)
    }

    /// Returns whether a datagram is from the process that answers.
    pub(super) fn is_of_near(&self, datagram: &Datagram) -> bool {
        let near = self.near.as_ref();
        near.is_some_and(|near| near.process == datagram.process)
    }

    /// Returns the process at the other end, and its clock.
    pub(super) fn near(&self) -> Option<(u64, Offset)> {
        let near = self.near.as_ref()?;
        Some((near.process, near.clock.offset()?))
    }

    /// Returns the totals since this bridge started.
    fn totals(&self) -> Totals {
        let mut totals = self.before;
        if let Some(near) = &self.near {
            for ([sent, received], tally) in totals.iter_mut().zip(&near.tallies) {
                *sent += tally.sent();
                *received += tally.received();
            }
        }
        totals
    }

    /// Returns the maximum error of timestamps, in µs.
    fn bound_us(&self, now_ns: u64) -> Option<f64> {
        Some(self.near()?.1.bound_ns(now_ns) * 1e-3)
    }

    /// Describes how many messages arrived or were lost, and how well the clock is known.
    pub(super) fn sentence(&self, now_ns: u64) -> String {
        let [[sent, received], ..] = self.totals();
        let clock = match self.bound_us(now_ns) {
            Some(bound_us) => format!("the clock is known to ± {bound_us:.0} µs"),
            None => "the clock is not known".into(),
        };
        format!(
            "sent {sent} = received {received} + lost {}; {clock}",
            sent - received
        )
    }

    /// Returns the same information as settings, for the roster.
    pub(super) fn settings(&self, place: &Place, now_ns: u64) -> String {
        let [[sent, received], ..] = self.totals();
        let bound_us = self.bound_us(now_ns).unwrap_or(f64::INFINITY);
        format!(
            "[bridge]\nconnect = \"{place}\"\nclock_bound_us = {bound_us:.1}\nsent = {sent}\nreceived = {received}\nlost = {}\n",
            sent - received
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const START: u64 = 1_000_000_000;

    fn answer(token: u64, at_ns: u64, sent: u64) -> Answer {
        Answer {
            token,
            got_ns: at_ns,
            answered_ns: at_ns,
            sent: [sent, 0, 0, 0],
            cookie: 1,
            is_heard: true,
        }
    }

    fn datagram(process: u64, count: u64) -> Datagram<'static> {
        Datagram {
            process,
            kind: Kind::Descriptors,
            count,
            says: &[],
        }
    }

    #[test]
    fn only_who_answers_our_own_questions_is_heard() {
        let mut link = Link::default();
        assert!(link.receive(&datagram(7, 1)).is_none());
        link.ask(55, START);
        // An answer that was recorded in another conversation.
        assert_eq!(link.answer(7, &answer(54, START, 0), START + 10), Took::No);
        assert!(link.receive(&datagram(7, 1)).is_none());
        assert_eq!(link.answer(7, &answer(55, START, 0), START + 10), Took::Yes);
        assert!(link.receive(&datagram(7, 1)).is_some());
        // No answer counts twice.
        assert_eq!(link.answer(7, &answer(55, START, 0), START + 10), Took::No);
        assert!(link.receive(&datagram(8, 2)).is_none());
        assert!(link.receive(&datagram(7, 1)).is_none());
    }

    #[test]
    fn another_process_takes_over_when_the_first_is_silent_and_counts_go_on() {
        let mut link = Link::default();
        link.ask(1, START);
        assert_eq!(link.answer(7, &answer(1, START, 0), START + 10), Took::Yes);
        for count in [1, 2, 4] {
            assert!(link.receive(&datagram(7, count)).is_some());
        }
        link.ask(2, START);
        assert_eq!(link.answer(8, &answer(2, START, 90), START + 20), Took::No);
        // Both are alive, which is reported once.
        for (token, told) in [(3, Took::Both), (5, Took::Yes)] {
            link.ask(token, START);
            assert_eq!(link.answer(7, &answer(token, START, 4), START + 25), told);
            link.ask(9, START);
            assert_eq!(link.answer(8, &answer(9, START, 90), START + 30), Took::No);
        }
        let later = START + 25 + SILENCE_NS;
        link.ask(4, later);
        assert_eq!(
            link.answer(8, &answer(4, START, 100), later + 10),
            Took::Yes
        );
        assert!(link.receive(&datagram(7, 5)).is_none());
        assert!(link.receive(&datagram(8, 102)).is_some());
        assert!(
            link.sentence(later)
                .starts_with("sent 6 = received 4 + lost 2; the clock is known to ± ")
        );
    }

    #[test]
    fn questions_are_forgotten() {
        let mut link = Link::default();
        for token in 0..=ASKED as u64 {
            link.ask(token, START + token);
        }
        assert_eq!(link.answer(7, &answer(0, START, 0), START + 100), Took::No);
        assert_eq!(link.answer(7, &answer(9, START, 0), START + 100), Took::Yes);
        assert_eq!(link.answer(7, &answer(8, START, 0), START + 100), Took::No);
    }
}
