//! Quadratic models of the squared residuals near given log-weights `vₖ = ln wₖ`.
//!
//! The residuals change by `P (Rₖ ⊙ (f − pₖ))`, where `P` removes what the control points can
//! represent (L. Kaufman's approximation, *BIT* 15, 1975; the omitted term is proportional to `r`).
//! `P` also removes `Rₖ pₖ` if `pₖ` is free, so any point may replace `pₖ`. A point near the curve
//! at `Bₖ`'s peak keeps the numbers small. Pinned end points are used as they are.

use super::design::Design;
use super::kernels::{Part, Rows, add_multiple, multiply, padded, products, rows};
use super::projection::Projection;
use super::triangular::solve_lower;
use lariat_portable::{Simd, WithSimd};

/// Quadratic model of the squared residuals. The models differ in the center of the derivative: the
/// curve plus a multiple of the residuals.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Model {
    /// Around the points, `f + r`: the model whose residuals are linear in the weights themselves
    /// (C. Sanathanan, J. Koerner, *IEEE Transactions on Automatic Control* 8, 1963). It works from
    /// any distance, but is biased by noise.
    Linear,
    /// Around the curve: Gauss-Newton with Kaufman's approximation. Never indefinite.
    GaussNewton,
    /// Around `f − r`: Newton's method. Differentiating twice and eliminating the control points
    /// gives `∂²(|r|²/2) = P(Rₖ ⊙ (pₖ − f + r)) · P(Rₗ ⊙ (pₗ − f + r)) − Σ Rₖ Rₗ |r|² − δₖₗ Σ r ·
    /// Rₖ (pₖ − f)`.
    Newton,
}

/// Derivatives of the residuals with respect to the log-weights.
pub(super) struct Linearization {
    /// `Rₖ ⊙ (pₖ − f)`: `count` rows, one axis after the other.
    pub(super) changes: Vec<f64>,
    /// `L⁻¹ Q̃ᵀ` times `changes`: `free` rows, `count` numbers per axis, one axis after the other,
    /// padded.
    pub(super) reachable: Vec<f64>,
    pub(super) reachable_width: usize,
    /// Transpose of `reachable`, with a log-weight's numbers in a row, padded.
    transposed: Vec<f64>,
    /// Center of the derivative, one axis after the other.
    center: Vec<f64>,
    /// Lower triangle of the normal equations' matrix, `count × count`.
    pub(super) normal: Vec<f64>,
    /// Their right-hand side.
    pub(super) right: Vec<f64>,
    /// Sum of the squares of `changes`, before subtracting the products that give the normal
    /// matrix.
    pub(super) changes_squared: f64,
    /// `|r|` on the grid.
    lengths: Vec<f64>,
    /// `Rₖ |r|` on the grid.
    shares: Vec<f64>,
    /// Products that are subtracted from the normal matrix.
    excess: Vec<f64>,
}

impl Linearization {
    /// Allocates memory of the size of `reachable`.
    pub(super) fn room_for_reachable(design: &Design, dimension: usize) -> Vec<f64> {
        vec![0.0; design.free() * padded(dimension * design.count)]
    }

    pub(super) fn new(design: &Design, dimension: usize) -> Self {
        let count = design.count;
        Self {
            changes: vec![0.0; count * dimension * design.stride],
            reachable: Self::room_for_reachable(design, dimension),
            reachable_width: padded(dimension * count),
            transposed: vec![0.0; count * padded(dimension * design.free())],
            center: vec![0.0; dimension * design.stride],
            normal: vec![0.0; count * count],
            right: vec![0.0; count],
            changes_squared: 0.0,
            lengths: vec![0.0; design.stride],
            shares: vec![0.0; count * design.stride],
            excess: vec![0.0; count * count],
        }
    }
}

/// Sets up the normal equations of a step from the projection.
pub(super) struct Linearize<'a> {
    pub(super) design: &'a Design,
    /// The points, one axis after the other.
    pub(super) points: &'a [f64],
    pub(super) projection: &'a Projection,
    pub(super) model: Model,
    pub(super) linearization: &'a mut Linearization,
}

impl WithSimd for Linearize<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self {
            design,
            points,
            projection,
            model,
            linearization,
        } = self;
        let (count, free, stride) = (design.count, design.free(), design.stride);
        let length = points.len();
        linearization.set_changes(design, points, projection, model);
        let changes = rows(&linearization.changes, length);
        let width = linearization.reachable_width;
        for axis in 0..length / stride {
            let along = Rows {
                numbers: &linearization.changes[axis * stride..],
                ..changes
            };
            let out = linearization
                .reachable
                .get_mut(axis * count..)
                .unwrap_or_default();
            let basis = rows(&projection.scaled, stride);
            products(simd, [basis, along], stride, Part::All, out, width);
        }
        solve_lower(
            &projection.factor,
            free,
            &mut linearization.reachable,
            width,
        );
        products(
            simd,
            [changes, changes],
            length,
            Part::Lower,
            &mut linearization.normal,
            count,
        );
        linearization.changes_squared = linearization.normal.iter().step_by(count + 1).sum();
        let residuals = rows(&projection.residuals, length);
        products(
            simd,
            [changes, residuals],
            length,
            Part::All,
            &mut linearization.right,
            1,
        );
        linearization.take_reachable(simd, count, length / stride);
        if model == Model::Newton {
            linearization.correct(simd, design, projection);
        }
    }
}

impl Linearization {
    /// Computes `Rₖ ⊙ (pₖ − f − share · r)`.
    #[inline(always)]
    fn set_changes(
        &mut self,
        design: &Design,
        points: &[f64],
        projection: &Projection,
        model: Model,
    ) {
        let stride = design.stride;
        self.center.copy_from_slice(&projection.curve);
        let share = match model {
            Model::Linear => 1.0,
            Model::GaussNewton => 0.0,
            Model::Newton => -1.0,
        };
        add_multiple(&mut self.center, share, &projection.residuals);
        let rational = projection.rational.chunks_exact(stride);
        for (k, (changes, rational)) in self
            .changes
            .chunks_exact_mut(points.len())
            .zip(rational)
            .enumerate()
        {
            let peak = peak(design, k);
            let axes = self
                .center
                .chunks_exact(stride)
                .zip(points.chunks_exact(stride));
            for (changes, (center, points)) in changes.chunks_exact_mut(stride).zip(axes) {
                let near = points[peak];
                for ((change, r), center) in changes.iter_mut().zip(rational).zip(center) {
                    *change = r * (near - center);
                }
            }
        }
    }

    /// Subtracts the products of the part that the basis can represent from the normal matrix.
    #[inline(always)]
    fn take_reachable<S: Simd>(&mut self, simd: S, count: usize, dimension: usize) {
        let width = self.reachable_width;
        let length = self.transposed.len() / count;
        for (j, row) in self.reachable.chunks_exact(width).enumerate() {
            for (axis, row) in row.chunks_exact(count).take(dimension).enumerate() {
                for (k, number) in row.iter().enumerate() {
                    self.transposed[k * length + j * dimension + axis] = *number;
                }
            }
        }
        let transposed = Rows {
            numbers: &self.transposed,
            stride: length,
            count,
        };
        products(
            simd,
            [transposed, transposed],
            length,
            Part::Lower,
            &mut self.excess,
            count,
        );
        add_multiple(&mut self.normal, -1.0, &self.excess);
    }

    /// Adds the terms that Newton's normal matrix and right-hand side have in addition to the
    /// changes' products.
    #[inline(always)]
    fn correct<S: Simd>(&mut self, simd: S, design: &Design, projection: &Projection) {
        let (count, stride) = (design.count, design.stride);
        self.lengths.fill(0.0);
        for residuals in projection.residuals.chunks_exact(stride) {
            for (length, r) in self.lengths.iter_mut().zip(residuals) {
                *length += r * r;
            }
        }
        self.lengths
            .iter_mut()
            .for_each(|length| *length = length.sqrt());
        let rational = projection.rational.chunks_exact(stride);
        for (shares, rational) in self.shares.chunks_exact_mut(stride).zip(rational) {
            multiply(shares, 1.0, rational, &self.lengths);
        }
        let (shares, lengths) = (rows(&self.shares, stride), rows(&self.lengths, stride));
        products(
            simd,
            [shares, shares],
            stride,
            Part::Lower,
            &mut self.excess,
            count,
        );
        add_multiple(&mut self.normal, -1.0, &self.excess);
        products(
            simd,
            [shares, lengths],
            stride,
            Part::All,
            &mut self.excess,
            1,
        );
        for (k, (right, excess)) in self.right.iter_mut().zip(&self.excess).enumerate() {
            *right -= excess;
            self.normal[k * (count + 1)] -= *right;
        }
    }
}

/// The point of the grid nearest to the maximum of polynomial `k`, at `k/n`.
pub(super) fn peak(design: &Design, k: usize) -> usize {
    let order = design.count - 1;
    (k * (design.points - 1) + order / 2) / order
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rational::projection::Project;
    use proptest::prelude::*;

    const POINTS: usize = 30;

    /// Half the squared residuals at these log-weights, their gradient and their second
    /// derivatives.
    fn quadratic(
        design: &Design,
        points: &[f64],
        log_weights: &[f64],
        model: Model,
    ) -> (f64, Vec<f64>, Vec<f64>) {
        let mut projection = Projection::new(design, 2);
        let mut linearization = Linearization::new(design, 2);
        for (weight, v) in projection.weights.iter_mut().zip(log_weights) {
            *weight = libm::exp(*v);
        }
        let arch = lariat_portable::Arch::new();
        arch.dispatch(Project {
            design,
            points,
            projection: &mut projection,
        });
        arch.dispatch(Linearize {
            design,
            points,
            projection: &projection,
            model,
            linearization: &mut linearization,
        });
        let gradient = linearization.right.iter().map(|right| -right).collect();
        (0.5 * projection.squared, gradient, linearization.normal)
    }

    fn padded_points(design: &Design, points: &[[f64; 2]]) -> Vec<f64> {
        let mut axes = vec![0.0; 2 * design.stride];
        for (i, point) in points.iter().enumerate() {
            axes[i] = point[0];
            axes[design.stride + i] = point[1];
        }
        axes
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        /// Central differences with a step of 1e-4 have an error of about 1e-8 of the third
        /// derivatives, which are of the same size as the function.
        #[test]
        fn gradient_and_second_derivatives_are_those_of_the_squared_residuals(
            order in 1usize..=6,
            pinned in any::<bool>(),
            points in prop::collection::vec(prop::array::uniform2(0.0f64..100.0), POINTS),
            log_weights in prop::collection::vec(-1.0f64..1.0, 7),
        ) {
            let design = Design::new(order, POINTS, pinned);
            let count = order + 1;
            let points = padded_points(&design, &points);
            let log_weights = &log_weights[..count];
            let (value, gradient, second) = quadratic(&design, &points, log_weights, Model::Newton);
            let (_, same, _) = quadratic(&design, &points, log_weights, Model::GaussNewton);
            for k in 0..count {
                prop_assert!((gradient[k] - same[k]).abs() < 1e-9 * value);
                let step = 1e-4;
                let [before, after] = [-step, step].map(|step| {
                    let mut moved = log_weights.to_vec();
                    moved[k] += step;
                    quadratic(&design, &points, &moved, Model::Newton)
                });
                let slope = (after.0 - before.0) / (2.0 * step);
                prop_assert!((gradient[k] - slope).abs() < 1e-6 * value, "{} {slope}", gradient[k]);
                for l in k..count {
                    let bend = (after.1[l] - before.1[l]) / (2.0 * step);
                    let found = second[l * count + k];
                    prop_assert!((found - bend).abs() < 1e-6 * value, "{k} {l}: {found} {bend}");
                }
            }
        }

        /// The residuals times the denominator are linear in the weights. For points on a curve,
        /// one step from the polynomial therefore finds its weights.
        #[test]
        fn the_linear_model_goes_to_an_exact_curves_weights_at_once(
            control_points in prop::collection::vec(prop::array::uniform2(0.0f64..100.0), 4),
            weights in prop::collection::vec(0.5f64..2.0, 4),
        ) {
            let design = Design::new(3, POINTS, false);
            let row = |k: usize, i: usize| weights[k] * design.b[k * design.stride + i];
            let points: Vec<[f64; 2]> = (0..POINTS)
                .map(|i| {
                    let sum: f64 = (0..4).map(|k| row(k, i)).sum();
                    [0, 1].map(|axis| (0..4).map(|k| row(k, i) * control_points[k][axis] / sum).sum())
                })
                .collect();
            let points = padded_points(&design, &points);
            let (value, gradient, second) = quadratic(&design, &points, &[0.0; 4], Model::Linear);
            // At the true weights, scaled so that their steps from 1 sum to 0, the slope is 0.
            let mean = weights.iter().sum::<f64>() / 4.0;
            for k in 0..4 {
                let at = |l: usize| second[k.max(l) * 4 + k.min(l)] * (weights[l] / mean - 1.0);
                let slope = gradient[k] + (0..4).map(at).sum::<f64>();
                prop_assert!(slope.abs() < 1e-9 * (1.0 + value), "{k}: {slope}");
            }
        }
    }
}
