//! Histogram of durations in nanoseconds.

/// Counts for each nanosecond up to [`Counts::MOST`], and all larger values.
#[derive(Debug, Clone)]
pub(super) struct Counts {
    at: Vec<u64>,
    above: Vec<u64>,
}

impl Counts {
    const MOST: usize = 20_000;

    pub(super) fn new() -> Self {
        Self {
            at: vec![0; Self::MOST],
            above: Vec::new(),
        }
    }

    pub(super) fn add(&mut self, ns: u64) {
        match self.at.get_mut(ns as usize) {
            Some(count) => *count += 1,
            None => self.above.push(ns),
        }
    }

    pub(super) fn count(&self) -> u64 {
        self.at.iter().sum::<u64>() + self.above.len() as u64
    }

    /// Returns the smallest value that at least a `share` (0 to 1) of all values do not exceed. 0
    /// if there are none.
    pub(super) fn percentile(&self, share: f64) -> u64 {
        let rank = ((share * self.count() as f64).ceil() as u64).max(1);
        let mut passed = 0;
        for (ns, count) in self.at.iter().enumerate() {
            passed += count;
            if passed >= rank {
                return ns as u64;
            }
        }
        let mut above = self.above.clone();
        above.sort_unstable();
        let index = (rank - passed) as usize - 1;
        above.get(index).copied().unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_times_that_were_taken() {
        let mut counts = Counts::new();
        for ns in (1..=98).chain([30_000, 25_000]) {
            counts.add(ns);
        }
        assert_eq!(counts.count(), 100);
        assert_eq!(
            [0.0, 0.5, 0.98, 0.99, 1.0].map(|p| counts.percentile(p)),
            [1, 50, 98, 25_000, 30_000]
        );
        assert_eq!(Counts::new().percentile(0.5), 0);
    }
}
