//! A rope's centerline as a control law asks for it: the points that its curve was fitted to.

use std::hint::black_box;

use crate::fields::{Hidden, is_hidden};
use crate::{CenterlinePoints, MAX_POINTS, Nearest};

/// The points of a rope at equal steps of arc length, joined by straight lines, in the message's unit. They are where the rope
/// was seen, unfiltered, whether the curve lies on them or not.
///
/// It reads the message where it lies and allocates nothing. ρ is the arc length from the first point, 0, to the last, 1; around
/// a closed rope 1 is the first again.
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
    /// One at least.
    points: &'a [[f32; 2]],
    widths: &'a [f32],
    hidden: &'a Hidden,
    closed: bool,
}

impl<'a> Centerline<'a> {
    /// The line through these points; `None` if there are none.
    pub fn of(points: &'a CenterlinePoints) -> Option<Self> {
        // Read once: a message may lie in shared memory, where its writer may have lost its wits.
        let count = (*black_box(&points.count) as usize).min(MAX_POINTS);
        (count > 0).then(|| Self {
            points: &points.points[..count],
            widths: &points.widths[..count],
            hidden: &points.hidden,
            closed: *black_box(&points.closed) != 0,
        })
    }

    /// The points, `[x, y]`: one at least.
    pub fn points(&self) -> &'a [[f32; 2]] {
        self.points
    }

    /// The rope's width at each point.
    pub fn widths(&self) -> &'a [f32] {
        self.widths
    }

    /// Whether point `i` is covered by something or outside of the image, and so not seen but bridged.
    pub fn is_hidden(&self, i: usize) -> bool {
        is_hidden(self.hidden, i)
    }

    /// Whether the last point is followed by the first.
    pub fn is_closed(&self) -> bool {
        self.closed
    }

    /// Where along the rope point `i` is.
    pub fn rho(&self, i: usize) -> f64 {
        i as f64 / self.steps().max(1) as f64
    }

    /// The point at `rho`, on the straight line between its two neighbours. Outside 0 to 1 an open rope has its ends, and a
    /// closed one goes around again.
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

    /// The point of the line that is nearest to `point`; of several, the first.
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
            // Two points in one place are met as the one before.
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

    /// How many straight lines there are.
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

/// The point at this share of the way; at 1 exactly `b`.
fn between(a: [f64; 2], b: [f64; 2], share: f64) -> [f64; 2] {
    [0, 1].map(|axis| (1.0 - share) * a[axis] + share * b[axis])
}
