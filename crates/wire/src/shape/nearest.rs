//! The nearest point of a curve to a given point.
//!
//! The curve is sampled at equal steps. Only samples nearer than their neighbors can be next to the
//! minimum. If such a sample may hide a point nearer than the best one yet, Newton's method finds
//! the root of `(f(ρ) − p) · f′(ρ)` there, kept within its bracket by bisection.

use super::{Shape, norm};

/// Samples per control point. A polynomial of degree n changes direction at most n times. With half
/// as many samples, the search found another minimum instead of the nearest point on about one in a
/// few thousand extreme curves.
const LOOKS: usize = 16;
/// Bisections until a bracket is as narrow as the precision of ρ.
const HALVINGS: usize = 52;

/// Nearest point of a curve, or of a polyline, to a given point.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Nearest<const D: usize = 2> {
    /// Position ρ along the curve.
    pub rho: f64,
    /// The point on the curve.
    pub point: [f64; D],
    /// Distance to the given point.
    pub distance: f64,
}

impl<const D: usize> Nearest<D> {
    pub(crate) fn to(point: [f64; D], rho: f64, on: [f64; D]) -> Self {
        let distance = norm(between(on, point));
        Self {
            rho,
            point: on,
            distance,
        }
    }
}

/// Vector from the second point to the first.
fn between<const D: usize>(to: [f64; D], from: [f64; D]) -> [f64; D] {
    std::array::from_fn(|k| to[k] - from[k])
}

pub(super) fn nearest<const D: usize>(shape: &Shape<D>, point: [f64; D]) -> Nearest<D> {
    let steps = LOOKS * shape.control_points.len().max(2);
    let closed = shape.closed;
    let look = |i: usize| {
        let rho = i as f64 / steps as f64;
        Nearest::to(point, rho, shape.point_at(rho))
    };
    let mut nearest = look(0);
    // On a closed curve, sample 0 is used twice, so that it has a neighbor on each side.
    let mut before = if closed { look(steps - 1) } else { nearest };
    let mut here = nearest;
    let last = if closed { steps - 1 } else { steps };
    for i in 0..=last {
        let after = look((i + 1).min(steps));
        let is_valley = here.distance <= before.distance && here.distance <= after.distance;
        let [back, forth] = [before, after].map(|beside| norm(between(beside.point, here.point)));
        if is_valley && here.distance - back.max(forth) < nearest.distance {
            let step = 1.0 / steps as f64;
            let (mut from, mut to) = (here.rho - step, here.rho + step);
            if !closed {
                (from, to) = (from.max(0.0), to.min(1.0));
            }
            let rho = foot(shape, point, here.rho, [from, to]);
            let rho = if closed { rho.rem_euclid(1.0) } else { rho };
            let found = Nearest::to(point, rho, shape.point_at(rho));
            for candidate in [here, found] {
                if candidate.distance < nearest.distance {
                    nearest = candidate;
                }
            }
        }
        (before, here) = (here, after);
    }
    nearest
}

/// Finds ρ in a bracket where the line to the point is perpendicular to the curve, or an end of the
/// bracket.
fn foot<const D: usize>(
    shape: &Shape<D>,
    point: [f64; D],
    start: f64,
    [mut from, mut to]: [f64; 2],
) -> f64 {
    let mut rho = start;
    for _ in 0..HALVINGS {
        let [at, velocity, acceleration] = shape.jet(rho);
        let way = between(at, point);
        let slope = dot(way, velocity);
        match slope < 0.0 {
            true => from = rho,
            false => to = rho,
        }
        let newton = rho - slope / (dot(velocity, velocity) + dot(way, acceleration));
        let next = if newton > from && newton < to {
            newton
        } else {
            0.5 * (from + to)
        };
        if (next - rho).abs() <= f64::EPSILON {
            return next;
        }
        rho = next;
    }
    rho
}

fn dot<const D: usize>(a: [f64; D], b: [f64; D]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
