//! Distances of a centerline's points from the nearest points of a curve, rather than from the
//! curve's points at their ρ.

use super::Curve;
use super::derivatives::{dot, minus};

/// Distances of a centerline's points from a curve.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Distance {
    /// Root mean squared distance (px); 0 without points.
    pub rms: f64,
    /// Largest distance (px).
    pub max: f64,
}

/// Maximum number of steps from a point's ρ to that of the nearest point. After a fit, two are
/// enough. If they do not converge, the whole curve is searched.
const STEPS: usize = 12;

/// A step below this share of the curve's size is the last: the remaining error is proportional to
/// its cube.
const LAST_STEP: f64 = 1e-5;

/// Maximum step away from a local maximum, in ρ. The distance is only known to decrease near that
/// maximum.
const LONGEST_DOWN: f64 = 0.05;

impl<const D: usize> Curve<'_, D> {
    /// Computes the distances of these points from the curve's nearest points. The points are
    /// ordered along the curve and evenly spaced, from its first point to its last, or around it if
    /// it is closed; see [`Curve::distance_to_at`].
    pub fn distance_to(&self, points: &[[f64; D]]) -> Distance {
        let even = |i| self.basis.even_rho(i, points.len());
        self.distance_to_at(
            points
                .iter()
                .enumerate()
                .map(|(i, &point)| (point, even(i))),
        )
    }

    /// Computes the distances of these points from the curve's nearest points. Each point comes
    /// with the ρ at which it was fitted, and its nearest point is searched for near that ρ. Where
    /// the rope passes close to itself, this keeps the nearest point on the same strand. If the
    /// search does not converge, the nearest point of the whole curve is used.
    ///
    /// Every distance is accurate to about 1e-10 of the curve's size.
    pub fn distance_to_at(&self, points: impl IntoIterator<Item = ([f64; D], f64)>) -> Distance {
        let last_step = (LAST_STEP * self.size()).powi(2);
        let (mut sum, mut largest, mut count) = (0.0, 0.0f64, 0usize);
        for (point, rho) in points {
            let squared = self
                .squared_near(&point, rho, last_step)
                .unwrap_or_else(|| self.nearest(point).distance.powi(2));
            sum += squared;
            // Once NaN, it stays NaN.
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

    /// Squared distance of `point` from the curve near `rho`. `None` if the nearest point there is
    /// not found, or is farther than the start. `last_step` is squared too.
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
            // The distance decreases only beyond this end, so the end is the nearest point.
            if !closed && ((rho == 0.0 && slope >= 0.0) || (rho == 1.0 && slope <= 0.0)) {
                return (here <= begun).then_some(here);
            }
            let squared = dot(&velocity, &velocity);
            let rise = squared + dot(&away, &acceleration);
            if rise <= 0.0 {
                // Beyond the center of curvature, the distance has a maximum. Step away from it.
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

/// Step to the nearest point of the osculating parabola: a Newton step, followed by a second one.
///
/// Half the slope of the squared distance is `slope + rise s + 3/2 v·a s² + 1/2 a·a s³` after a
/// step `s`. The remaining error is proportional to the cube of the step.
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
