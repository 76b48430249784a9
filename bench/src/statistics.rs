//! Medians of many short measurements.

use std::time::Instant;

/// Measurements of one quantity.
#[derive(Debug, Clone, Default)]
pub struct Samples {
    values: Vec<f64>,
}

impl Samples {
    /// Adds a measurement.
    pub fn push(&mut self, value: f64) {
        self.values.push(value);
    }

    /// Measures the time of `work` in nanoseconds, adds it, and returns it.
    pub fn time<T>(&mut self, work: impl FnOnce() -> T) -> f64 {
        let start = Instant::now();
        let result = work();
        let ns = start.elapsed().as_secs_f64() * 1e9;
        // Dropping the result is not timed.
        drop(result);
        self.push(ns);
        ns
    }

    /// Returns the number of measurements.
    pub fn count(&self) -> usize {
        self.values.len()
    }

    /// Adds all measurements of `others`.
    pub fn take(&mut self, others: Self) {
        self.values.extend(others.values);
    }

    /// Returns the mean. 0 if there are no measurements.
    pub fn mean(&self) -> f64 {
        self.values.iter().sum::<f64>() / self.values.len().max(1) as f64
    }

    /// Returns the smallest value that at least a `share` (0 to 1) of all measurements do not
    /// exceed. 0 if there are no measurements.
    pub fn percentile(&self, share: f64) -> f64 {
        let mut sorted = self.values.clone();
        sorted.sort_by(f64::total_cmp);
        let rank = (share * sorted.len() as f64).ceil() as usize;
        let last = sorted.len().saturating_sub(1);
        sorted
            .get(rank.saturating_sub(1).min(last))
            .copied()
            .unwrap_or_default()
    }

    /// Returns the smallest value that at least half of all measurements do not exceed. 0 if there
    /// are no measurements.
    pub fn median(&self) -> f64 {
        self.percentile(0.5)
    }
}

impl FromIterator<f64> for Samples {
    fn from_iter<I: IntoIterator<Item = f64>>(values: I) -> Self {
        Self {
            values: values.into_iter().collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_values_that_were_measured() {
        let samples: Samples = (1..=100).rev().map(f64::from).collect();
        assert_eq!(samples.median(), 50.0);
        assert_eq!(samples.percentile(0.99), 99.0);
        assert_eq!(samples.percentile(1.0), 100.0);
        assert_eq!(samples.percentile(0.0), 1.0);
        assert_eq!(Samples::from_iter([7.0, 3.0, 5.0]).median(), 5.0);
    }

    #[test]
    fn a_mean_is_of_all_that_were_taken_in() {
        let mut samples = Samples::from_iter([1.0, 2.0]);
        samples.take(Samples::from_iter([6.0]));
        assert_eq!(samples.mean(), 3.0);
    }

    #[test]
    fn nothing_measured_is_zero() {
        assert_eq!(Samples::default().median(), 0.0);
        assert_eq!(Samples::default().mean(), 0.0);
    }
}
