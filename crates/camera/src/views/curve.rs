//! The curve of a rope in a view.

use crate::camera::Camera;
use crate::space::{SeenRope, Sight, length, sight};

/// A rope's points as tangents, and the cubic through them.
#[derive(Debug, Clone, Default)]
pub(super) struct Curve {
    pub sights: Vec<Sight>,
    pub hidden: Vec<bool>,
    pub closed: bool,
    pub ends: [bool; 2],
    /// Mean distance from one point to the next.
    pub step: f64,
    row: Vec<f64>,
}

/// A place on the curve, its derivative by the position in points, and whether something covers it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spot {
    pub at: [f64; 2],
    pub way: [f64; 2],
    pub is_hidden: bool,
}

impl Curve {
    /// Stores a rope. Stores no points if the rope has too few, or if some are beyond the lens
    /// model.
    pub(super) fn take(&mut self, camera: &Camera, rope: &SeenRope) {
        (self.closed, self.ends) = (rope.closed, rope.ends);
        self.hidden.clear();
        self.hidden.extend_from_slice(rope.hidden);
        if !rope.is_whole() || sight::aim(camera, rope, &mut self.row, &mut self.sights).is_none() {
            self.sights.clear();
        }
        self.step = mean_step(&self.sights);
    }

    /// Largest position along the curve, in points.
    pub(super) fn last(&self) -> f64 {
        let count = self.sights.len();
        (if self.closed {
            count
        } else {
            count.saturating_sub(1)
        }) as f64
    }

    /// Limits a position to the curve, or wraps it if the curve is closed.
    pub(super) fn within(&self, u: f64) -> f64 {
        match self.closed {
            true => u - self.last() * (u / self.last()).floor(),
            false => u.clamp(0.0, self.last()),
        }
    }

    /// Difference between two positions, in points; on a closed curve, the shorter way.
    pub(super) fn between(&self, from: f64, to: f64) -> f64 {
        let (way, whole) = (to - from, self.last());
        match self.closed {
            true => way - whole * (way / whole + 0.5).floor(),
            false => way,
        }
    }

    /// Returns the place at a position along the curve (Catmull–Rom cubic).
    pub(super) fn spot(&self, u: f64) -> Spot {
        let u = self.within(u);
        let i = (u as usize).min((self.last() as usize).saturating_sub(1));
        let t = u - i as f64;
        let [a, b, c, d] = [-1, 0, 1, 2].map(|by| self.point(i as isize + by));
        let cubic = |k: usize| {
            let [m, n] = [0.5 * (c[k] - a[k]), 0.5 * (d[k] - b[k])];
            let rise = c[k] - b[k];
            let (square, cube) = (3.0 * rise - 2.0 * m - n, m + n - 2.0 * rise);
            (
                b[k] + t * (m + t * (square + t * cube)),
                m + t * (2.0 * square + 3.0 * t * cube),
            )
        };
        let ((x, dx), (y, dy)) = (cubic(0), cubic(1));
        let beside = if self.closed {
            (i + 1) % self.sights.len()
        } else {
            i + 1
        };
        Spot {
            at: [x, y],
            way: [dx, dy],
            is_hidden: self.hidden[i] || self.hidden[beside],
        }
    }

    /// A point of the curve, which continues straight beyond its ends.
    fn point(&self, i: isize) -> [f64; 2] {
        let count = self.sights.len() as isize;
        let at = |i: isize| {
            let [x, y, _] = self.sights[i as usize].ray;
            [x, y]
        };
        let beyond = |end: isize, before: isize| {
            let (end, before) = (at(end), at(before));
            [0, 1].map(|k| 2.0 * end[k] - before[k])
        };
        match self.closed {
            true => at(i.rem_euclid(count)),
            false if i < 0 => beyond(0, 1),
            false if i >= count => beyond(count - 1, count - 2),
            false => at(i),
        }
    }

    /// Finds the position on the curve nearest to a place, starting from a position near it.
    pub(super) fn nearest(&self, to: [f64; 2], mut u: f64) -> f64 {
        for _ in 0..3 {
            let Spot { at, way, .. } = self.spot(u);
            let ahead = (to[0] - at[0]) * way[0] + (to[1] - at[1]) * way[1];
            let by = ahead / (way[0] * way[0] + way[1] * way[1]);
            if !by.is_finite() {
                break;
            }
            u = self.within(u + by.clamp(-1.5, 1.5));
        }
        u
    }
}

/// Mean distance from one point to the next, in tangents.
pub(super) fn mean_step(sights: &[Sight]) -> f64 {
    let steps = sights.windows(2).map(|pair| {
        let [a, b] = [pair[0].ray, pair[1].ray];
        length(b[0] - a[0], b[1] - a[1])
    });
    steps.sum::<f64>() / sights.len().saturating_sub(1).max(1) as f64
}
