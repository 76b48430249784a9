//! How sure depths are, and those between that were not measured.

use super::{Axis, RopeDepth, length};

/// So many third differences are needed to judge noise by; their median is this where they are normal, of variance 1; and noise is taken for
/// at most so many times what the sensor's model says.
const LEAST_TO_DOUBT: usize = 10;
const MEDIAN_OF_NORMAL: f64 = 0.6745;
const MOST_DOUBT: f64 = 8.0;
/// How far off depth may be, in mm, for each mm from where it was measured last.
const ASTRAY: f64 = 0.12;

impl RopeDepth {
    /// Raises the variances to what third differences along the rope show: the noise of a depth image's neighbors is not
    /// independent, and no model says by how much. A rope's own shape has next to none.
    pub(super) fn doubt(&mut self) {
        self.row.clear();
        for four in self.sections.windows(4) {
            let four = [0, 1, 2, 3].map(|k| &self.axes[four[k]]);
            if four.iter().all(|axis| axis.is_measured) {
                let weights = [-1.0, 3.0, -3.0, 1.0];
                let sum = |of: fn(&Axis, f64) -> f64| -> f64 {
                    four.iter().zip(weights).map(|(axis, w)| of(axis, w)).sum()
                };
                let difference = sum(|axis, w| w * axis.depth);
                let variance = sum(|axis, w| w * w * axis.variance);
                self.row.push(difference.abs() / variance.sqrt());
            }
        }
        let count = self.row.len();
        if count < LEAST_TO_DOUBT {
            return;
        }
        let (_, median, _) = self.row.select_nth_unstable_by(count / 2, f64::total_cmp);
        let off = (*median / MEDIAN_OF_NORMAL).clamp(1.0, MOST_DOUBT);
        for axis in &mut self.axes {
            axis.variance *= off * off;
        }
    }

    /// Depth where it was not measured: straight between, and on from, where it was.
    pub(super) fn bridge(&mut self) {
        let count = self.axes.len();
        let mut i = 0;
        while i < count {
            if self.axes[i].is_measured {
                i += 1;
                continue;
            }
            let end = (i..count)
                .find(|&k| self.axes[k].is_measured)
                .unwrap_or(count);
            let before = (0..i).rev().find(|&k| self.axes[k].is_measured);
            let after = (end < count).then_some(end);
            for k in i..end {
                let (depth, variance) = match (before, after) {
                    (Some(a), Some(b)) => {
                        let share = (k - a) as f64 / (b - a) as f64;
                        let [a, b] = [&self.axes[a], &self.axes[b]];
                        let way = self.aside(a, k).min(self.aside(b, k));
                        (
                            a.depth + share * (b.depth - a.depth),
                            a.variance.max(b.variance) + ASTRAY * ASTRAY * way * way,
                        )
                    }
                    (Some(a), None) | (None, Some(a)) => {
                        let axis = &self.axes[a];
                        let way = 2.0 * self.aside(axis, k);
                        (axis.depth, axis.variance + ASTRAY * ASTRAY * way * way)
                    }
                    (None, None) => return,
                };
                (self.axes[k].depth, self.axes[k].variance) = (depth, variance);
            }
            i = end;
        }
    }

    /// How far point `k` is aside of another, mm.
    fn aside(&self, axis: &Axis, k: usize) -> f64 {
        let other = self.axes[k].ray;
        length(axis.ray[0] - other[0], axis.ray[1] - other[1]) * axis.depth
    }
}
