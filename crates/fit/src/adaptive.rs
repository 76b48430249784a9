//! A basis of fixed size whose algebra changes with the points, because they have different weights
//! or their own arc lengths.

use crate::arc_length;
use crate::basis::{Basis, Knots};
use crate::error::FitError;
use crate::factor::Qr;
use crate::fitter::Residuals;
use crate::functions::{self, MAX_KNOTS};
use crate::linear::Linear;
use crate::matrix::{product, row_by_row};
use crate::options::{Options, Rho, Weights};
use crate::system::System;
use crate::weighted::{Problem, Weighted};
use faer::MatRef;

pub(crate) struct Adaptive<const D: usize> {
    weighted: Weighted<D>,
    basis: Basis,
    /// `B`, N × m, row by row.
    b: Vec<f64>,
    /// `R⁻¹` from the QR of `B` on the even grid with the ridge's rows below it, m × m, row by row.
    r_inverse: Vec<f64>,
    /// `λDᵀD`, m × m, row by row.
    ridge: Option<Vec<f64>>,
    /// The points' ρ.
    rho: Vec<f64>,
    knots: [f64; MAX_KNOTS],
    knot_count: usize,
    /// Condition number of the last fit.
    condition: f64,
    ones: Vec<f64>,
}

impl<const D: usize> Adaptive<D> {
    pub(crate) fn new(linear: &Linear<D>, options: &Options) -> Self {
        let (points, count) = (linear.b.nrows(), linear.b.ncols());
        let system = System::new(linear.basis, linear.b.clone(), options.ridge, false);
        let r_inverse = Qr::new(system.a.as_ref()).inverse_of_r();
        let ridge = product(system.penalty.transpose(), system.penalty.as_ref());
        let mut own = [0.0; MAX_KNOTS];
        own[..linear.knots.len()].copy_from_slice(&linear.knots);
        Self {
            weighted: Weighted::new(points, count),
            basis: linear.basis,
            b: row_by_row(linear.b.as_ref()),
            r_inverse: row_by_row(r_inverse.as_ref()),
            ridge: (options.ridge > 0.0).then(|| row_by_row(ridge.as_ref())),
            rho: (0..points)
                .map(|i| linear.basis.even_rho(i, points))
                .collect(),
            knots: own,
            knot_count: linear.knots.len(),
            condition: linear.condition,
            ones: vec![1.0; points],
        }
    }

    /// Fits control points to these points. Weights are 1 by default. Does not allocate.
    pub(crate) fn fit(
        &mut self,
        points: &[[f64; D]],
        weights: Option<&[f64]>,
        options: &Options,
        control_points: &mut [[f64; D]],
    ) -> Result<Residuals, FitError> {
        if options.rho == Rho::Measured {
            self.measure(points)?;
        }
        let problem = Problem {
            b: &self.b,
            r_inverse: &self.r_inverse,
            points,
            weights: weights.unwrap_or(&self.ones),
            pins: options.pin_ends,
            ridge: self.ridge.as_deref(),
        };
        let weighted = &mut self.weighted;
        let (fit, variance) = if options.weights == Weights::Robust {
            let robust = weighted.huber(&problem, control_points)?;
            // Outliers count in the sum of squares, but not in the median.
            (robust.fit, robust.sigma_px * robust.sigma_px)
        } else {
            let fit = weighted.solve(&problem, control_points)?;
            let freedom = D as f64 * fit.degrees_of_freedom;
            // Rounding may leave a tiny number instead of 0.
            let variance = if freedom > 1e-6 {
                fit.sum_w_r2 / freedom
            } else {
                0.0
            };
            (fit, variance)
        };
        // The condition number of the normal equations is the square of the problem's own.
        self.condition = fit.condition.sqrt();
        Ok(Residuals {
            weighted_sum: fit.sum_w_r2,
            weights: weighted.weights().iter().sum(),
            max_px: fit.max_px,
            variance,
        })
    }

    /// Evaluates `B` at the points' ρ.
    fn measure(&mut self, points: &[[f64; D]]) -> Result<(), FitError> {
        arc_length::rho(points, self.basis.is_closed(), &mut self.rho)?;
        if let Basis::BSpline {
            knots: Knots::Averaged,
            ..
        } = self.basis
        {
            self.knot_count = functions::knots(self.basis, &self.rho, &mut self.knots);
        }
        let knots = &self.knots[..self.knot_count];
        let count = self.basis.control_points();
        for (row, &rho) in self.b.chunks_exact_mut(count).zip(&self.rho) {
            functions::values(self.basis, knots, rho, row);
        }
        Ok(())
    }

    /// Values of the basis functions at the `i`-th point.
    pub(crate) fn row(&self, i: usize) -> &[f64] {
        let count = self.basis.control_points();
        &self.b[i * count..][..count]
    }

    /// Clamped knots of the last fit's B-spline, or an empty slice.
    pub(crate) fn knots(&self) -> &[f64] {
        &self.knots[..self.knot_count]
    }

    /// Condition number of the problem that the last fit solved, in most cases accurate to a factor
    /// of √2.
    pub(crate) fn condition(&self) -> f64 {
        self.condition
    }

    /// `C` of the last fit, m × m.
    pub(crate) fn covariance(&self) -> MatRef<'_, f64> {
        let count = self.basis.control_points();
        MatRef::from_row_major_slice(self.weighted.covariance(), count, count)
    }
}
