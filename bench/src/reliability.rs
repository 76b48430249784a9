//! Reliability of the curves' confidence.

use std::fmt;

/// Number of confidence bins in which confidence and share of right curves are compared.
const BINS: usize = 10;

/// Minimum number of curves in a bin for a point in the diagram. The standard error is then below
/// 0.16.
const LEAST: usize = 10;

/// Number of curves, sum of their confidences, and number of right ones, by confidence bin.
#[derive(Default)]
pub(crate) struct Reliability([(usize, f64, usize); BINS]);

impl Reliability {
    pub(crate) fn add(&mut self, confidence: f64, is_right: bool) {
        let bin = ((confidence * BINS as f64) as usize).min(BINS - 1);
        let (count, said, right) = &mut self.0[bin];
        *count += 1;
        *said += confidence;
        *right += usize::from(is_right);
    }

    pub(crate) fn merge(&mut self, other: &Self) {
        for (to, from) in self.0.iter_mut().zip(other.0) {
            *to = (to.0 + from.0, to.1 + from.1, to.2 + from.2);
        }
    }

    /// Returns the mean confidence and the share of right curves for each bin that has enough
    /// curves.
    pub(crate) fn points(&self) -> Vec<[f64; 2]> {
        let steps = self.0.iter().filter(|step| step.0 >= LEAST);
        let point = |&(count, said, right): &(usize, f64, usize)| {
            [said / count as f64, right as f64 / count as f64]
        };
        steps.map(point).collect()
    }

    fn count(&self) -> usize {
        self.0.iter().map(|bin| bin.0).sum()
    }

    /// Returns the expected calibration error: the difference between confidence and share of right
    /// curves, averaged over all curves.
    pub(crate) fn error(&self) -> f64 {
        let off = |(_, said, right): &(usize, f64, usize)| (said - *right as f64).abs();
        self.0.iter().map(off).sum::<f64>() / self.count().max(1) as f64
    }
}

impl fmt::Display for Reliability {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (count, error) = (self.count(), self.error());
        writeln!(f, "{count} curves, expected calibration error {error:.3}")?;
        for (count, said, right) in self.0.iter().filter(|bin| bin.0 > 0) {
            let n = *count as f64;
            let (said, right) = (said / n, *right as f64 / n);
            writeln!(f, "  said {said:.2}, right {right:.2} of {count}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nine_of_ten_at_nine_tenths_are_calibrated() {
        let mut seen = Reliability::default();
        (0..10).for_each(|i| seen.add(0.9, i > 0));
        assert!(seen.error() < 1e-6);
        seen.add(0.05, true);
        assert!((seen.error() - 0.95 / 11.0).abs() < 1e-6);
        let mut all = Reliability::default();
        (0..2).for_each(|_| all.merge(&seen));
        assert!((all.error() - seen.error()).abs() < 1e-6 && all.count() == 22);
    }
}
