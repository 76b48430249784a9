//! A rope's centerline for control laws: the points that its curve was fitted to.

use std::hint::black_box;

use crate::fields::{Hidden, is_hidden};
use crate::{CenterlinePoints, MAX_POINTS, Nearest};

/// The points of a rope at equal steps of arc length, joined by straight lines, in the message's
/// unit. They are the unfiltered observed points, whether or not the curve follows them.
///
/// It reads the message in place and does not allocate. ρ is the normalized arc length: 0 at the
/// first point, 1 at the last. On a closed rope, ρ = 1 is the first point again.
///
/// ```
/// use lariat_wire::{Centerline, CenterlinePoints};
///
/// let mut points = CenterlinePoints::EMPTY;
/// points.count = 3;
/// points.points[..3].copy_from_slice(&[[0.0, 0.0], [50.0, 0.0], [50.0, 50.0]]);
/// let rope = Centerline::of(&points).expect("it has points");
/// assert_eq!(rope.point_at(0.25), [25.0, 0.0]);
/// let nearest = rope.nearest([60.0, 25.0]);
/// assert_eq!((nearest.rho, nearest.point, nearest.distance), (0.75, [50.0, 25.0], 10.0));
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Centerline<'a> {
    /// Has at least one entry.
    points: &'a [[f32; 2]],
    widths: &'a [f32],
    hidden: &'a Hidden,
    closed: bool,
}

impl<'a> Centerline<'a> {
    /// The line through these points; `None` if the list is empty.
    pub fn of(points: &'a CenterlinePoints) -> Option<Self> {
        // Read once, because a faulty writer may change shared memory at any time.
        let count = (*black_box(&points.count) as usize).min(MAX_POINTS);
        (count > 0).then(|| Self {
            points: &points.points[..count],
            widths: &points.widths[..count],
            hidden: &points.hidden,
            closed: *black_box(&points.closed) != 0,
        })
    }

    /// The points, `[x, y]`; at least one.
    pub fn points(&self) -> &'a [[f32; 2]] {
        self.points
    }

    /// Width of the rope at each point.
    pub fn widths(&self) -> &'a [f32] {
        self.widths
    }

    /// Returns whether point `i` is covered or outside the image; its position is then
    /// interpolated.
    pub fn is_hidden(&self, i: usize) -> bool {
        is_hidden(self.hidden, i)
    }

    /// Returns whether the first point follows the last.
    pub fn is_closed(&self) -> bool {
        self.closed
    }

    /// Normalized arc length of point `i`.
    pub fn rho(&self, i: usize) -> f64 {
        i as f64 / self.steps().max(1) as f64
    }

    /// The point at `rho`, on the straight line between its two neighbors. Outside 0 to 1, an open
    /// rope gives its ends, and a closed one wraps around.
    pub fn point_at(&self, rho: f64) -> [f64; 2] {
        let rho = if self.is_closed() {
            rho.rem_euclid(1.0)
        } else {
            rho.clamp(0.0, 1.0)
        };
        let steps = self.steps();
        let along = rho * steps as f64;
        let i = (along as usize).min(steps.saturating_sub(1));
        let [a, b] = self.step(i);
        between(a, b, along - i as f64)
    }

    /// The nearest point of the line to `point`; the first one if there are several.
    pub fn nearest(&self, point: [f64; 2]) -> Nearest {
        let mut nearest = Nearest::to(point, 0.0, self.at(0));
        for i in 0..self.steps() {
            let [a, b] = self.step(i);
            let (ab, ap) = (
                [b[0] - a[0], b[1] - a[1]],
                [point[0] - a[0], point[1] - a[1]],
            );
            let square = ab[0] * ab[0] + ab[1] * ab[1];
            let share = ((ab[0] * ap[0] + ab[1] * ap[1]) / square).clamp(0.0, 1.0);
            // Two coincident points were already covered by the step before.
            if share.is_nan() {
                continue;
            }
            let rho = (i as f64 + share) / self.steps() as f64;
            let found = Nearest::to(point, rho, between(a, b, share));
            if found.distance < nearest.distance {
                nearest = found;
            }
        }
        nearest
    }

    /// Number of straight lines.
    fn steps(&self) -> usize {
        let count = self.points.len();
        if self.is_closed() { count } else { count - 1 }
    }

    /// The ends of line `i`.
    fn step(&self, i: usize) -> [[f64; 2]; 2] {
        [self.at(i), self.at((i + 1) % self.points.len())]
    }

    fn at(&self, i: usize) -> [f64; 2] {
        self.points[i].map(f64::from)
    }
}

/// Interpolates linearly from `a` to `b`; exactly `b` at a share of 1.
fn between(a: [f64; 2], b: [f64; 2], share: f64) -> [f64; 2] {
    [0, 1].map(|axis| (1.0 - share) * a[axis] + share * b[axis])
}
