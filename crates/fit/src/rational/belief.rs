//! The prior. The noise's size is unknown (Jeffreys), and a log-weight is normal about 0 with
//! standard deviation τ. The log-posterior of the log-weights `v`, whose best control points leave
//! the squared residuals `s(v)`, is up to a factor of −½
//!
//! ```text
//! Φ(v) = ν ln s(v) + |v|²/τ²,      ∇ = 0  ⇔  −½ ∇s = λ v  with  λ = (s/ν)/τ²
//! ```
//!
//! The prior thus acts as a ridge whose size follows the noise. It vanishes on an exact curve. It
//! holds combinations of weights at 1 if the points determine them less than the prior does; on a
//! straight line, these are all combinations. It also makes the mean of `v` 0, as the curve does
//! not change with the weights' scale.

use super::design::Design;

/// τ: nineteen of twenty weights are expected within a factor of e of their mean. An arc of a
/// circle of 90° has log-weights of 0.12 and −0.23, and one of 150° has 0.45 and −0.9, so the prior
/// is weak. It does not move weights that the points determine: its influence equals that of the
/// points if these leave a weight uncertain by a factor of 1.6.
const DEVIATION: f64 = 0.5;

/// Residuals below this share of the largest coordinate are rounding. The share is several thousand
/// times ε, because points and curve are sums of tens of rounded numbers.
const ROUNDING: f64 = 1e-12;

/// Evaluates squared residuals and weights.
pub(super) struct Belief {
    /// ν: the number of given minus fitted numbers.
    freedom: f64,
    /// Variance of rounding, px².
    rounding: f64,
}

impl Belief {
    /// Creates the prior; `None` if there are too few points to determine weights.
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

    /// Returns whether the residuals are rounding only.
    pub(super) fn is_rounding(&self, squared: f64) -> bool {
        squared <= self.freedom * self.rounding
    }

    /// `s/ν`, at least that of rounding.
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
