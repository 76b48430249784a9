//! A test for depth images that do not show the rope.
//!
//! A depth camera may miss a cable that is black, shiny or thin, and a depth image taken at another
//! moment may not show it. The depths along the centerline are then those of the table. A visible
//! rope stands out: its surroundings are behind its axis or, for a cable in a groove, well in front
//! of its surface. If only the table is visible, the axis is computed from the table, which is then
//! one radius in front of the axis.

use super::{DepthImage, RopeDepth, SeenRope};

/// Distances from the axis, in half widths: beyond the rope itself, and beyond a neighbor that
/// touches it. `EDGE_PX` is added, because pixels at an edge see both of its sides.
const BESIDE: [f64; 2] = [2.0, 4.0];
const EDGE_PX: f64 = 2.0;
/// If only the table is visible, its distance behind the axis is between these limits, in radii.
/// Ideally the distance is −1. The lower limit is half a radius less. The upper limit is midway
/// between −1 and 1, the distance of a table under a visible rope.
const FLAT: [f64; 2] = [-1.5, 0.0];
/// Minimum number of values for a meaningful median.
const LEAST: usize = 8;

impl RopeDepth {
    /// Returns true if the depth image is as flat across the rope as a table.
    pub(super) fn is_flat(&mut self, image: &DepthImage, rope: &SeenRope) -> bool {
        let mut relief = std::mem::take(&mut self.row);
        relief.clear();
        relief.extend((1..self.sections.len().saturating_sub(1)).filter_map(|k| {
            let i = self.sections[k];
            let is_seen = self.axes[i].is_measured && !rope.hidden[i];
            is_seen.then(|| self.relief(image, k)).flatten()
        }));
        let count = relief.len();
        let is_flat = count >= LEAST && {
            let (_, median, _) = relief.select_nth_unstable_by(count / 2, f64::total_cmp);
            (FLAT[0]..FLAT[1]).contains(median)
        };
        self.row = relief;
        is_flat
    }

    /// Distance from the `k`-th section's axis to the farther of two pairs of places next to the
    /// rope, in radii. It is positive if the places are behind the axis. The mean of a pair cancels
    /// the slope of the table.
    fn relief(&self, image: &DepthImage, k: usize) -> Option<f64> {
        let pixel = |k: usize| {
            let axis = &self.axes[self.sections[k]];
            self.camera.pixel(self.place(axis, axis.depth))
        };
        let [before, at, after] = [pixel(k - 1)?, pixel(k)?, pixel(k + 1)?];
        let [x, y] = [0, 1].map(|c| after[c] - before[c]);
        let length = (x * x + y * y).sqrt();
        if length < 1e-9 {
            return None;
        }
        let axis = &self.axes[self.sections[k]];
        let half = self.half_width_px(axis);
        let pairs = BESIDE.into_iter().filter_map(|widths| {
            let reach = (widths * half + EDGE_PX) / length;
            let depth = |reach: f64| {
                let [column, row] = [at[0] - reach * y, at[1] + reach * x];
                image.at(column.round() as isize, row.round() as isize)
            };
            Some(0.5 * (depth(-reach)? + depth(reach)?))
        });
        let farther = pairs.max_by(f64::total_cmp)?;
        let ahead = self.place(axis, axis.depth)[2];
        Some((farther - ahead) / (axis.slim * axis.depth))
    }
}
