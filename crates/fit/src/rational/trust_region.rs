//! The best step of limited length on a quadratic, found by damping (J. Moré, D. Sorensen, *SIAM
//! Journal on Scientific and Statistical Computing* 4, 1983), with the prior of the log-weights.

use super::belief::Belief;
use super::linearization::Linearization;
use super::triangular::{factorize, solve_lower, solve_lower_transposed};

/// Maximum number of dampings tried for a step; three or four are usually enough.
const DAMPINGS: usize = 20;

/// A step may exceed the requested length by this factor, as the radius itself is not precise.
const TOLERANCE: f64 = 1.2;

/// A computed step.
#[derive(Clone, Copy)]
pub(super) struct Step {
    /// Length in standard deviations of the posterior.
    pub(super) distance: f64,
    /// Length in log-weights.
    pub(super) length: f64,
    /// Expected decrease of Φ.
    pub(super) promised: f64,
    /// True if the step was not shortened.
    pub(super) whole: bool,
}

/// Computes steps.
pub(super) struct TrustRegion {
    /// The last computed step.
    pub(super) step: Vec<f64>,
    hessian: Vec<f64>,
    scratch: Vec<f64>,
}

impl TrustRegion {
    pub(super) fn new(count: usize) -> Self {
        Self {
            step: vec![0.0; count],
            hessian: vec![0.0; count * count],
            scratch: vec![0.0; count],
        }
    }

    /// Computes a step of at most about `radius`. Returns `None` if the quadratic has no minimum.
    pub(super) fn solve(
        &mut self,
        linearization: &Linearization,
        log_weights: &[f64],
        variance: f64,
        radius: f64,
    ) -> Option<Step> {
        let count = self.step.len();
        let ridge = Belief::ridge(variance);
        let mut damping = 0.0;
        for _ in 0..DAMPINGS {
            if !self.factorize(linearization, ridge + damping) {
                return None;
            }
            let right = linearization.right.iter().zip(log_weights);
            for (step, (right, v)) in self.step.iter_mut().zip(right) {
                *step = right - ridge * v;
            }
            solve_lower(&self.hessian, count, &mut self.step, 1);
            let squared = squared_length(&self.step);
            solve_lower_transposed(&self.hessian, count, &mut self.step, 1);
            let length = squared_length(&self.step).sqrt();
            if length <= TOLERANCE * radius {
                return Some(Step {
                    distance: (squared / variance).sqrt(),
                    length,
                    promised: (squared + damping * length * length) / variance,
                    whole: damping == 0.0,
                });
            }
            // Newton's iteration for the damping that makes the step `radius` long.
            self.scratch.copy_from_slice(&self.step);
            solve_lower(&self.hessian, count, &mut self.scratch, 1);
            damping += length * length / squared_length(&self.scratch) * (length - radius) / radius;
        }
        None
    }

    /// Factorizes the normal matrix with a ridge. Returns whether it is positive definite.
    fn factorize(&mut self, linearization: &Linearization, ridge: f64) -> bool {
        let count = self.step.len();
        let normal = &linearization.normal;
        let mean = normal.iter().step_by(count + 1).sum::<f64>() / count as f64;
        // A common factor of all weights has no effect. Adding a constant to all entries makes that
        // direction nonsingular.
        for (to, from) in self.hessian.iter_mut().zip(normal) {
            *to = from + mean.abs() / count as f64;
        }
        // The normal matrix is a difference, so its error is ε times the terms.
        let unknown = f64::EPSILON * linearization.changes_squared;
        for diagonal in self.hessian.iter_mut().step_by(count + 1) {
            *diagonal += ridge + unknown;
        }
        factorize(&mut self.hessian, count)
    }

    /// Writes the inverse of the normal matrix with the prior's ridge to `inverse`, without the
    /// component of a common factor of all weights. Returns whether the inverse exists.
    pub(super) fn invert(
        &mut self,
        linearization: &Linearization,
        variance: f64,
        inverse: &mut [f64],
    ) -> bool {
        let count = self.step.len();
        if !self.factorize(linearization, Belief::ridge(variance)) {
            return false;
        }
        inverse.fill(0.0);
        inverse.iter_mut().step_by(count + 1).for_each(|d| *d = 1.0);
        solve_lower(&self.hessian, count, inverse, count);
        solve_lower_transposed(&self.hessian, count, inverse, count);
        for row in inverse.chunks_exact_mut(count) {
            let mean = row.iter().sum::<f64>() / count as f64;
            row.iter_mut().for_each(|number| *number -= mean);
        }
        true
    }
}

fn squared_length(numbers: &[f64]) -> f64 {
    numbers.iter().map(|x| x * x).sum()
}
