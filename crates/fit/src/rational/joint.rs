//! Joint covariance of the control points and the log-weights under noise in the points.
//!
//! To first order the log-weights `v` have the covariance `σ² V`, with `V` the inverse of their
//! normal matrix including the prior. The control points depend on them by `S = ∂p/∂v`, in addition
//! to their covariance at known weights (G. Golub, V. Pereyra, *Inverse Problems* 19, 2003, section
//! 5):
//!
//! ```text
//! σ² ⎡ C ⊗ I + S V Sᵀ   S V ⎤        S = −R⁺ (Rₖ ⊙ (pₖ − f))ₖ
//!    ⎣ V Sᵀ             V   ⎦
//! ```
//!
//! Pinned ends affect the weights too, because the fit is to `c − R₀c₀ − Rₙc₍N₋₁₎`. The effect of
//! noise in one coordinate of an end on all parameters is a vector. Its outer product with itself
//! is added.

use super::covariance::Covariance;
use super::descent::Descent;
use super::design::Design;
use super::linearization::{Linearization, peak};
use super::triangular::{solve_lower, solve_lower_transposed};

/// Memory for the matrix and its parts.
pub(super) struct Joint {
    matrix: Vec<f64>,
    /// `V`.
    spread: Vec<f64>,
    /// `S`, a row for each coordinate of each control point.
    sensitivity: Vec<f64>,
    scratch: Vec<f64>,
    /// `L⁻¹ Q̃ᵀ R₀` or `L⁻¹ Q̃ᵀ Rₙ`.
    of_end: Vec<f64>,
    /// Effects of an end's noise: on the log-weights (this vector), and below on all parameters, at
    /// known and at estimated weights.
    to_weights: Vec<f64>,
    known: Vec<f64>,
    all: Vec<f64>,
}

impl Joint {
    pub(super) fn new(design: &Design, dimension: usize) -> Self {
        let count = design.count;
        let size = count * (dimension + 1);
        Self {
            matrix: vec![0.0; size * size],
            spread: vec![0.0; count * count],
            sensitivity: vec![0.0; count * dimension * count],
            scratch: Linearization::room_for_reachable(design, dimension),
            of_end: vec![0.0; design.free()],
            to_weights: vec![0.0; count],
            known: vec![0.0; size],
            all: vec![0.0; size],
        }
    }

    /// The matrix if the weights are known instead of estimated.
    pub(super) fn at_known_weights(
        &mut self,
        count: usize,
        dimension: usize,
        fixed: &[f64],
    ) -> &[f64] {
        self.spread.fill(0.0);
        self.sensitivity.fill(0.0);
        self.assemble(count, dimension, fixed);
        &self.matrix
    }

    /// Computes `V`, given the linearization at the curve.
    pub(super) fn set_spread(&mut self, descent: &mut Descent, variance: f64) {
        if !descent
            .region
            .invert(&descent.linearization, variance, &mut self.spread)
        {
            // If the matrix has no numerical inverse, the points bound no weight.
            self.spread.fill(f64::NAN);
        }
    }

    /// Computes `S`, given the linearization at the curve.
    pub(super) fn set_sensitivity<const D: usize>(
        &mut self,
        design: &Design,
        descent: &Descent,
        control_points: &[[f64; D]],
    ) {
        let (projection, linearization) = (&descent.projection, &descent.linearization);
        let (count, free, first) = (design.count, design.free(), design.first_free());
        let width = linearization.reachable_width;
        self.scratch.copy_from_slice(&linearization.reachable);
        solve_lower_transposed(&projection.factor, free, &mut self.scratch, width);
        design.to_bernstein(&mut self.scratch, width);
        self.sensitivity.fill(0.0);
        for (j, along) in self.scratch.chunks_exact(width).enumerate() {
            let point = first + j;
            for axis in 0..D {
                let row = &mut self.sensitivity[(point * D + axis) * count..][..count];
                for (number, along) in row.iter_mut().zip(&along[axis * count..]) {
                    *number = -along / projection.weights[point];
                }
                // The linearization uses a point near the curve instead of the control point.
                let near = descent.points[axis * design.stride + peak(design, point)];
                row[point] -= control_points[point][axis] - near;
            }
        }
    }

    /// Assembles the matrix given `C`, without the effect of pinned ends on the weights.
    pub(super) fn assemble(&mut self, count: usize, dimension: usize, fixed: &[f64]) {
        let (coordinates, size) = (count * dimension, count * (dimension + 1));
        let row = |k: usize| k * count..(k + 1) * count;
        for k in 0..coordinates {
            let sensitivity = &self.sensitivity[row(k)];
            // S V.
            for l in 0..count {
                let spread = &self.spread[row(l)];
                let sum: f64 = sensitivity.iter().zip(spread).map(|(s, v)| s * v).sum();
                self.matrix[k * size + coordinates + l] = sum;
                self.matrix[(coordinates + l) * size + k] = sum;
            }
            for l in 0..=k {
                let mixed = &self.matrix[k * size + coordinates..][..count];
                let other = &self.sensitivity[row(l)];
                let mut sum: f64 = mixed.iter().zip(other).map(|(a, b)| a * b).sum();
                if k % dimension == l % dimension {
                    sum += fixed[k / dimension * count + l / dimension];
                }
                self.matrix[k * size + l] = sum;
                self.matrix[l * size + k] = sum;
            }
        }
        for k in 0..count {
            let to = (coordinates + k) * size + coordinates;
            self.matrix[to..to + count].copy_from_slice(&self.spread[k * count..][..count]);
        }
    }

    /// The matrix, row by row, with the effect of pinned ends on the weights.
    pub(super) fn with_ends(
        &mut self,
        design: &Design,
        descent: &Descent,
        covariance: &Covariance,
        dimension: usize,
    ) -> &[f64] {
        let (projection, linearization) = (&descent.projection, &descent.linearization);
        if design.pinned {
            for (side, end) in [0, design.count - 1].into_iter().enumerate() {
                let rational = &projection.rational[end * design.stride..][..design.stride];
                for (number, basis) in self
                    .of_end
                    .iter_mut()
                    .zip(projection.scaled.chunks_exact(design.stride))
                {
                    *number = dot(basis, rational);
                }
                solve_lower(&projection.factor, design.free(), &mut self.of_end, 1);
                for axis in 0..dimension {
                    self.set_to_weights(design, linearization, rational, axis, dimension);
                    self.set_responses(design, covariance, (side, end), axis, dimension);
                    let size = self.all.len();
                    for (k, row) in self.matrix.chunks_exact_mut(size).enumerate() {
                        for (l, number) in row.iter_mut().enumerate() {
                            *number += self.all[k] * self.all[l] - self.known[k] * self.known[l];
                        }
                    }
                }
            }
        }
        &self.matrix
    }

    /// Computes `V (P Jₐ)ᵀ R` for an axis' changes `Jₐ` and an end's `R`.
    fn set_to_weights(
        &mut self,
        design: &Design,
        linearization: &Linearization,
        rational: &[f64],
        axis: usize,
        dimension: usize,
    ) {
        let (count, width) = (design.count, linearization.reachable_width);
        self.to_weights.fill(0.0);
        for k in 0..count {
            let changes = &linearization.changes[(k * dimension + axis) * design.stride..];
            let mut along = dot(changes, rational);
            for (j, of_end) in self.of_end.iter().enumerate() {
                along -= linearization.reachable[j * width + axis * count + k] * of_end;
            }
            for (to, spread) in self.to_weights.iter_mut().zip(&self.spread[k * count..]) {
                *to += spread * along;
            }
        }
    }

    /// Computes the effect of noise in an end's coordinate on all parameters.
    fn set_responses(
        &mut self,
        design: &Design,
        covariance: &Covariance,
        (side, end): (usize, usize),
        axis: usize,
        dimension: usize,
    ) {
        let (count, coordinates) = (design.count, design.count * dimension);
        self.known.fill(0.0);
        self.known[end * dimension + axis] = 1.0;
        for (k, of_ends) in covariance.of_ends.iter().enumerate() {
            self.known[(k + 1) * dimension + axis] = -of_ends[side];
        }
        self.all.copy_from_slice(&self.known);
        for (all, row) in self
            .all
            .iter_mut()
            .zip(self.sensitivity.chunks_exact(count))
        {
            *all -= dot(row, &self.to_weights);
        }
        for (all, to) in self.all[coordinates..].iter_mut().zip(&self.to_weights) {
            *all = -to;
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
