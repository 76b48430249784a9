//! The far sides that receive messages. Each asks repeatedly, from an address that it has proved to
//! be its own. Pure: the caller passes the times.
//!
//! Anybody can write any address as a datagram's sender. So the answer to a question contains a
//! cookie, a number computed from the asker's address. The bridge sends more only to an asker that
//! repeats the cookie. The answer is as long as the question, so nobody can make the bridge flood a
//! third machine. Cookies are recomputed, not stored (HMAC-SHA-256 under a key of this process),
//! and are valid for one to two minutes.

use std::net::SocketAddr;

use anyhow::Result;
use ring::hmac;
use ring::rand::SystemRandom;

use crate::args::Also;
use crate::question::{Question, bit};

/// A far side that has asked nothing for this long is gone.
const ASKS_NS: u64 = 2_000_000_000;
/// Maximum number of far sides.
const MOST: usize = 16;
/// Interval at which cookies change. The previous cookie is still valid.
const COOKIE_NS: u64 = 60_000_000_000;

/// A far side.
#[derive(Debug)]
struct Peer {
    process: u64,
    at: SocketAddr,
    /// Its last question: its count, when it arrived, and what it wants.
    count: u64,
    asked_ns: u64,
    also: u8,
    frames_ms: u16,
}

/// Something that a far side may want.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Wants {
    /// Every far side wants these.
    Descriptors,
    Also(Also),
    Frames,
}

/// Content of an answer, in addition to the time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Told {
    /// Cookie for the next question.
    pub(crate) cookie: u64,
    /// True if the asker receives messages.
    pub(crate) is_heard: bool,
}

/// The far sides that receive messages.
pub(crate) struct Peers {
    key: hmac::Key,
    peers: Vec<Peer>,
}

impl Peers {
    /// # Errors
    /// Fails if the system provides no random numbers.
    pub(crate) fn new() -> Result<Self> {
        let key = hmac::Key::generate(hmac::HMAC_SHA256, &SystemRandom::new());
        let key = key.map_err(|_| anyhow::anyhow!("the system gives no random numbers"))?;
        Ok(Self {
            key,
            peers: Vec::with_capacity(MOST),
        })
    }

    fn cookie(&self, of: SocketAddr, age: u64) -> u64 {
        let tag = hmac::sign(&self.key, format!("{of} {age}").as_bytes());
        let bytes = tag
            .as_ref()
            .first_chunk()
            .expect("256 bits are more than 64");
        u64::from_le_bytes(*bytes)
    }

    /// Handles a process's `count`-th question; `None` if the question is outdated.
    pub(crate) fn ask(
        &mut self,
        (process, count): (u64, u64),
        question: &Question,
        from: SocketAddr,
        now_ns: u64,
    ) -> Option<Told> {
        self.peers.retain(|peer| peer.is_there(now_ns));
        let known = self.peers.iter().find(|peer| peer.process == process);
        if known.is_some_and(|peer| count <= peer.count) {
            return None;
        }
        let age = now_ns / COOKIE_NS;
        let cookie = self.cookie(from, age);
        let is_shown =
            question.cookie == cookie || age > 0 && question.cookie == self.cookie(from, age - 1);
        if is_shown {
            self.peers
                .retain(|peer| peer.process != process && peer.at != from);
        }
        let is_heard = is_shown && self.peers.len() < MOST;
        if is_heard {
            self.peers.push(Peer {
                process,
                at: from,
                count,
                asked_ns: now_ns,
                also: question.also,
                frames_ms: question.frames_ms,
            });
        }
        Some(Told { cookie, is_heard })
    }

    fn there(&self, now_ns: u64) -> impl Iterator<Item = &Peer> {
        self.peers.iter().filter(move |peer| peer.is_there(now_ns))
    }

    /// Returns the addresses of those that want something.
    pub(crate) fn addresses(&self, wants: Wants, now_ns: u64) -> impl Iterator<Item = SocketAddr> {
        self.there(now_ns)
            .filter(move |peer| peer.wants(wants))
            .map(|peer| peer.at)
    }

    /// Returns whether anybody wants something.
    pub(crate) fn want(&self, wants: Wants, now_ns: u64) -> bool {
        self.there(now_ns).any(|peer| peer.wants(wants))
    }

    /// Returns the channels that anybody wants in addition to descriptors, one bit each; `None` if
    /// nobody is there.
    pub(crate) fn also(&self, now_ns: u64) -> Option<u8> {
        self.there(now_ns)
            .map(|peer| peer.also)
            .reduce(|one, other| one | other)
    }

    /// Returns the shortest interval between frames that anybody wants; `None` if nobody wants any.
    pub(crate) fn frames_ns(&self, now_ns: u64) -> Option<u64> {
        let periods = self.there(now_ns).map(|peer| peer.frames_ms);
        let least_ms = periods.filter(|period_ms| *period_ms > 0).min()?;
        Some(u64::from(least_ms) * 1_000_000)
    }
}

impl Peer {
    fn is_there(&self, now_ns: u64) -> bool {
        now_ns.saturating_sub(self.asked_ns) < ASKS_NS
    }

    fn wants(&self, wants: Wants) -> bool {
        match wants {
            Wants::Descriptors => true,
            Wants::Also(also) => self.also & bit(also) != 0,
            Wants::Frames => self.frames_ms > 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const START: u64 = 1_000_000_000_000;

    fn at(port: u16) -> SocketAddr {
        ([10, 0, 0, 1], port).into()
    }

    fn asks(cookie: u64) -> Question {
        Question {
            token: 1,
            cookie,
            also: bit(Also::Truth),
            frames_ms: 40,
        }
    }

    /// Joins as a far side does: asks, then asks again with the cookie.
    fn join(peers: &mut Peers, process: u64, from: SocketAddr, now_ns: u64) -> Told {
        let told = peers.ask((process, 1), &asks(0), from, now_ns);
        let told = told.expect("its first question");
        assert!(!told.is_heard);
        peers
            .ask((process, 2), &asks(told.cookie), from, now_ns)
            .expect("its second")
    }

    fn addresses(peers: &Peers, now_ns: u64) -> Vec<SocketAddr> {
        peers.addresses(Wants::Descriptors, now_ns).collect()
    }

    #[test]
    fn only_who_says_its_cookie_back_is_sent_to_until_it_asks_no_more() {
        let mut peers = Peers::new().expect("random numbers");
        let told = peers.ask((7, 1), &asks(0), at(1), START).expect("new");
        assert!(!told.is_heard && addresses(&peers, START).is_empty());
        assert_eq!((peers.also(START), peers.frames_ns(START)), (None, None));
        // Another far side that has learned the cookie.
        let other = peers.ask((8, 1), &asks(told.cookie), at(2), START);
        assert!(other.is_some_and(|other| !other.is_heard && other.cookie != told.cookie));
        let told = peers.ask((7, 2), &asks(told.cookie), at(1), START);
        assert!(told.is_some_and(|told| told.is_heard));
        assert_eq!(addresses(&peers, START), [at(1)]);
        assert_eq!(
            (peers.also(START), peers.frames_ns(START)),
            (Some(bit(Also::Truth)), Some(40_000_000))
        );
        let of = |wants| peers.want(wants, START);
        assert!(of(Wants::Frames) && of(Wants::Also(Also::Truth)));
        assert!(!of(Wants::Also(Also::Centerlines)));
        assert!(addresses(&peers, START + ASKS_NS).is_empty());
    }

    #[test]
    fn a_recording_of_a_question_is_not_gone_by() {
        let mut peers = Peers::new().expect("random numbers");
        let told = join(&mut peers, 7, at(1), START);
        assert_eq!(peers.ask((7, 2), &asks(told.cookie), at(1), START), None);
        assert_eq!(peers.ask((7, 1), &asks(told.cookie), at(2), START), None);
        // The question is replayed after the asker has gone.
        let later = START + 2 * COOKIE_NS;
        let late = peers.ask((7, 2), &asks(told.cookie), at(1), later);
        assert!(late.is_some_and(|late| !late.is_heard));
        assert!(addresses(&peers, later).is_empty());
        // The question is replayed to another process of this side.
        let mut again = Peers::new().expect("random numbers");
        let late = again.ask((7, 2), &asks(told.cookie), at(1), START);
        assert!(late.is_some_and(|late| !late.is_heard));
    }

    #[test]
    fn a_cookie_changes_and_who_asks_on_stays() {
        let mut peers = Peers::new().expect("random numbers");
        let mut told = join(&mut peers, 7, at(1), START);
        for count in 3..3000 {
            let now_ns = START + count * 50_000_000;
            let next = peers.ask((7, count), &asks(told.cookie), at(1), now_ns);
            told = next.expect("of now");
            assert!(told.is_heard, "{count}");
        }
    }

    #[test]
    fn who_moves_is_sent_to_where_it_is_and_no_more_than_a_few_are() {
        let mut peers = Peers::new().expect("random numbers");
        let told = join(&mut peers, 7, at(1), START);
        let moved = peers.ask((7, 3), &asks(told.cookie), at(2), START);
        let moved = moved.expect("of now");
        assert!(!moved.is_heard);
        assert_eq!(addresses(&peers, START), [at(1)]);
        let moved = peers.ask((7, 4), &asks(moved.cookie), at(2), START);
        assert!(moved.is_some_and(|moved| moved.is_heard));
        assert_eq!(addresses(&peers, START), [at(2)]);
        // Only one far side is known per address.
        assert!(join(&mut peers, 8, at(2), START).is_heard);
        assert_eq!(addresses(&peers, START), [at(2)]);
        let heard = (0..100)
            .filter(|i| join(&mut peers, 100 + i, at(100 + *i as u16), START).is_heard)
            .count();
        assert_eq!(heard, MOST - 1);
        assert_eq!(addresses(&peers, START).len(), MOST);
    }
}
