//! Variances of depths, and depths of points that were not measured.

use super::{RopeDepth, length};

/// Minimum number of third differences for an estimate of the noise; median of the absolute value
/// of a normal variable with variance 1; and maximum ratio of the noise to the sensor's model.
const LEAST_TO_DOUBT: usize = 10;
const MEDIAN_OF_NORMAL: f64 = 0.6745;
const MOST_DOUBT: f64 = 8.0;
/// Error of a bridged depth, in mm per mm from the last measured point.
const ASTRAY: f64 = 0.12;

impl RopeDepth {
    /// Raises the variances to the level that third differences along the rope show. The noise of
    /// neighboring pixels is correlated, to a degree that no model predicts. A rope's own shape has
    /// almost no third differences.
    pub(super) fn doubt(&mut self) {
        self.row.clear();
        for four in self.sections.windows(4) {
            let [a, b] = [&self.axes[four[0]], &self.axes[four[1]]];
            let [c, d] = [&self.axes[four[2]], &self.axes[four[3]]];
            if a.is_measured && b.is_measured && c.is_measured && d.is_measured {
                let difference = 3.0 * (b.depth - c.depth) + (d.depth - a.depth);
                let variance = 9.0 * (b.variance + c.variance) + (a.variance + d.variance);
                self.row.push(difference * difference / variance);
            }
        }
        let count = self.row.len();
        if count < LEAST_TO_DOUBT {
            return;
        }
        let (_, median, _) = self.row.select_nth_unstable_by(count / 2, f64::total_cmp);
        let off = (median.sqrt() / MEDIAN_OF_NORMAL).clamp(1.0, MOST_DOUBT);
        for axis in &mut self.axes {
            axis.variance *= off * off;
        }
    }

    /// Fills in depths that were not measured: linearly between measured points, and constant
    /// beyond them.
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
                        let way = self.aside(a, k).min(self.aside(b, k));
                        let [a, b] = [&self.axes[a], &self.axes[b]];
                        (
                            a.depth + share * (b.depth - a.depth),
                            a.variance.max(b.variance) + ASTRAY * ASTRAY * way * way,
                        )
                    }
                    (Some(a), None) | (None, Some(a)) => {
                        let axis = &self.axes[a];
                        let way = 2.0 * self.aside(a, k);
                        (axis.depth, axis.variance + ASTRAY * ASTRAY * way * way)
                    }
                    (None, None) => return,
                };
                (self.axes[k].depth, self.axes[k].variance) = (depth, variance);
            }
            i = end;
        }
    }

    /// Lateral distance between point `k` and point `from`, mm.
    fn aside(&self, from: usize, k: usize) -> f64 {
        let [a, b] = [self.sights[from].ray, self.sights[k].ray];
        length(a[0] - b[0], a[1] - b[1]) * self.axes[from].depth
    }
}
