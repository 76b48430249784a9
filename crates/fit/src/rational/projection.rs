//! Variable projection (G. Golub, V. Pereyra, *SIAM Journal on Numerical Analysis* 10, 1973). For
//! given weights, the control points are a linear least-squares problem, so only the weights remain
//! to be found. With `W(ρ) = Σ wⱼ Bⱼ(ρ)`, the curves of given weights are the polynomials divided
//! by `W`:
//!
//! ```text
//! Q̃ = Q / W           a basis of them            G = Q̃ᵀQ̃ = LLᵀ
//! f = Q̃ G⁻¹ Q̃ᵀ c      the nearest to the points   r = c − f
//! ```

use super::design::Design;
use super::kernels::{Part, Rows, add_multiple, multiply, products, rows, subtract};
use super::triangular::{factorize, solve_lower, solve_lower_transposed};
use lariat_portable::{Simd, WithSimd};

/// The best curve at given weights.
pub(super) struct Projection {
    /// The weights.
    pub(super) weights: Vec<f64>,
    /// `1/W` on the grid.
    inverse: Vec<f64>,
    /// `Q̃`, row by row.
    pub(super) scaled: Vec<f64>,
    /// The rational basis `Rₖ = wₖ Bₖ/W`, row by row.
    pub(super) rational: Vec<f64>,
    /// `L`.
    pub(super) factor: Vec<f64>,
    /// Coefficients of the curve in `Q̃`: `free × D`.
    pub(super) coefficients: Vec<f64>,
    /// The curve on the grid, one axis after the other.
    pub(super) curve: Vec<f64>,
    /// Points minus curve, one axis after the other.
    pub(super) residuals: Vec<f64>,
    /// Sum of the squared residuals.
    pub(super) squared: f64,
}

impl Projection {
    pub(super) fn new(design: &Design, dimension: usize) -> Self {
        let (free, stride) = (design.free(), design.stride);
        Self {
            weights: vec![1.0; design.count],
            inverse: vec![0.0; stride],
            scaled: vec![0.0; free * stride],
            rational: vec![0.0; design.count * stride],
            factor: vec![0.0; free * free],
            coefficients: vec![0.0; free * dimension],
            curve: vec![0.0; dimension * stride],
            residuals: vec![0.0; dimension * stride],
            squared: 0.0,
        }
    }

    /// The largest squared distance between a point and the curve at its `ρ`.
    pub(super) fn largest_squared(&self, design: &Design) -> f64 {
        (0..design.points)
            .map(|i| self.residuals[i..].iter().step_by(design.stride))
            .map(|axes| axes.map(|r| r * r).sum())
            .fold(0.0, f64::max)
    }
}

/// Finds the best curve at the projection's weights.
pub(super) struct Project<'a> {
    pub(super) design: &'a Design,
    /// The points, one axis after the other.
    pub(super) points: &'a [f64],
    pub(super) projection: &'a mut Projection,
}

impl WithSimd for Project<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self {
            design,
            points,
            projection,
        } = self;
        let (free, stride) = (design.free(), design.stride);
        let dimension = points.len() / stride;
        invert_denominator(design, &projection.weights, &mut projection.inverse);
        for (scaled, q) in projection
            .scaled
            .chunks_exact_mut(stride)
            .zip(design.q.chunks_exact(stride))
        {
            multiply(scaled, 1.0, q, &projection.inverse);
        }
        let bernstein = design.b.chunks_exact(stride).zip(&projection.weights);
        for (rational, (b, weight)) in projection.rational.chunks_exact_mut(stride).zip(bernstein) {
            multiply(rational, *weight, b, &projection.inverse);
        }
        // Start with the curve of the pinned ends alone, and with the residuals that they leave.
        projection.curve.fill(0.0);
        if design.pinned {
            let last = design.count - 1;
            let axes = projection
                .curve
                .chunks_exact_mut(stride)
                .zip(points.chunks_exact(stride));
            for (curve, points) in axes {
                add_multiple(curve, points[0], &projection.rational[..stride]);
                add_multiple(
                    curve,
                    points[design.points - 1],
                    &projection.rational[last * stride..],
                );
            }
        }
        subtract(&mut projection.residuals, points, &projection.curve);
        let basis = rows(&projection.scaled, stride);
        let residuals = rows(&projection.residuals, stride);
        products(
            simd,
            [basis, basis],
            stride,
            Part::Lower,
            &mut projection.factor,
            free,
        );
        products(
            simd,
            [basis, residuals],
            stride,
            Part::All,
            &mut projection.coefficients,
            dimension,
        );
        // Without a factor the curve is NaN, which no fit accepts.
        if !factorize(&mut projection.factor, free) {
            projection.factor.fill(f64::NAN);
        }
        solve_lower(
            &projection.factor,
            free,
            &mut projection.coefficients,
            dimension,
        );
        solve_lower_transposed(
            &projection.factor,
            free,
            &mut projection.coefficients,
            dimension,
        );
        for (q, sizes) in projection
            .scaled
            .chunks_exact(stride)
            .zip(projection.coefficients.chunks_exact(dimension))
        {
            for (curve, size) in projection.curve.chunks_exact_mut(stride).zip(sizes) {
                add_multiple(curve, *size, q);
            }
        }
        subtract(&mut projection.residuals, points, &projection.curve);
        let all = Rows {
            numbers: &projection.residuals,
            stride: dimension * stride,
            count: 1,
        };
        let mut squared = [0.0];
        products(
            simd,
            [all, all],
            dimension * stride,
            Part::All,
            &mut squared,
            1,
        );
        projection.squared = squared[0];
    }
}

#[inline(always)]
fn invert_denominator(design: &Design, weights: &[f64], inverse: &mut [f64]) {
    inverse.fill(0.0);
    for (b, weight) in design.b.chunks_exact(design.stride).zip(weights) {
        add_multiple(inverse, *weight, b);
    }
    inverse
        .iter_mut()
        .for_each(|number| *number = 1.0 / *number);
    // The padding after the last point is zero.
    inverse[design.points..].fill(0.0);
}
