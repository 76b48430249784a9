//! The best step of at most a given length on a quadratic, by damping it (J. Moré, D. Sorensen, *SIAM Journal
//! on Scientific and Statistical Computing* 4, 1983), with the prior of the log-weights.

use super::belief::Belief;
use super::linearization::Linearization;
use super::triangular::{factorize, solve_lower, solve_lower_transposed};

/// The most tries at the damping of a step; three or four do.
const DAMPINGS: usize = 20;

/// A step may be longer than asked for by this factor: the radius itself is no sharper.
const TOLERANCE: f64 = 1.2;

/// A step that has been solved for.
#[derive(Clone, Copy)]
pub(super) struct Step {
    /// Its length in standard deviations of the posterior.
    pub(super) distance: f64,
    /// Its length in log-weights.
    pub(super) length: f64,
    /// What it should lower Φ by.
    pub(super) promised: f64,
    /// Whether it was not shortened.
    pub(super) whole: bool,
}

/// Room for a step.
pub(super) struct TrustRegion {
    /// The step that was solved for last.
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

    /// Solves for the step of at most about `radius`. `None` where the quadratic has no lowest place.
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

    /// Factorizes the normal matrix with a ridge. Answers whether it is positive definite.
    fn factorize(&mut self, linearization: &Linearization, ridge: f64) -> bool {
        let count = self.step.len();
        let normal = &linearization.normal;
        let mean = normal.iter().step_by(count + 1).sum::<f64>() / count as f64;
        // All weights alike change nothing: the same number everywhere gives that direction a size.
        for (to, from) in self.hessian.iter_mut().zip(normal) {
            *to = from + mean.abs() / count as f64;
        }
        // The normal matrix is a difference, known to ε of what it is a difference of.
        let unknown = f64::EPSILON * linearization.changes_squared;
        for diagonal in self.hessian.iter_mut().step_by(count + 1) {
            *diagonal += ridge + unknown;
        }
        factorize(&mut self.hessian, count)
    }

    /// Writes the inverse of the normal matrix with the prior's ridge to `inverse`, what it says of all
    /// weights alike taken out. Answers whether there is one.
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
