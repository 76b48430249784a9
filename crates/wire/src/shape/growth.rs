//! How the uncertainty of a filtered control point grows from its image on.
//!
//! The chain's filter takes ropes to move with constant velocity and white acceleration of density `q`, and sees them every
//! `T` seconds. A position of variance `p` that is `h` seconds old then has
//!
//! ```text
//! p + 2 h c + h² v + q h³/3
//! ```
//!
//! with the velocity's variance `v` and its covariance `c` with the position, which the message leaves out. In the filter's
//! steady state both follow from `p`, `q` and `T` (Bar-Shalom, Li, Kirubarajan, *Estimation with Applications to Tracking and
//! Navigation*, 6.5, for the acceleration of 6.2.2): with the gains `α` and `β`,
//!
//! ```text
//! α² + αβ − 2β + β²/6 = 0,   p = α(1 − α) q T³/β²,   c = (1 − α) q T²/β,   v = q T (α/β − ½)
//! ```
//!
//! where `p/(q T³)` falls as `β` grows, from infinity to 0 at `β = 3 − √3`, where `α` is 1.

use super::{Inverse, Shape};

/// How a rope is taken to move: what the chain's own filter is told (`acceleration_px_s2` of `[fit]`).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Growth {
    /// The spectral density of the white acceleration of a point on the rope, along each axis, unit²/s³.
    pub(crate) density: f64,
    /// How long it is from image to image, s.
    pub(crate) period_s: f64,
}

impl Growth {
    /// The covariances of a shape's control points `seconds` after its image.
    ///
    /// Acceleration is equally likely in every direction of the space of curves, as in the filter: of control point `j` its
    /// density is `q (N/m) (BᵀB)⁻¹ⱼⱼ`.
    pub(crate) fn after(&self, seconds: f64, shape: &Shape, covariances: &mut [[f64; 3]]) {
        let size = shape.samples as f64 / shape.control_points.len() as f64;
        Inverse::with(shape, |inverse| {
            // Of plain fits all control points have the same share, and so the same gain.
            let mut last = (f64::NAN, 0.0);
            for (j, covariance) in covariances.iter_mut().enumerate() {
                let density = self.density * size * inverse.variance(j);
                let share =
                    (covariance[0] + covariance[2]) / (2.0 * density * self.period_s.powi(3));
                // The shares of one fit differ by rounding.
                let is_the_same = (share - last.0).abs() <= 1e-9 * share;
                if !is_the_same {
                    last = (share, gain(share));
                }
                let grown = self.grown(seconds, last.1) * density;
                // An acceleration of 0 makes nothing of anything.
                let grown = if density > 0.0 { grown } else { 0.0 };
                covariance[0] += grown;
                covariance[2] += grown;
            }
        });
    }

    /// By how much a variance grows, for `q = 1`.
    fn grown(&self, h: f64, beta: f64) -> f64 {
        let (t, alpha) = (self.period_s, alpha(beta));
        let c = (1.0 - alpha) * t * t / beta;
        let v = t * (alpha / beta - 0.5);
        2.0 * h * c + h * h * v + h * h * h / 3.0
    }
}

/// `α` that goes with `β`.
fn alpha(beta: f64) -> f64 {
    0.5 * ((beta * beta / 3.0 + 8.0 * beta).sqrt() - beta)
}

/// `β` of a filter whose positions have the variance `share · q T³`.
fn gain(share: f64) -> f64 {
    let (mut low, mut high) = (0.0, 3.0 - 3.0f64.sqrt());
    // To rounding, where β is not tiny.
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
