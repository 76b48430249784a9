//! What a filter is told about a rope's motion and about its measurements.

use super::error::FilterError;
use crate::setters::setters;

/// How a rope is taken to move, and how far measurements are trusted.
///
/// *A point on the rope* is meant in the mean over the rope: how its points move is equally likely in every
/// direction of the space of curves, so that the ends of a polynomial curve, which are freer than its middle,
/// move more than its middle does.
///
/// Each field has a method of its name that sets it: `FilterOptions::default().noise_scale(2.0)`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct FilterOptions {
    /// The standard deviation of the acceleration of a point on the rope, along each axis, px/s². From 0 to
    /// 10⁷. Default: 1000, that of a gripper that takes a rope from rest to 0.1 m/s in 0.1 s, seen at 1 px
    /// a millimetre.
    pub acceleration_px_s2: f64,
    /// How long an acceleration lasts before it is another, s. From 10⁻⁴ to 10. Default: 0.1.
    ///
    /// White noise has a spectral density `q` and no standard deviation. An acceleration `a` that is drawn
    /// again every `T` seconds adds `a²T²` to the variance of a velocity each time, white acceleration `q T`:
    /// so `q = a²T`, px²/s³. That says the same at any frame rate.
    pub acceleration_lasts_s: f64,
    /// The standard deviation of the velocity of a point on the rope, along each axis, before anything is
    /// known of it, px/s. From 0 to 10⁵. Default: 500.
    pub speed_px_s: f64,
    /// Measurements are taken to be this many times as uncertain (in standard deviations) as they say. From
    /// 10⁻³ to 10³. Default: 1.
    ///
    /// A fit's covariance counts the errors of all points as independent. Where `k` neighbours along a
    /// centerline err alike, a control point is `√k` times as uncertain; where they err alike in `k` frames
    /// on end, the filter, which counts on their mean, needs as much again. Choose it so that the normalized
    /// innovation squared has the mean that it should have ([`FilterStep::Updated`](crate::FilterStep)):
    /// the root of how many times too large it is.
    pub noise_scale: f64,
    /// A shape whose normalized innovation squared is this many standard deviations out (those of a normal
    /// distribution, by the cube root of the chi-square's: Wilson and Hilferty 1931) is a jump. From 1 on,
    /// infinity is no limit. Default: 10, at nine control points in a plane 9 times the mean, so that errors
    /// three times too large for the model are no jump yet.
    pub gate_sigma: f64,
    /// The longest time from shape to shape that is bridged, and from a shape to a prediction, s. From 10⁻³
    /// to 60. Default: 0.5.
    pub longest_gap_s: f64,
}

impl Default for FilterOptions {
    fn default() -> Self {
        Self {
            acceleration_px_s2: 1000.0,
            acceleration_lasts_s: 0.1,
            speed_px_s: 500.0,
            noise_scale: 1.0,
            gate_sigma: 10.0,
            longest_gap_s: 0.5,
        }
    }
}

impl FilterOptions {
    /// The spectral density of the white acceleration of a point on the rope, px²/s³.
    pub fn spectral_density(&self) -> f64 {
        self.acceleration_px_s2.powi(2) * self.acceleration_lasts_s
    }

    /// The chi-square number of `freedom` degrees of freedom that is `gate_sigma` out.
    pub(super) fn gate(&self, freedom: usize) -> f64 {
        let freedom = freedom as f64;
        let variance = 2.0 / (9.0 * freedom);
        freedom * (1.0 - variance + self.gate_sigma * variance.sqrt()).powi(3)
    }

    pub(super) fn check(&self) -> Result<(), FilterError> {
        for (name, given, least, most) in [
            ("acceleration_px_s2", self.acceleration_px_s2, 0.0, 1e7),
            (
                "acceleration_lasts_s",
                self.acceleration_lasts_s,
                1e-4,
                10.0,
            ),
            ("speed_px_s", self.speed_px_s, 0.0, 1e5),
            ("noise_scale", self.noise_scale, 1e-3, 1e3),
            ("gate_sigma", self.gate_sigma, 1.0, f64::INFINITY),
            ("longest_gap_s", self.longest_gap_s, 1e-3, 60.0),
        ] {
            // NaN is within no range.
            if !(least..=most).contains(&given) {
                return Err(FilterError::Option {
                    name,
                    given,
                    least,
                    most,
                });
            }
        }
        Ok(())
    }
}

setters! {
    FilterOptions {
        acceleration_px_s2: f64,
        acceleration_lasts_s: f64,
        speed_px_s: f64,
        noise_scale: f64,
        gate_sigma: f64,
        longest_gap_s: f64,
    }
}
