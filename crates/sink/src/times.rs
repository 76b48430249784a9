//! A distribution of durations, with percentiles from an HDR histogram, and exact mean and maximum.

use crate::hgrm;
use crate::saved::{RestoreError, Saved, Saving, sound};
use crate::summary::Spread;
use hdrhistogram::Histogram;
use std::io::{self, Write};

/// Upper limit of the histograms: 100 s. Longer times are only counted, but the maximum is always
/// exact.
pub(crate) const LONGEST_NS: u64 = 100_000_000_000;

/// Significant digits: percentiles have errors below 0.1 %, and a histogram takes 200 kB.
const DIGITS: u8 = 3;

/// Creates a histogram of integers up to `largest`, accurate to `digits` significant digits. It
/// never grows.
///
/// Only the pages in use become resident.
pub(crate) fn histogram(largest: u64, digits: u8) -> Histogram<u64> {
    Histogram::new_with_bounds(1, largest, digits)
        .expect("the bounds are constants: 1, more than 2, at most 5 digits")
}

/// Limit that no histogram's count reaches: more than all stages together can count.
const LARGEST_HEAP: u64 = 1 << 62;

/// Writes the nonempty buckets of a histogram.
pub(crate) fn save(histogram: &Histogram<u64>, to: &mut Saving) {
    to.number(histogram.iter_recorded().count() as u64);
    let mut before = 0;
    for bucket in histogram.iter_recorded() {
        let value = bucket.value_iterated_to();
        to.numbers([value - before, bucket.count_at_value()]);
        before = value;
    }
}

/// Reads the buckets into an empty histogram of the same kind.
pub(crate) fn restore(
    histogram: &mut Histogram<u64>,
    from: &mut Saved,
) -> Result<(), RestoreError> {
    let buckets = from.number()?;
    let (mut value, mut total) = (0u64, 0u64);
    // The input limits this loop, because each bucket takes at least two bytes.
    for _ in 0..buckets {
        let [step, count] = from.numbers()?;
        value = value.checked_add(step).ok_or(RestoreError::Damaged)?;
        total = sound(total.saturating_add(count), |&total| total <= LARGEST_HEAP)?;
        histogram.saturating_record_n(value, count);
    }
    Ok(())
}

/// Durations in nanoseconds, distinguished to three significant digits, up to 100 s.
///
/// ```
/// let mut times = lariat_sink::Times::default();
/// (1..=1000).for_each(|us| times.add(1000 * us));
/// assert_eq!(times.quantile_us(1.0), Some(1000.0));
/// let mut text = Vec::new();
/// times.write_hgrm(&mut text)?;
/// let read = lariat_sink::Times::from_hgrm(&String::from_utf8_lossy(&text)).unwrap();
/// assert_eq!(read.count(), 1000);
/// # Ok::<(), std::io::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Times {
    histogram: Histogram<u64>,
    sum_ns: u128,
    longest_ns: u64,
}

impl Default for Times {
    fn default() -> Self {
        Self::new(LONGEST_NS, DIGITS)
    }
}

impl Times {
    /// Creates an empty distribution. Times longer than `longest_told_ns` are not distinguished,
    /// except for the maximum.
    pub(crate) fn new(longest_told_ns: u64, digits: u8) -> Self {
        Self {
            histogram: histogram(longest_told_ns, digits),
            sum_ns: 0,
            longest_ns: 0,
        }
    }

    /// Adds a duration.
    pub fn add(&mut self, ns: u64) {
        self.add_many(ns, 1);
    }

    /// Adds a duration `count` times.
    pub(crate) fn add_many(&mut self, ns: u64, count: u64) {
        self.histogram.saturating_record_n(ns, count);
        self.sum_ns += u128::from(ns) * u128::from(count);
        if count > 0 {
            self.longest_ns = self.longest_ns.max(ns);
        }
    }

    /// Adds all durations of another distribution.
    pub fn merge(&mut self, other: &Self) {
        for step in other.histogram.iter_recorded() {
            self.histogram
                .saturating_record_n(step.value_iterated_to(), step.count_at_value());
        }
        self.sum_ns += other.sum_ns;
        self.longest_ns = self.longest_ns.max(other.longest_ns);
    }

    /// Reads the output of [`write_hgrm`](Self::write_hgrm), with the resolution of its steps: each
    /// duration counts as the longest of its step. Returns `None` if the text is not such a
    /// histogram.
    pub fn from_hgrm(text: &str) -> Option<Self> {
        hgrm::read(text)
    }

    /// Writes the distribution as text in HdrHistogram's own format, in microseconds.
    ///
    /// # Errors
    /// Returns the errors of `out`.
    pub fn write_hgrm(&self, out: &mut impl Write) -> io::Result<()> {
        hgrm::write(self, out)
    }

    pub(crate) fn save(&self, to: &mut Saving) {
        save(&self.histogram, to);
        let (high, low) = ((self.sum_ns >> 64) as u64, self.sum_ns as u64);
        to.numbers([high, low, self.longest_ns]);
    }

    /// Reads saved times of the same kind. The distribution must be empty.
    pub(crate) fn restore(&mut self, from: &mut Saved) -> Result<(), RestoreError> {
        restore(&mut self.histogram, from)?;
        let [high, low, longest_ns] = from.numbers()?;
        let most = u128::from(self.count()) * u128::from(longest_ns);
        self.sum_ns = sound(u128::from(high) << 64 | u128::from(low), |&sum| sum <= most)?;
        self.longest_ns = longest_ns;
        Ok(())
    }

    pub(crate) fn clear(&mut self) {
        self.histogram.reset();
        self.sum_ns = 0;
        self.longest_ns = 0;
    }

    /// Returns the number of durations.
    pub fn count(&self) -> u64 {
        self.histogram.len()
    }

    pub(crate) fn histogram(&self) -> &Histogram<u64> {
        &self.histogram
    }

    /// Returns the duration that this share of all durations does not exceed, in microseconds. A
    /// share of 1 gives the maximum. Returns `None` for an empty distribution.
    pub fn quantile_us(&self, quantile: f64) -> Option<f64> {
        if self.histogram.is_empty() {
            return None;
        }
        let ns = if quantile < 1.0 {
            // The upper edge of a bucket may exceed everything in it.
            self.histogram
                .value_at_quantile(quantile)
                .min(self.longest_ns)
        } else {
            self.longest_ns
        };
        Some(ns as f64 / 1e3)
    }

    /// Returns the mean in microseconds.
    pub fn mean_us(&self) -> Option<f64> {
        let count = self.histogram.len();
        (count > 0).then(|| self.sum_ns as f64 / count as f64 / 1e3)
    }

    /// Returns the figures of `summary.json`.
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

/// Rounds to 10 ns, which is less than a stamp costs.
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
    fn a_histogram_read_back_or_merged_has_the_same_percentiles() {
        let mut times = Times::default();
        (1..=5000).for_each(|i| times.add(1_000 + i * i));
        let mut text = Vec::new();
        times.write_hgrm(&mut text).expect("memory takes it");
        let text = String::from_utf8(text).expect("text");
        let read = Times::from_hgrm(&text).expect("its own format");
        let mut merged = Times::default();
        merged.merge(&times);
        merged.merge(&read);
        assert_eq!((read.count(), merged.count()), (5000, 10_000));
        for quantile in [0.5, 0.9, 0.99, 0.999, 1.0] {
            let us = times.quantile_us(quantile).unwrap_or(0.0);
            for other in [&read, &merged] {
                let found = other.quantile_us(quantile).unwrap_or(0.0);
                // Values are read back with the resolution of the format's steps. Just above the
                // median, a step holds a twentieth of all values.
                assert!((found / us - 1.0).abs() < 0.1, "{quantile}: {found}, {us}");
                assert!(found <= 25_001.0, "{found}");
            }
        }
        assert!(Times::from_hgrm("no histogram").is_none());
        assert!(Times::from_hgrm(&text[..text.len() / 2]).is_none());
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
