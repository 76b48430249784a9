//! How far the points of a centerline are from a curve in truth: from its nearest point, not from the one at
//! their ρ.

use super::Curve;
use super::derivatives::{dot, minus};

/// How far the points of a centerline are from a curve.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Distance {
    /// Root of the mean squared distance (px); 0 if there is no point.
    pub rms: f64,
    /// The largest distance (px).
    pub max: f64,
}

/// Steps from a point's ρ to that of the curve's nearest point. From a fit it takes two; what has not settled after these is searched for over the whole curve.
const STEPS: usize = 12;

/// A step of less than this share of the curve's size is the last: what is left goes with its cube.
const LAST_STEP: f64 = 1e-5;

/// No step down from a hill is longer, in ρ: the way is only known to go down for some length.
const LONGEST_DOWN: f64 = 0.05;

impl<const D: usize> Curve<'_, D> {
    /// How far these points are from the curve's nearest points. They are ordered along the curve and evenly
    /// spaced, from its first point to its last, or around it if it is closed; see
    /// [`Curve::distance_to_at`].
    pub fn distance_to(&self, points: &[[f64; D]]) -> Distance {
        let even = |i| self.basis.even_rho(i, points.len());
        self.distance_to_at(
            points
                .iter()
                .enumerate()
                .map(|(i, &point)| (point, even(i))),
        )
    }

    /// How far these points are from the curve's nearest points. With each point comes the ρ at which it was
    /// fitted, near which its nearest point is sought: on a rope that comes back close to itself, that on its
    /// own strand. Where that search does not settle, the nearest point of the whole curve is taken.
    ///
    /// Every distance is right to about 1e-10 of the curve's size.
    pub fn distance_to_at(&self, points: impl IntoIterator<Item = ([f64; D], f64)>) -> Distance {
        let last_step = (LAST_STEP * self.size()).powi(2);
        let (mut sum, mut largest, mut count) = (0.0, 0.0f64, 0usize);
        for (point, rho) in points {
            let squared = self
                .squared_near(&point, rho, last_step)
                .unwrap_or_else(|| self.nearest(point).distance.powi(2));
            sum += squared;
            // Once it is NaN it stays so.
            if squared.is_nan() || squared > largest {
                largest = squared;
            }
            count += 1;
        }
        Distance {
            rms: (sum / count.max(1) as f64).sqrt(),
            max: largest.sqrt(),
        }
    }

    /// The squared distance of `point` from the curve near `rho`, unless the nearest point there is not found, or
    /// is farther than where the search began. `last_step` is squared too.
    fn squared_near(&self, point: &[f64; D], rho: f64, last_step: f64) -> Option<f64> {
        let closed = self.basis.is_closed();
        let mut rho = if closed { rho } else { rho.clamp(0.0, 1.0) };
        let mut begun = f64::NAN;
        for step in 0..STEPS {
            let [at, velocity, acceleration] = self.jet(rho);
            let away = minus(&at, point);
            let here = dot(&away, &away);
            if step == 0 {
                begun = here;
            }
            let slope = dot(&away, &velocity);
            // At an end, and the curve would have to go on.
            if !closed && ((rho == 0.0 && slope >= 0.0) || (rho == 1.0 && slope <= 0.0)) {
                return (here <= begun).then_some(here);
            }
            let squared = dot(&velocity, &velocity);
            let rise = squared + dot(&away, &acceleration);
            if rise <= 0.0 {
                // Beyond the middle of the circle that the curve follows, where it is a hill: down from it.
                let down = -slope / squared;
                if down.is_nan() || down * down * squared <= last_step {
                    return None;
                }
                rho += down.clamp(-LONGEST_DOWN, LONGEST_DOWN);
            } else {
                let (first, by) = to_parabola(&velocity, &acceleration, slope, rise);
                if first * first * squared <= last_step {
                    let after: [f64; D] = std::array::from_fn(|axis| {
                        away[axis] + by * (velocity[axis] + 0.5 * by * acceleration[axis])
                    });
                    let there = dot(&after, &after);
                    return (there <= begun).then_some(there);
                }
                rho += by;
            }
            if !closed {
                rho = rho.clamp(0.0, 1.0);
            }
        }
        None
    }
}

/// The step to the nearest point of the parabola that a curve follows: Newton's first, and with a second one.
///
/// Half the slope of the squared distance is `slope + rise s + 3/2 v·a s² + 1/2 a·a s³` after a step `s`. What is left
/// goes with the cube of the step.
#[inline(always)]
fn to_parabola<const D: usize>(
    velocity: &[f64; D],
    acceleration: &[f64; D],
    slope: f64,
    rise: f64,
) -> (f64, f64) {
    let bend = dot(velocity, acceleration);
    let turn = dot(acceleration, acceleration);
    let first = -slope / rise;
    let left = slope + first * (rise + first * (1.5 * bend + first * 0.5 * turn));
    let steepness = rise + first * (3.0 * bend + first * 1.5 * turn);
    if steepness > 0.5 * rise {
        (first, first - left / steepness)
    } else {
        (first, first)
    }
}
