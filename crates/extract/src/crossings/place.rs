//! Places on a finished curve. Reported positions treat the curve as straight between its points.
//! Reading the image uses a smooth spline.

use crate::scene::Curve;
use crate::vec2::{self, Vec2};

/// Minimum arc length, in widths, between two places where a rope crosses itself. The centerline of
/// the tightest loop, whose hole is closed, is π widths long.
const TIGHTEST: f32 = 2.0;

/// A place on a curve: the curve's index, and the point with its fraction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Place {
    pub(crate) curve: usize,
    pub(crate) at: f32,
}

impl Curve {
    /// Number of segments between points; in a closed curve also the one from the last to the
    /// first.
    pub(crate) fn intervals(&self) -> usize {
        match self.points.len() {
            0 | 1 => 0,
            n if self.closed => n,
            n => n - 1,
        }
    }

    /// The two points that segment `i` joins.
    pub(crate) fn piece(&self, i: usize) -> [Vec2; 2] {
        [self.points[i], self.points[(i + 1) % self.points.len()]]
    }

    /// Returns whether segments `i` and `j` are too near along the curve to cross each other.
    pub(crate) fn neighbors(&self, i: usize, j: usize) -> bool {
        let apart = self.step(i as f32, j as f32).abs();
        apart < 1.5 || apart * self.spacing_px() < TIGHTEST * self.width_px
    }

    /// Number of segments from one segment to the first that may cross it, counted the short way
    /// around.
    pub(crate) fn nearest_crossing(&self) -> usize {
        let least = TIGHTEST * self.width_px / self.spacing_px().max(1e-3);
        (least.min(self.points.len() as f32) as usize).max(1)
    }

    /// The step from place `from` to place `to` (points with fractions), the shorter way on a
    /// closed curve.
    pub(crate) fn step(&self, from: f32, to: f32) -> f32 {
        let (step, around) = (to - from, self.intervals() as f32);
        if self.closed && step.abs() > 0.5 * around {
            step - around.copysign(step)
        } else {
            step
        }
    }

    /// Arc length between two places, in pixels.
    pub(crate) fn way_px(&self, from: f32, to: f32) -> f32 {
        self.step(from, to).abs() * self.spacing_px()
    }

    /// Distance from one point to the next, in pixels.
    pub(crate) fn spacing_px(&self) -> f32 {
        self.length_px / self.intervals().max(1) as f32
    }

    /// The position at a place.
    pub(crate) fn at(&self, place: f32) -> Vec2 {
        let pieces = self.intervals();
        let place = if self.closed {
            place.rem_euclid(pieces as f32)
        } else {
            place
        };
        let i = (place.max(0.0) as usize).min(pieces - 1);
        let [from, to] = self.piece(i);
        vec2::along(from, vec2::sub(to, from), place - i as f32)
    }
}

/// The unit tangent at a place of the curve: that of the Catmull-Rom spline through its points.
pub(crate) fn tangent(curve: &Curve, place: f32) -> Vec2 {
    let (i, t) = split(curve, place);
    let [p, q, r, s] = around(curve, i);
    let d = std::array::from_fn(|c| {
        let bend = 2.0 * p[c] - 5.0 * q[c] + 4.0 * r[c] - s[c];
        let twist = 3.0 * (q[c] - r[c]) + s[c] - p[c];
        r[c] - p[c] + t * (2.0 * bend + 3.0 * t * twist)
    });
    vec2::unit_or(d, vec2::unit_or(vec2::sub(r, q), [1.0, 0.0]))
}

/// The segment of the spline that holds a place, and the fraction within it.
#[inline(always)]
pub(crate) fn split(curve: &Curve, place: f32) -> (i32, f32) {
    let last = curve.intervals() as i32 - 1;
    let i = place.floor() as i32;
    let i = if curve.closed { i } else { i.clamp(0, last) };
    (i, place - i as f32)
}

/// The points around segment `i`: one before it, its two ends, one after it.
#[inline]
pub(crate) fn around(curve: &Curve, i: i32) -> [Vec2; 4] {
    [
        point(curve, i - 1),
        point(curve, i),
        point(curve, i + 1),
        point(curve, i + 2),
    ]
}

/// Point `i`, counted around a closed curve, and extrapolated straight beyond the ends of an open
/// one.
fn point(curve: &Curve, i: i32) -> Vec2 {
    let n = curve.points.len() as i32;
    let at = |i: i32| curve.points[i as usize];
    if curve.closed {
        at(i.rem_euclid(n))
    } else if i < 0 {
        vec2::along(at(0), vec2::sub(at(1), at(0)), i as f32)
    } else if i >= n {
        let inner = at(n - 2);
        vec2::along(at(n - 1), vec2::sub(at(n - 1), inner), (i - n + 1) as f32)
    } else {
        at(i)
    }
}
