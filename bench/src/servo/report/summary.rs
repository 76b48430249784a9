//! Summary of a row's outcomes, as shown in the table.

use lariat_plot::spread::quantile;

use super::Row;
use crate::servo::judge::REACHED_PX;

/// Results of the ropes of a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Summary {
    pub(super) ropes: usize,
    /// Number of ropes at the target at the end.
    pub(super) reached: usize,
    /// Times until half and nine tenths of all ropes had reached the target. Infinite if fewer did.
    pub(super) time_s: Quantiles,
    /// Maximum distance beyond [`REACHED_PX`] after the target was first reached.
    pub(super) overshoot_px: Quantiles,
    /// Error at the end. Infinite if the ropes were not seen.
    pub(super) final_px: Quantiles,
}

/// Quantiles over the ropes of a row. NaN if there are none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Quantiles {
    pub(super) median: f64,
    pub(super) p90: f64,
    pub(super) worst: f64,
}

impl Quantiles {
    /// Computes the quantiles of numbers that may be infinite.
    pub(super) fn of(numbers: impl IntoIterator<Item = f64>) -> Self {
        let mut sorted: Vec<f64> = numbers.into_iter().collect();
        sorted.sort_by(f64::total_cmp);
        Self {
            median: quantile(&sorted, 0.5),
            p90: quantile(&sorted, 0.9),
            worst: quantile(&sorted, 1.0),
        }
    }
}

impl Summary {
    pub(super) fn of(row: &Row) -> Self {
        let outcomes = &row.outcomes;
        let never = f64::INFINITY;
        let overshoots = outcomes.iter().filter_map(|outcome| outcome.overshoot_px());
        Self {
            ropes: outcomes.len(),
            reached: outcomes.iter().filter(|o| o.is_reached()).count(),
            time_s: Quantiles::of(outcomes.iter().map(|o| o.reached_s().unwrap_or(never))),
            overshoot_px: Quantiles::of(overshoots.map(|px| (px - REACHED_PX).max(0.0))),
            final_px: Quantiles::of(outcomes.iter().map(|o| o.final_px())),
        }
    }

    /// Returns the share of ropes that reached the target, 0 to 1. 0 if there are none.
    pub(super) fn share(&self) -> f64 {
        self.reached as f64 / self.ropes.max(1) as f64
    }

    /// Returns whether the row is clearly worse than another. It is if its share of ropes at the
    /// target is more than 5 percentage points lower, or if its median time is more than a quarter
    /// longer. It also is if its median final error is larger by more than a quarter and by more
    /// than half a pixel. Smaller differences may be chance.
    pub(super) fn is_worse_than(&self, other: &Self) -> bool {
        self.is_rarer_than(other) || self.is_slower_than(other) || self.is_farther_than(other)
    }

    pub(super) fn is_farther_than(&self, other: &Self) -> bool {
        let (ours, theirs) = (self.final_px.median, other.final_px.median);
        ours > 1.25 * theirs && ours > theirs + 0.5
    }

    fn is_slower_than(&self, other: &Self) -> bool {
        self.time_s.median > 1.25 * other.time_s.median
    }

    fn is_rarer_than(&self, other: &Self) -> bool {
        self.share() < other.share() - 0.05 - 1e-9
    }
}

#[test]
fn quantiles_are_infinite_only_where_too_few_came() {
    let never = f64::INFINITY;
    let all = Quantiles::of([1.0, 2.0, 3.0]);
    assert_eq!((all.median, all.worst), (2.0, 3.0));
    let most = Quantiles::of([3.0, never, 1.0, 2.0, never]);
    assert_eq!((most.median, most.p90), (3.0, never));
    assert_eq!(Quantiles::of([never, never]).median, never);
    assert!(Quantiles::of([]).median.is_nan());
}
