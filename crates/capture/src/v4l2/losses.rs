//! Counts a camera's unusable frames, and reports them at most once per second.

/// Minimum time between two reports.
const PAUSE_NS: u64 = 1_000_000_000;

/// Frames lost at the source for one reason.
#[derive(Debug, Default)]
pub(super) struct Losses {
    total: u64,
    unsaid: u64,
    next_ns: u64,
}

impl Losses {
    /// Counts one more frame. Returns the number of unreported frames and the total, or `None` if a
    /// report was made shortly before.
    pub(super) fn add(&mut self, now_ns: u64) -> Option<(u64, u64)> {
        self.total += 1;
        self.unsaid += 1;
        if now_ns < self.next_ns {
            return None;
        }
        self.next_ns = now_ns + PAUSE_NS;
        Some((std::mem::take(&mut self.unsaid), self.total))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flood_is_one_sentence_a_second_that_counts_them_all() {
        let mut losses = Losses::default();
        let second = PAUSE_NS / 1000;
        let said: Vec<_> = (0..=2500).filter_map(|i| losses.add(i * second)).collect();
        assert_eq!(said, [(1, 1), (1000, 1001), (1000, 2001)]);
    }
}
