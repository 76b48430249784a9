//! The point of a curve that is nearest to another, of all its points; and the box that holds them all.

use super::Curve;
use super::derivatives::{dot, minus, norm};
use super::descent::{Objective, Slope};
use super::segments::nearest_on_chord;

/// The point of a curve that is nearest to another.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Nearest<const D: usize = 2> {
    /// Where on the curve, 0 to 1.
    pub rho: f64,
    /// The point there.
    pub point: [f64; D],
    /// How far it is (px).
    pub distance: f64,
}

impl<const D: usize> Curve<'_, D> {
    /// The point of the curve that is nearest to `point`, among all: ends, corners and every strand of a curve
    /// that comes back.
    ///
    /// No local minimum is missed: the curve is cut until each part is known, by its control points (a Fourier
    /// series': by a bound on its second derivative), to be farther than what is found, or to hold the point
    /// that is sought, which Newton's method then finds to rounding. Of two that differ by less than 1e-9 of
    /// the curve's size either may come. Where a long part of the curve is almost equally far (a circle's
    /// middle), that tolerance grows until some thousand parts have been looked at; what comes is then near the
    /// least distance still, and the first found of the many.
    pub fn nearest(&self, point: [f64; D]) -> Nearest<D> {
        let least = self.least(&DistanceTo { point });
        let on_curve = self.point(least.rho);
        Nearest {
            rho: least.rho,
            point: on_curve,
            distance: norm(&minus(&on_curve, &point)),
        }
    }

    /// The smallest upright box that holds the curve (not only its control points): the least of every
    /// coordinate, and the largest. To 1e-9 of the curve's size, never larger than it.
    pub fn bounding_box(&self) -> [[f64; D]; 2] {
        let side = |sign: f64| {
            std::array::from_fn(|axis| sign * self.least(&Coordinate { axis, sign }).value)
        };
        [side(1.0), side(-1.0)]
    }

    /// The largest distance of any of its points from the origin.
    pub(crate) fn farthest(&self) -> f64 {
        -self.least(&Nearness).value
    }
}

/// How far a point of the curve is from this one.
struct DistanceTo<const D: usize> {
    point: [f64; D],
}

impl<const D: usize> Objective<D> for DistanceTo<D> {
    fn on_chord(&self, chord: &[[f64; D]; 2]) -> (f64, f64) {
        let share = nearest_on_chord(chord, &self.point);
        let away: [f64; D] = std::array::from_fn(|axis| {
            (1.0 - share) * chord[0][axis] + share * chord[1][axis] - self.point[axis]
        });
        (norm(&away), share)
    }

    /// The slope is that of half the square.
    fn at(&self, [point, velocity, acceleration]: &[[f64; D]; 3]) -> Slope {
        let away = minus(point, &self.point);
        Slope {
            value: norm(&away),
            first: dot(&away, velocity),
            second: dot(velocity, velocity) + dot(&away, acceleration),
        }
    }
}

/// One coordinate, or what it is short of none.
struct Coordinate {
    axis: usize,
    sign: f64,
}

impl<const D: usize> Objective<D> for Coordinate {
    fn on_chord(&self, chord: &[[f64; D]; 2]) -> (f64, f64) {
        let [first, second] = chord.map(|end| self.sign * end[self.axis]);
        if first <= second {
            (first, 0.0)
        } else {
            (second, 1.0)
        }
    }

    fn at(&self, jet: &[[f64; D]; 3]) -> Slope {
        let [value, first, second] = jet.map(|derivative| self.sign * derivative[self.axis]);
        Slope {
            value,
            first,
            second,
        }
    }
}

/// The distance from the origin, the larger the less.
struct Nearness;

impl<const D: usize> Objective<D> for Nearness {
    fn on_chord(&self, chord: &[[f64; D]; 2]) -> (f64, f64) {
        let [first, second] = chord.map(|end| -norm(&end));
        if first <= second {
            (first, 0.0)
        } else {
            (second, 1.0)
        }
    }

    fn at(&self, [point, velocity, acceleration]: &[[f64; D]; 3]) -> Slope {
        Slope {
            value: -norm(point),
            first: -dot(point, velocity),
            second: -dot(velocity, velocity) - dot(point, acceleration),
        }
    }
}
