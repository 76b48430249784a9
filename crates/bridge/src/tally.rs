//! Counts what was sent, received and lost: sent = received + lost, exactly, by the sender's own
//! count.
//!
//! Each datagram carries the number of datagrams of its kind that its sender has sent, including
//! this one. If the count advances by more than one, the datagrams in between are lost. A datagram
//! that arrives after a later one is dropped, and stays lost: nothing goes back in time. Each
//! answer also reports the number sent, so that losses before a silence are known too.

/// The counts of one sender's datagrams of one kind.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Tally {
    /// Number sent before this receiver joined; `None` until a count is known.
    before: Option<u64>,
    /// Highest count received.
    newest: u64,
    /// Highest count known.
    told: u64,
    received: u64,
}

impl Tally {
    /// Records the count of a datagram that arrived. Returns false if the datagram is to be
    /// dropped: because it or a later one has already arrived, or because it was sent before this
    /// receiver joined.
    pub(crate) fn receive(&mut self, count: u64) -> bool {
        if count == 0 || count <= self.newest {
            return false;
        }
        self.before.get_or_insert(count - 1);
        // It was sent before this receiver joined.
        if self.before.is_some_and(|before| count <= before) {
            return false;
        }
        self.newest = count;
        self.told = self.told.max(count);
        self.received += 1;
        true
    }

    /// Records the number that the sender reports as sent.
    pub(crate) fn tell(&mut self, sent: u64) {
        self.before.get_or_insert(sent);
        self.told = self.told.max(sent);
    }

    /// Returns the number sent since this receiver joined, as far as it is known.
    pub(crate) fn sent(&self) -> u64 {
        self.before.map_or(0, |before| self.told - before)
    }

    /// Returns the number received.
    pub(crate) fn received(&self) -> u64 {
        self.received
    }

    /// Returns the number lost.
    pub(crate) fn lost(&self) -> u64 {
        self.sent() - self.received
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_received_is_lost() {
        let mut tally = Tally::default();
        assert_eq!((tally.sent(), tally.lost()), (0, 0));
        for count in [5, 6, 9, 10] {
            assert!(tally.receive(count));
        }
        assert_eq!((tally.sent(), tally.received(), tally.lost()), (6, 4, 2));
        // The last two were lost as well.
        tally.tell(12);
        assert_eq!((tally.sent(), tally.received(), tally.lost()), (8, 4, 4));
    }

    #[test]
    fn the_first_that_was_lost_is_known_by_the_sender_s_own_word() {
        let mut tally = Tally::default();
        tally.tell(0);
        assert!(tally.receive(3));
        assert_eq!((tally.sent(), tally.received(), tally.lost()), (3, 1, 2));
    }

    #[test]
    fn nothing_goes_back_in_time_or_comes_twice() {
        let mut tally = Tally::default();
        assert!(tally.receive(2));
        assert!(tally.receive(4));
        assert!(!tally.receive(3) && !tally.receive(4) && !tally.receive(0) && !tally.receive(1));
        assert_eq!((tally.sent(), tally.received(), tally.lost()), (3, 2, 1));
    }

    #[test]
    fn whatever_comes_in_whatever_order_sent_is_received_and_lost() {
        let mut random = 1_u64;
        let mut tally = Tally::default();
        for _ in 0..10_000 {
            random = random
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            let count = random >> 40;
            match random >> 33 & 1 {
                0 => drop(tally.receive(count)),
                _ => tally.tell(count),
            }
            assert_eq!(tally.sent(), tally.received() + tally.lost());
        }
    }
}
