//! What came of what was sent: sent = received + lost, exactly, from the sender's own count.
//!
//! Each datagram carries how many of its kind its sender has sent, this one included. What a count advances more than by one is lost; what comes
//! behind a later one is dropped, and stays lost: nothing goes back in time. How many were sent last is also said in each answer to a
//! question of time, so that what is lost before a silence is known too.

/// What has become of one sender's datagrams of one kind.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Tally {
    /// What had been sent before this receiver came; `None` before anything was heard.
    before: Option<u64>,
    /// The highest count that was received.
    newest: u64,
    /// The highest that is known of.
    told: u64,
    received: u64,
}

impl Tally {
    /// Takes in the count of a datagram that came; `false`: a later one, or the same, came before it.
    pub(crate) fn receive(&mut self, count: u64) -> bool {
        if count == 0 || count <= self.newest {
            return false;
        }
        self.before.get_or_insert(count - 1);
        // One that was sent before this receiver was told of any is of before it came.
        if self.before.is_some_and(|before| count <= before) {
            return false;
        }
        self.newest = count;
        self.told = self.told.max(count);
        self.received += 1;
        true
    }

    /// Takes in how many the sender says that it has sent.
    pub(crate) fn tell(&mut self, sent: u64) {
        self.before.get_or_insert(sent);
        self.told = self.told.max(sent);
    }

    /// How many were sent since this receiver came, as far as is known.
    pub(crate) fn sent(&self) -> u64 {
        self.before.map_or(0, |before| self.told - before)
    }

    /// How many of them were received.
    pub(crate) fn received(&self) -> u64 {
        self.received
    }

    /// How many were not.
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
        // The last ones were lost, too.
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
