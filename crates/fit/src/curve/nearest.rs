//! The nearest point of a curve to a given point, and the bounding box of a curve.

use super::Curve;
use super::derivatives::{dot, minus, norm};
use super::descent::{Objective, Slope};
use super::segments::nearest_on_chord;

/// The nearest point of a curve to a given point.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Nearest<const D: usize = 2> {
    /// Its ρ, 0 to 1.
    pub rho: f64,
    /// The point.
    pub point: [f64; D],
    /// Its distance (px).
    pub distance: f64,
}

impl<const D: usize> Curve<'_, D> {
    /// Finds the globally nearest point of the curve to `point`, including ends and corners, on any
    /// strand.
    ///
    /// No local minimum is missed. The curve is cut until each part is known to be farther than the
    /// best point, or to contain the nearest one. The bound comes from its control points or, for a
    /// Fourier series, from its second derivative. Newton's method then finds the point to within
    /// rounding. If the distances of two points differ by less than 1e-9 of the curve's size,
    /// either point may be returned. If a long part of the curve is almost equally far (a circle's
    /// center), that tolerance grows until several thousand parts have been examined. The result is
    /// then the first found of many points that are all near the least distance.
    pub fn nearest(&self, point: [f64; D]) -> Nearest<D> {
        let least = self.least(&DistanceTo { point });
        let on_curve = self.point(least.rho);
        Nearest {
            rho: least.rho,
            point: on_curve,
            distance: norm(&minus(&on_curve, &point)),
        }
    }

    /// The smallest axis-aligned box that contains the curve (not only its control points): the
    /// minimum of every coordinate, and the maximum. It is accurate to 1e-9 of the curve's size,
    /// and never too large.
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

/// Distance of a point of the curve from this one.
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

    /// The slope is that of half the squared distance.
    fn at(&self, [point, velocity, acceleration]: &[[f64; D]; 3]) -> Slope {
        let away = minus(point, &self.point);
        Slope {
            value: norm(&away),
            first: dot(&away, velocity),
            second: dot(velocity, velocity) + dot(&away, acceleration),
        }
    }
}

/// One coordinate, or its negative.
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

/// Negative distance from the origin.
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
