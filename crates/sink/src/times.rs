//! A heap of durations: percentiles from an HDR histogram, mean and longest exact.

use crate::hgrm;
use crate::saved::{RestoreError, Saved, Saving, sound};
use crate::summary::Spread;
use hdrhistogram::Histogram;
use std::io::{self, Write};

/// Longest time told from longer ones: 100 s. Of longer ones the longest is known, and how many there were.
pub(crate) const LONGEST_NS: u64 = 100_000_000_000;

/// Three significant digits: the error of a percentile is below 0.1 %, at 200 kB a histogram.
const DIGITS: u8 = 3;

/// A histogram of whole numbers up to `largest` that never grows, right to so many significant digits.
///
/// Only the pages of it that are in use become resident.
pub(crate) fn histogram(largest: u64, digits: u8) -> Histogram<u64> {
    Histogram::new_with_bounds(1, largest, digits)
        .expect("the bounds are constants: 1, more than 2, at most 5 digits")
}

/// What no histogram holds: more than all stages together count to.
const LARGEST_HEAP: u64 = 1 << 62;

/// Writes the buckets of a histogram that are not empty.
pub(crate) fn save(histogram: &Histogram<u64>, to: &mut Saving) {
    to.number(histogram.iter_recorded().count() as u64);
    let mut before = 0;
    for bucket in histogram.iter_recorded() {
        let value = bucket.value_iterated_to();
        to.numbers([value - before, bucket.count_at_value()]);
        before = value;
    }
}

/// Reads them into an empty histogram of the same kind.
pub(crate) fn restore(
    histogram: &mut Histogram<u64>,
    from: &mut Saved,
) -> Result<(), RestoreError> {
    let buckets = from.number()?;
    let (mut value, mut total) = (0u64, 0u64);
    // As long as there are bytes to read: each bucket takes two at least.
    for _ in 0..buckets {
        let [step, count] = from.numbers()?;
        value = value.checked_add(step).ok_or(RestoreError::Damaged)?;
        total = sound(total.saturating_add(count), |&total| total <= LARGEST_HEAP)?;
        histogram.saturating_record_n(value, count);
    }
    Ok(())
}

/// Durations in nanoseconds: told apart to three significant digits, up to 100 s.
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
    /// No durations yet; longer ones than `longest_told_ns` will be told from it by the longest only.
    pub(crate) fn new(longest_told_ns: u64, digits: u8) -> Self {
        Self {
            histogram: histogram(longest_told_ns, digits),
            sum_ns: 0,
            longest_ns: 0,
        }
    }

    /// One more.
    pub fn add(&mut self, ns: u64) {
        self.add_many(ns, 1);
    }

    /// So many more of one length.
    pub(crate) fn add_many(&mut self, ns: u64, count: u64) {
        self.histogram.saturating_record_n(ns, count);
        self.sum_ns += u128::from(ns) * u128::from(count);
        if count > 0 {
            self.longest_ns = self.longest_ns.max(ns);
        }
    }

    /// All durations of another heap, too.
    pub fn merge(&mut self, other: &Self) {
        for step in other.histogram.iter_recorded() {
            self.histogram
                .saturating_record_n(step.value_iterated_to(), step.count_at_value());
        }
        self.sum_ns += other.sum_ns;
        self.longest_ns = self.longest_ns.max(other.longest_ns);
    }

    /// Reads what [`write_hgrm`](Self::write_hgrm) wrote, as far as its steps tell durations apart: each counts as its
    /// step's longest. `None` if the text is no such histogram.
    pub fn from_hgrm(text: &str) -> Option<Self> {
        hgrm::read(text)
    }

    /// Writes the distribution as text, in HdrHistogram's own format, in microseconds.
    ///
    /// # Errors
    /// What `out` says.
    pub fn write_hgrm(&self, out: &mut impl Write) -> io::Result<()> {
        hgrm::write(self, out)
    }

    pub(crate) fn save(&self, to: &mut Saving) {
        save(&self.histogram, to);
        let (high, low) = ((self.sum_ns >> 64) as u64, self.sum_ns as u64);
        to.numbers([high, low, self.longest_ns]);
    }

    /// Reads what was saved of times of the same kind; there are none yet.
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

    /// How many there are.
    pub fn count(&self) -> u64 {
        self.histogram.len()
    }

    pub(crate) fn histogram(&self) -> &Histogram<u64> {
        &self.histogram
    }

    /// The duration that this share of all does not exceed, in microseconds; 1 is the longest. `None` without any.
    pub fn quantile_us(&self, quantile: f64) -> Option<f64> {
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
    pub fn mean_us(&self) -> Option<f64> {
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
                // A step of the format holds a twentieth of what is left, at most 10 % of 5000² ns near the median.
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
