//! Descends to the most probable log-weights: Gauss-Newton steps at a distance, Newton steps near
//! the end. A trust region limits each step.

use super::MAX_WEIGHT;
use super::belief::Belief;
use super::design::Design;
use super::linearization::{Linearization, Linearize, Model};
use super::projection::{Project, Projection};
use super::trust_region::{Step, TrustRegion};
use std::cmp::Ordering;

/// Stopping distance from the most probable weights, in standard deviations of the posterior.
/// Stopping there adds a hundredth to the variance.
const NEAR: f64 = 0.1;

/// Change of Φ that is negligible: far below `NEAR²`, and above the rounding of `ν ln s`.
const SLACK: f64 = 1e-9;

/// Maximum number of rounds of the linearized start. On an exact curve, each round removes most of
/// the residuals. On a noisy one, only noise is soon left.
const LINEAR_STEPS: usize = 8;

/// A round is worth repeating if it reduces a coordinate's variance below this share of its
/// previous value.
const MUCH: f64 = 0.5;

/// Initial maximum step length. A change of the weights by more than a factor of e is not small.
const RADIUS: f64 = 1.0;

/// Maximum step length.
const LARGEST_RADIUS: f64 = 4.0;

/// A search and its current state.
pub(super) struct Descent {
    arch: lariat_portable::Arch,
    /// The points, one axis after the other.
    pub(super) points: Vec<f64>,
    log_weights: Vec<f64>,
    /// The best log-weights so far, or the last frame's.
    kept: Vec<f64>,
    pub(super) region: TrustRegion,
    pub(super) projection: Projection,
    pub(super) linearization: Linearization,
}

/// Quality of the current log-weights.
struct Place {
    /// Φ.
    merit: f64,
    /// Estimated variance of a coordinate.
    variance: f64,
}

impl Descent {
    pub(super) fn new(design: &Design, dimension: usize) -> Self {
        let count = design.count;
        Self {
            arch: lariat_portable::Arch::new(),
            points: vec![0.0; dimension * design.stride],
            log_weights: vec![0.0; count],
            kept: vec![0.0; count],
            region: TrustRegion::new(count),
            projection: Projection::new(design, dimension),
            linearization: Linearization::new(design, dimension),
        }
    }

    pub(super) fn set_points<const D: usize>(&mut self, design: &Design, points: &[[f64; D]]) {
        for (axis, row) in self.points.chunks_exact_mut(design.stride).enumerate() {
            for (number, point) in row.iter_mut().zip(points) {
                *number = point[axis];
            }
        }
    }

    /// Point `i` as given.
    pub(super) fn point<const D: usize>(&self, design: &Design, i: usize) -> [f64; D] {
        std::array::from_fn(|axis| self.points[axis * design.stride + i])
    }

    /// Moves to the polynomial: all weights are 1.
    pub(super) fn start_at_polynomial(&mut self, design: &Design) {
        self.log_weights.fill(0.0);
        self.project(design);
    }

    pub(super) fn keep_weights(&mut self) {
        self.kept.copy_from_slice(&self.log_weights);
    }

    /// Moves to the weights that were kept.
    pub(super) fn restore_weights(&mut self, design: &Design) {
        self.log_weights.copy_from_slice(&self.kept);
        self.project(design);
    }

    pub(super) fn largest_log_weight(&self) -> f64 {
        self.log_weights
            .iter()
            .fold(0.0, |l: f64, v| l.max(v.abs()))
    }

    /// Moves to the solution of the linearized problem, starting from the polynomial. It is solved
    /// repeatedly while that helps much. Stays at the polynomial if that is better.
    pub(super) fn start_linearized(&mut self, design: &Design, belief: &Belief) {
        self.start_at_polynomial(design);
        let mut best = self.place(belief).merit;
        self.keep_weights();
        for _ in 0..LINEAR_STEPS {
            self.linearize(design, Model::Linear);
            let variance = belief.variance(self.projection.squared);
            if self.solve(variance, f64::INFINITY).is_none() {
                break;
            }
            for (v, step) in self.log_weights.iter_mut().zip(&self.region.step) {
                // The step is linear in the weights themselves, which must stay positive.
                *v = (*v + libm::log((1.0 + step).max(1.0 / MAX_WEIGHT)))
                    .clamp(-libm::log(MAX_WEIGHT), libm::log(MAX_WEIGHT));
            }
            self.recenter();
            self.project(design);
            let here = self.place(belief);
            let helps = here.variance < MUCH * variance;
            if here.merit.partial_cmp(&best) == Some(Ordering::Less) {
                best = here.merit;
                self.keep_weights();
            }
            if !helps {
                break;
            }
        }
        self.restore_weights(design);
    }

    /// Descends by at most `limit` steps. Returns whether it converged, and the number of steps.
    pub(super) fn descend(
        &mut self,
        design: &Design,
        belief: &Belief,
        limit: usize,
        mut model: Model,
    ) -> (bool, usize) {
        let mut here = self.place(belief);
        let mut radius = RADIUS;
        let mut last_distance = f64::INFINITY;
        self.linearize(design, model);
        for steps in 0..=limit {
            let mut solved = self.solve(here.variance, radius);
            if solved.is_none() && model == Model::Newton {
                model = Model::GaussNewton;
                self.linearize(design, model);
                solved = self.solve(here.variance, radius);
            }
            let Some(step) = solved else {
                return (false, steps);
            };
            // The remaining distance is only known if the whole step can be taken.
            let near = step.distance <= NEAR || belief.is_rounding(self.projection.squared);
            if step.whole && near {
                return (true, steps);
            }
            if steps == limit {
                break;
            }
            self.keep_weights();
            let Some(there) = self.advance(design, belief, &here) else {
                radius = 0.25 * step.length;
                continue;
            };
            radius = adapted(radius, &step, here.merit - there.merit);
            // The distance in terms of the new variance.
            let distance = step.distance * (here.variance / there.variance).sqrt();
            here = there;
            // Distances shrink by a similar factor from step to step, so the remaining distance is
            // the last one times that factor.
            if step.whole
                && distance * distance / last_distance <= NEAR
                && last_distance.is_finite()
            {
                return (true, steps + 1);
            }
            (last_distance, model) = if step.whole {
                (distance, Model::Newton)
            } else {
                (f64::INFINITY, Model::GaussNewton)
            };
            self.linearize(design, model);
        }
        (false, limit)
    }

    /// Takes the step, unless that would increase Φ.
    fn advance(&mut self, design: &Design, belief: &Belief, here: &Place) -> Option<Place> {
        for (v, step) in self.log_weights.iter_mut().zip(&self.region.step) {
            *v += step;
        }
        self.recenter();
        self.project(design);
        let there = self.place(belief);
        // Also rejects NaN.
        if there.merit.partial_cmp(&(here.merit + SLACK)) == Some(Ordering::Less) {
            Some(there)
        } else {
            self.log_weights.copy_from_slice(&self.kept);
            None
        }
    }

    fn place(&self, belief: &Belief) -> Place {
        Place {
            merit: belief.merit(self.projection.squared, &self.log_weights),
            variance: belief.variance(self.projection.squared),
        }
    }

    fn solve(&mut self, variance: f64, radius: f64) -> Option<Step> {
        self.region
            .solve(&self.linearization, &self.log_weights, variance, radius)
    }

    fn recenter(&mut self) {
        let mean = self.log_weights.iter().sum::<f64>() / self.log_weights.len() as f64;
        self.log_weights.iter_mut().for_each(|v| *v -= mean);
    }

    fn project(&mut self, design: &Design) {
        for (weight, v) in self.projection.weights.iter_mut().zip(&self.log_weights) {
            *weight = libm::exp(*v);
        }
        self.arch.dispatch(Project {
            design,
            points: &self.points,
            projection: &mut self.projection,
        });
    }

    /// Sets up the quadratic of this model at the current weights.
    pub(super) fn linearize(&mut self, design: &Design, model: Model) {
        self.arch.dispatch(Linearize {
            design,
            points: &self.points,
            projection: &self.projection,
            model,
            linearization: &mut self.linearization,
        });
    }
}

/// Maximum length of the next step, from the expected and the actual decrease of this one.
fn adapted(radius: f64, step: &Step, gained: f64) -> f64 {
    if gained > 0.75 * step.promised {
        radius.max(2.0 * step.length).min(LARGEST_RADIUS)
    } else if gained < 0.25 * step.promised {
        0.5 * step.length
    } else {
        radius
    }
}
