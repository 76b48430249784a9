//! A fitter: everything that does not depend on the points, computed once; and the fit of one centerline.

use crate::condition;
use crate::error::{FitError, FitterError};
use crate::folded::{FoldedPoints, FoldedRows, fold_negated};
use crate::kernel::{FoldPoints, Residuals};
use crate::options::{Basis, Options, Solver};
use crate::solve::{QrOfB, Solve};
use faer::Mat;

/// Coordinates of this size or more are refused: no sensor is near it, and the squares of residuals stay
/// exact enough to mean something below it.
pub const MAX_COORDINATE_PX: f64 = 1e9;

/// A curve fitted to a centerline, and how well it fits.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// The descriptor `s`: `n + 1` control points, in the points' unit (px).
    pub control_points: Vec<[f64; 2]>,
    /// Root of the mean squared distance between a point and the curve at that point's `ρ`, px.
    pub rms_px: f64,
    /// The largest of these distances, px.
    pub max_px: f64,
    /// The variance of one coordinate's residual, px²: the sum of squares by its `2 (N − (n+1))` degrees of
    /// freedom. 0 where the curve goes through every point (`N = n + 1`), as nothing is left to tell it by.
    pub residual_variance: f64,
}

/// Fits Bezier curves to centerlines of one number of points, evenly spaced by arc length.
pub struct Fitter {
    options: Options,
    condition: f64,
    /// `(BᵀB)⁻¹Bᵀ`, column-major N × (n+1): its columns are the rows that [`Fitter::matrix`] gives.
    matrix: Mat<f64>,
    curve: FoldedRows,
    solve: Solve,
    arch: pulp::Arch,
    points: FoldedPoints,
    even: Vec<[f64; 2]>,
    odd: Vec<[f64; 2]>,
    fit: Fit,
}

impl Fitter {
    /// Computes all that a fit needs beside the points, on the uniform grid `ρᵢ = i/(N − 1)`, `i` from 0.
    ///
    /// # Errors
    /// An order or number of points out of range, fewer points than control points, or a condition number
    /// that would drown the control points in rounding errors; with the nearest that is allowed.
    pub fn new(options: Options) -> Result<Self, FitterError> {
        let (b, condition) = condition::checked_matrix(&options)?;
        let mut factors = QrOfB::new(&b);
        let pseudoinverse = mirrored_mean(&factors.pseudoinverse());
        let solve = match options.solver {
            Solver::Pinv => Solve::pinv(&pseudoinverse),
            // The condition number has been checked, so the factor exists.
            Solver::Cholesky => Solve::cholesky(&b).ok_or(FitterError::IllConditioned {
                order: options.order,
                points: options.points,
                solver: options.solver,
                condition,
                limit: condition::limit(options.solver),
                highest_order: options.order - 1,
            })?,
            Solver::Qr => Solve::qr(factors),
        };
        let count = options.order + 1;
        Ok(Self {
            options,
            condition,
            matrix: pseudoinverse.transpose().to_owned(),
            curve: FoldedRows::of_curve(b.transpose()),
            solve,
            arch: pulp::Arch::new(),
            points: FoldedPoints::new(options.points),
            even: vec![[0.0; 2]; count.div_ceil(2)],
            odd: vec![[0.0; 2]; count / 2],
            fit: Fit {
                control_points: vec![[0.0; 2]; count],
                rms_px: 0.0,
                max_px: 0.0,
                residual_variance: 0.0,
            },
        })
    }

    /// The curve nearest to `points` in the least-squares sense. Allocates nothing; the result stands until
    /// the next fit.
    ///
    /// `points` are pixels, ordered along the curve, evenly spaced by arc length.
    ///
    /// # Errors
    /// Another number of points than the fitter was made for, or one that is no place in a picture.
    pub fn fit(&mut self, points: &[[f64; 2]]) -> Result<&Fit, FitError> {
        if points.len() != self.options.points {
            return Err(FitError::Count {
                given: points.len(),
                expected: self.options.points,
            });
        }
        let inside = self.arch.dispatch(FoldPoints {
            points,
            bound: MAX_COORDINATE_PX,
            folded: &mut self.points,
        });
        if !inside && let Some(misplaced) = first_misplaced(points) {
            return Err(misplaced);
        }
        let control_points = &mut self.fit.control_points[..];
        self.solve.solve(
            self.arch,
            points,
            &self.points,
            [&mut self.even, &mut self.odd],
            control_points,
        );
        fold_negated(control_points, &mut self.even, &mut self.odd);
        let squared = self.arch.dispatch(Residuals {
            rows: &self.curve,
            points: &self.points,
            even: &self.even,
            odd: &self.odd,
            count: points.len(),
        });
        let freedom = 2 * (points.len() - self.fit.control_points.len());
        self.fit.rms_px = (squared.sum / points.len() as f64).sqrt();
        self.fit.max_px = squared.max.sqrt();
        self.fit.residual_variance = if freedom == 0 {
            0.0
        } else {
            squared.sum / freedom as f64
        };
        Ok(&self.fit)
    }

    /// What the fitter was made with.
    pub fn options(&self) -> &Options {
        &self.options
    }

    /// The family of curves that the control points belong to.
    pub fn basis(&self) -> Basis {
        Basis::Bezier
    }

    /// The condition number of `B` in the 2-norm: how much a relative error of the points can grow in the
    /// control points.
    pub fn condition(&self) -> f64 {
        self.condition
    }

    /// The `n + 1` rows of `(BᵀB)⁻¹Bᵀ`, `N` numbers each: row `j` times the points is control point `j`, the
    /// same for x and for y. It is the Jacobian of the descriptor by the points, and constant.
    pub fn matrix(&self) -> impl ExactSizeIterator<Item = &[f64]> {
        self.matrix.col_iter().map(|row| {
            // A column of an owned faer matrix is contiguous.
            row.try_as_col_major()
                .map_or(&[][..], |contiguous| contiguous.as_slice())
        })
    }
}

/// `m`, whose rows read backwards are its rows from the last to the first but for rounding, made so exactly:
/// the mean of itself and its mirror image.
fn mirrored_mean(m: &Mat<f64>) -> Mat<f64> {
    let (rows, columns) = (m.nrows(), m.ncols());
    Mat::from_fn(rows, columns, |j, i| {
        0.5 * (m[(j, i)] + m[(rows - 1 - j, columns - 1 - i)])
    })
}

/// The error that names the first point whose coordinates are out of bounds, if one is.
fn first_misplaced(points: &[[f64; 2]]) -> Option<FitError> {
    let misplaced = |p: &[f64; 2]| !p.iter().all(|c| c.abs() < MAX_COORDINATE_PX);
    let index = points.iter().position(misplaced)?;
    let [x, y] = points[index];
    Some(FitError::NotAPoint { index, x, y })
}
