//! A heap of durations: percentiles from an HDR histogram, mean and longest exact.

use crate::summary::Spread;
use hdrhistogram::Histogram;

/// A histogram of whole numbers up to `largest` that never grows, right to so many significant digits.
///
/// Only the pages of it that are in use become resident.
pub(crate) fn histogram(largest: u64, digits: u8) -> Histogram<u64> {
    Histogram::new_with_bounds(1, largest, digits)
        .expect("the bounds are constants: 1, more than 2, at most 5 digits")
}

/// Durations in nanoseconds.
#[derive(Debug, Clone)]
pub(crate) struct Times {
    histogram: Histogram<u64>,
    sum_ns: u128,
    longest_ns: u64,
}

impl Times {
    /// No durations yet; longer ones than `longest_told_ns` will be told from it by the longest only.
    pub(crate) fn new(longest_told_ns: u64, digits: u8) -> Self {
        Self {
            histogram: histogram(longest_told_ns, digits),
            sum_ns: 0,
            longest_ns: 0,
        }
    }

    pub(crate) fn add(&mut self, ns: u64) {
        self.histogram.saturating_record(ns);
        self.sum_ns += u128::from(ns);
        self.longest_ns = self.longest_ns.max(ns);
    }

    pub(crate) fn clear(&mut self) {
        self.histogram.reset();
        self.sum_ns = 0;
        self.longest_ns = 0;
    }

    pub(crate) fn count(&self) -> u64 {
        self.histogram.len()
    }

    pub(crate) fn histogram(&self) -> &Histogram<u64> {
        &self.histogram
    }

    /// The duration that this share of all does not exceed, in microseconds; 1 is the longest. `None` without any.
    pub(crate) fn quantile_us(&self, quantile: f64) -> Option<f64> {
        if self.histogram.is_empty() {
            return None;
        }
        let ns = if quantile < 1.0 {
            // A bucket's upper edge may lie past all that is in it.
            self.histogram
                .value_at_quantile(quantile)
                .min(self.longest_ns)
        } else {
            self.longest_ns
        };
        Some(ns as f64 / 1e3)
    }

    /// The mean, in microseconds.
    pub(crate) fn mean_us(&self) -> Option<f64> {
        let count = self.histogram.len();
        (count > 0).then(|| self.sum_ns as f64 / count as f64 / 1e3)
    }

    /// The figures of `summary.json`.
    pub(crate) fn spread(&self) -> Spread {
        let at = |quantile| self.quantile_us(quantile).map(to_hundredths);
        Spread {
            p50: at(0.5),
            p90: at(0.9),
            p99: at(0.99),
            p999: at(0.999),
            max: at(1.0),
            mean: (!self.histogram.is_empty()).then(|| to_hundredths(self.histogram.mean() / 1e3)),
        }
    }
}

/// To 10 ns: less than a stamp costs.
pub(crate) fn to_hundredths(us: f64) -> f64 {
    (us * 100.0).round() / 100.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_right_to_a_thousandth_mean_and_longest_exact() {
        let mut times = Times::new(1_000_000_000, 3);
        (1..=1000).for_each(|i| times.add(i * 1_000_001));
        for (quantile, us) in [(0.5, 500_000.0), (0.9, 900_000.0), (0.99, 990_000.0)] {
            let found = times.quantile_us(quantile).unwrap_or(0.0);
            assert!((found / us - 1.0).abs() < 1e-3, "{quantile}: {found}");
        }
        assert_eq!(times.quantile_us(1.0), Some(1_000_001.0));
        assert_eq!(times.mean_us(), Some(500_500.500_5));
    }

    #[test]
    fn one_duration_is_every_percentile() {
        let mut times = Times::new(1_000_000_000, 2);
        times.add(500_000);
        assert_eq!(times.quantile_us(0.5), Some(500.0));
        assert_eq!(times.quantile_us(1.0), Some(500.0));
        assert_eq!(times.mean_us(), Some(500.0));
    }
}
