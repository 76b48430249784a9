//! Growth of a filtered control point's uncertainty after its image.
//!
//! The chain's filter assumes constant velocity plus white acceleration of density `q`, with an
//! observation every `T` seconds. A position of variance `p` that is `h` seconds old then has the
//! variance
//!
//! ```text
//! p + 2 h c + h² v + q h³/3
//! ```
//!
//! with the velocity's variance `v` and its covariance `c` with the position, which the message
//! omits. In the filter's steady state both follow from `p`, `q` and `T` (Bar-Shalom, Li,
//! Kirubarajan, *Estimation with Applications to Tracking and Navigation*, 6.5, for the
//! acceleration of 6.2.2). With the gains `α` and `β`,
//!
//! ```text
//! α² + αβ − 2β + β²/6 = 0,   p = α(1 − α) q T³/β²,   c = (1 − α) q T²/β,   v = q T (α/β − ½)
//! ```
//!
//! where `p/(q T³)` decreases as `β` grows, from infinity to 0 at `β = 3 − √3`, where `α` is 1.

use super::{Inverse, Shape};

/// Motion model of a rope, as in the chain's own filter (`acceleration_px_s2` of `[fit]`).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Growth {
    /// Spectral density of the white acceleration of a point on the rope, along each axis,
    /// unit²/s³.
    pub(crate) density: f64,
    /// Time from image to image, s.
    pub(crate) period_s: f64,
}

impl Growth {
    /// Covariances of a shape's control points `seconds` after its image.
    ///
    /// Acceleration is equally likely in every direction of the space of curves, as in the filter.
    /// Control point `j` has the density `q (N/m) (BᵀB)⁻¹ⱼⱼ`.
    pub(crate) fn after(&self, seconds: f64, shape: &Shape, covariances: &mut [[f64; 3]]) {
        let size = shape.samples as f64 / shape.control_points.len() as f64;
        Inverse::with(shape, |inverse| {
            // In plain fits all control points have the same ratio `p/(q T³)`, and so the same
            // gain.
            let mut last = (f64::NAN, 0.0);
            for (j, covariance) in covariances.iter_mut().enumerate() {
                let density = self.density * size * inverse.variance(j);
                let share =
                    (covariance[0] + covariance[2]) / (2.0 * density * self.period_s.powi(3));
                // The ratios of one fit differ by rounding only.
                let is_the_same = (share - last.0).abs() <= 1e-9 * share;
                if !is_the_same {
                    last = (share, gain(share));
                }
                let grown = self.grown(seconds, last.1) * density;
                // Zero acceleration adds nothing, even if the other factor is infinite.
                let grown = if density > 0.0 { grown } else { 0.0 };
                covariance[0] += grown;
                covariance[2] += grown;
            }
        });
    }

    /// Increase of a variance after `h` seconds, for `q = 1`.
    fn grown(&self, h: f64, beta: f64) -> f64 {
        let (t, alpha) = (self.period_s, alpha(beta));
        let c = (1.0 - alpha) * t * t / beta;
        let v = t * (alpha / beta - 0.5);
        2.0 * h * c + h * h * v + h * h * h / 3.0
    }
}

/// The `α` that belongs to `β`.
fn alpha(beta: f64) -> f64 {
    0.5 * ((beta * beta / 3.0 + 8.0 * beta).sqrt() - beta)
}

/// The `β` of a filter whose positions have the variance `share · q T³`.
fn gain(share: f64) -> f64 {
    let (mut low, mut high) = (0.0, 3.0 - 3.0f64.sqrt());
    // Converges to rounding, unless β is tiny.
    for _ in 0..52 {
        let beta = 0.5 * (low + high);
        let alpha = alpha(beta);
        if alpha * (1.0 - alpha) > share * beta * beta {
            low = beta;
        } else {
            high = beta;
        }
    }
    0.5 * (low + high)
}
