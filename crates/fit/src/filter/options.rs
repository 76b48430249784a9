//! Options of a filter: the rope's motion, and the accuracy of its measurements.

use super::error::FilterError;
use crate::setters::setters;

/// Assumptions about a rope's motion and about the accuracy of measurements.
///
/// Values for *a point on the rope* are averages over the rope. All directions of motion in the
/// space of curves are equally likely, so the ends of a polynomial curve, which are more flexible
/// than its middle, move more.
///
/// Each field has a method of the same name that sets it:
/// `FilterOptions::default().noise_scale(2.0)`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct FilterOptions {
    /// Standard deviation of the acceleration of a point on the rope, along each axis, px/s². From
    /// 0 to 10⁷. Default: 1000, that of a gripper that takes a rope from rest to 0.1 m/s in 0.1 s,
    /// seen at 1 px per millimeter.
    pub acceleration_px_s2: f64,
    /// Time for which an acceleration stays the same, s. From 10⁻⁴ to 10. Default: 0.1.
    ///
    /// White noise has a spectral density `q` and no standard deviation. An acceleration `a` that
    /// is drawn again every `T` seconds adds `a²T²` to the variance of a velocity each time, and
    /// white acceleration adds `q T`: so `q = a²T`, px²/s³. This model is independent of the frame
    /// rate.
    pub acceleration_lasts_s: f64,
    /// Standard deviation of the initial velocity of a point on the rope, along each axis, px/s.
    /// From 0 to 10⁵. Default: 500.
    pub speed_px_s: f64,
    /// Factor on the stated standard deviations of measurements. From 10⁻³ to 10³. Default: 1.
    ///
    /// A fit's covariance treats the errors of all points as independent. If `k` neighbors along a
    /// centerline have equal errors, a control point is `√k` times as uncertain. If errors are
    /// equal in `k` consecutive frames, the filter, which averages them, needs the same factor
    /// again. Choose the factor so that the normalized innovation squared has its expected mean
    /// ([`FilterStep::Updated`](crate::FilterStep)). If the mean is `r` times as large as expected
    /// at a factor of 1, choose `√r`.
    pub noise_scale: f64,
    /// A shape is a jump if its normalized innovation squared exceeds its expectation by this many
    /// standard deviations (those of the normal distribution that approximates the cube root of the
    /// chi-square: Wilson and Hilferty 1931). From 1; infinity disables the limit. Default: 10.
    /// With nine control points in a plane, the limit is then 9 times the mean, so errors three
    /// times as large as the model's are not yet a jump.
    pub gate_sigma: f64,
    /// Maximum time between shapes, and from a shape to a prediction, s. From 10⁻³ to 60. Default:
    /// 0.5.
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
    /// Spectral density of the white acceleration of a point on the rope, px²/s³.
    pub fn spectral_density(&self) -> f64 {
        self.acceleration_px_s2.powi(2) * self.acceleration_lasts_s
    }

    /// The chi-square value of `freedom` degrees of freedom at `gate_sigma`.
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
            // Also rejects NaN.
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
