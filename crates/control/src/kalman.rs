//! A Kalman filter on the entries of `J` (J. Qian, J. Su, *Online estimation of image Jacobian
//! matrix by Kalman–Bucy filter for uncalibrated stereo vision feedback*, ICRA 2002; in shape
//! servoing D. Navarro-Alarcon and others, IEEE T-RO 32, 2016, by least squares with a memory).
//!
//! Each row of `J` is a state. It performs a random walk along the grippers' path, and each pair
//! measures it along `δr`:
//!
//! ```text
//! P ← P + q‖δr‖ I,     k = P δr/(δrᵀP δr + R),     J ← J + (δs − J δr) kᵀ,     P ← (I − k δrᵀ) P (I − k δrᵀ)ᵀ + R k kᵀ
//! ```
//!
//! In coordinates where the metric is a plain sum of squares, all rows have the same noise, so one
//! `P` serves all. Because `k` is the same for all rows, the rule is the same in any coordinates.
//! `P` and `R` are mean squares over the shape. A `P` of 1 corresponds to a rope that moves as much
//! as its grippers.

use crate::estimator::NONE;
use crate::jacobian::square;
use crate::{Coordinates, INPUTS};

/// Initial and maximum variance: a rope moves about as much as its gripper.
const MOST_VARIANCE: f64 = 1.0;

/// Uncertainty of `J`.
#[derive(Debug, Clone)]
pub(crate) struct Kalman {
    p: [Coordinates; INPUTS],
    /// q, 1/px.
    drift_per_px: f64,
}

impl Kalman {
    pub(crate) fn new(drift: f64) -> Self {
        let mut p = [NONE; INPUTS];
        for (i, row) in p.iter_mut().enumerate() {
            row[i] = MOST_VARIANCE;
        }
        Self {
            p,
            drift_per_px: drift * drift / 100.0,
        }
    }

    /// Records that the column of an input was measured independently, with this variance.
    pub(crate) fn measured(&mut self, input: usize, variance: f64) {
        for row in &mut self.p {
            row[input] = 0.0;
        }
        self.p[input] = NONE;
        self.p[input][input] = variance.min(MOST_VARIANCE);
    }

    /// Returns the share of the innovation that each column takes, and updates `P`.
    pub(crate) fn gain(&mut self, dr: &Coordinates, noise_px2: f64) -> Coordinates {
        let way = square(dr).sqrt();
        self.drift(self.drift_per_px * way);
        // The pair measures the mean of `J` over its path, but `J` is wanted at the path's end. For
        // a random walk, the variance of the difference is a third of the walk's.
        let noise = noise_px2 + self.drift_per_px * way.powi(3) / 3.0;
        let along: Coordinates = std::array::from_fn(|i| dot(&self.p[i], dr));
        let below = dot(&along, dr) + noise;
        if below <= f64::MIN_POSITIVE {
            return NONE;
        }
        let gain = along.map(|along| along / below);
        self.narrow(dr, &gain, noise);
        gain
    }

    /// Adds `variance` to each variance, up to the maximum.
    fn drift(&mut self, variance: f64) {
        for i in 0..INPUTS {
            self.p[i][i] += variance;
            let share = (MOST_VARIANCE / self.p[i][i]).min(1.0).sqrt();
            // Scales row and column alike, so that the matrix remains a covariance.
            for j in 0..INPUTS {
                self.p[i][j] *= share;
                self.p[j][i] *= share;
            }
        }
    }

    /// Updates `P` in Joseph's form, which stays symmetric and positive despite rounding.
    fn narrow(&mut self, dr: &Coordinates, gain: &Coordinates, noise: f64) {
        let rest: [Coordinates; INPUTS] = std::array::from_fn(|i| {
            std::array::from_fn(|j| f64::from(u8::from(i == j)) - gain[i] * dr[j])
        });
        let half: [Coordinates; INPUTS] = std::array::from_fn(|i| {
            std::array::from_fn(|j| (0..INPUTS).map(|k| rest[i][k] * self.p[k][j]).sum())
        });
        for i in 0..INPUTS {
            for j in 0..INPUTS {
                self.p[i][j] = dot(&half[i], &rest[j]) + noise * gain[i] * gain[j];
            }
        }
    }
}

fn dot(a: &Coordinates, b: &Coordinates) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
