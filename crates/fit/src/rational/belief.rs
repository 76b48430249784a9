//! What is believed before any point is seen: the noise's size is unknown (Jeffreys), and a log-weight is
//! normal about 0 with standard deviation τ. Then the log-posterior of the log-weights `v`, whose best
//! control points leave the squared residuals `s(v)`, is, up to a factor of −½,
//!
//! ```text
//! Φ(v) = ν ln s(v) + |v|²/τ²,      ∇ = 0  ⇔  −½ ∇s = λ v  with  λ = (s/ν)/τ²
//! ```
//!
//! A ridge, then, whose size follows the noise: it vanishes on an exact curve, and holds those
//! combinations of weights at 1 about which the points say less than the prior: on a straight line all of
//! them. That `v` has mean 0 is its doing as well, as the curve does not change with the weights' scale.

use super::design::Design;

/// τ: nineteen of twenty weights are expected within a factor of e of their mean. An arc of a circle of 90°
/// has log-weights of 0.12 and −0.23, one of 150° of 0.45 and −0.9: this is a weak belief. Weights that the
/// points tell are not moved by it: it counts as much as they do where they leave a factor of 1.6 open.
const DEVIATION: f64 = 0.5;

/// Squared residuals of less than this share of the coordinates' size, each, are rounding: some thousand
/// times ε, as the points and the curve are sums of some tens of numbers that were rounded.
const ROUNDING: f64 = 1e-12;

/// How squared residuals and weights are judged.
pub(super) struct Belief {
    /// ν: the numbers given less those fitted.
    freedom: f64,
    /// The variance of rounding, px².
    rounding: f64,
}

impl Belief {
    /// `None` where the points are too few to tell weights by.
    pub(super) fn new<const D: usize>(design: &Design, points: &[[f64; D]]) -> Option<Self> {
        let freedom = (D * (design.points - design.free())).checked_sub(design.count - 1)?;
        if freedom == 0 {
            return None;
        }
        let largest = points
            .as_flattened()
            .iter()
            .fold(0.0, |largest: f64, c| largest.max(c.abs()));
        Some(Self {
            freedom: freedom as f64,
            rounding: (ROUNDING * largest).powi(2).max(f64::MIN_POSITIVE),
        })
    }

    /// Whether what is left is rounding alone.
    pub(super) fn is_rounding(&self, squared: f64) -> bool {
        squared <= self.freedom * self.rounding
    }

    /// `s/ν`, of which rounding is the least.
    pub(super) fn variance(&self, squared: f64) -> f64 {
        squared / self.freedom + self.rounding
    }

    /// λ.
    pub(super) fn ridge(variance: f64) -> f64 {
        variance / (DEVIATION * DEVIATION)
    }

    /// Φ.
    pub(super) fn merit(&self, squared: f64, log_weights: &[f64]) -> f64 {
        let sum: f64 = log_weights.iter().map(|v| v * v).sum();
        self.freedom * libm::log(self.variance(squared)) + sum / (DEVIATION * DEVIATION)
    }
}
