//! The point of a curve that is nearest to a point beside it.
//!
//! The curve is looked at in even steps; about each step that is nearer than its neighbours, and could hide one nearer still than
//! what is known, the root of `(f(ρ) − p) · f′(ρ)` is found by Newton's method, kept within its bracket by bisection.

use super::{Shape, norm};

/// Looks for each control point: a polynomial of degree n comes and goes n times at most. With half as many, one wild curve in
/// some thousands hid its nearest point in a valley beside another.
const LOOKS: usize = 16;
/// Halvings of a bracket until it is as narrow as ρ has digits.
const HALVINGS: usize = 52;

/// Where a curve, or a line of points, is nearest to a point.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Nearest<const D: usize = 2> {
    /// Where along it.
    pub rho: f64,
    /// The point on it.
    pub point: [f64; D],
    /// How far that is away.
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

/// From the second to the first.
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
    // Around a closed curve the first look comes twice, so that there is one on each side of it.
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

/// Where in a bracket the way from the point meets the curve at a right angle, or an end of it.
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
