//! A basis of fixed size: all algebra that does not depend on the points, done once, and the fit
//! that uses it.

use crate::basis::Basis;
use crate::condition;
use crate::error::FitterError;
use crate::factor::Qr;
use crate::fitter::MAX_COORDINATE_PX;
use crate::folded::{Points, Rows};
use crate::kernel::{Describe, Fit, Load, Residuals, SquaredResiduals};
use crate::options::{Options, Solver};
use crate::solve::{Halves, Solve};
use crate::system::{self, Estimator, System};
use faer::Mat;

pub(crate) struct Linear<const D: usize> {
    pub(crate) basis: Basis,
    /// Clamped knots of a B-spline on the even grid; otherwise empty.
    pub(crate) knots: Vec<f64>,
    /// 2-norm condition number of the solved matrix: `B` without the pinned columns, with the
    /// ridge's rows below.
    pub(crate) condition: f64,
    /// `P` transposed, column-major N × m: its columns are the rows of `P`.
    pub(crate) matrix: Mat<f64>,
    /// `C = P Pᵀ`, m × m.
    pub(crate) covariance: Mat<f64>,
    /// `B`, N × m.
    pub(crate) b: Mat<f64>,
    /// Degrees of freedom of one coordinate's residuals.
    pub(crate) freedom: f64,
    solve: Solve,
    curve: Rows,
    halves: Halves<D>,
}

/// Factors of the system, and its condition number.
struct Factored {
    system: System,
    /// None if all control points are pinned.
    factors: Option<Qr>,
    condition: f64,
}

impl<const D: usize> Linear<D> {
    /// Computes the algebra on the basis's even knots.
    ///
    /// # Errors
    /// Fails if the condition number is so high that rounding errors would dominate the control
    /// points.
    pub(crate) fn new(basis: Basis, options: &Options) -> Result<Self, FitterError> {
        let knots = condition::even_knots(basis, options.points);
        Self::on_knots(basis, knots, options)
    }

    /// Like [`Linear::new`], with the given clamped knots of a B-spline.
    pub(crate) fn on_knots(
        basis: Basis,
        knots: Vec<f64>,
        options: &Options,
    ) -> Result<Self, FitterError> {
        let Options { points, solver, .. } = *options;
        let mirrored = condition::is_mirrored(basis);
        let (p, b, condition, solve, exact) = match system::selection(basis, points) {
            Some(p) => {
                let solve = Solve::pinv(p.as_ref(), false);
                let b = condition::matrix(basis, &knots, points);
                (p, b, 1.0, solve, false)
            }
            None => {
                let Factored {
                    system,
                    factors,
                    condition,
                } = Factored::new(basis, &knots, options);
                let refused = || refusal(basis, options, condition);
                if condition > condition::limit(solver) {
                    return Err(refused());
                }
                let p = system.estimator(factors.as_ref());
                let p = if mirrored { mirrored_mean(&p) } else { p };
                let solve = match (solver, factors) {
                    (Solver::Cholesky, Some(_)) => {
                        // The condition number has been checked, so the factor exists.
                        Solve::cholesky(&system, D, mirrored).ok_or_else(refused)?
                    }
                    (Solver::Qr, Some(factors)) => Solve::qr(&factors, &system, D, mirrored),
                    (Solver::Pinv, _) | (_, None) => Solve::pinv(p.as_ref(), mirrored),
                };
                let exact = system.offset() == 0 && system.penalty.nrows() == 0;
                (p, system.b, condition, solve, exact)
            }
        };
        let Estimator {
            p,
            covariance,
            freedom,
        } = Estimator::new(p, &b, exact);
        let count = basis.control_points();
        Ok(Self {
            basis,
            // Feature points have even knots, which are implied.
            knots: match basis {
                Basis::BSpline { .. } => knots,
                _ => Vec::new(),
            },
            condition,
            matrix: p.transpose().to_owned(),
            covariance,
            freedom,
            solve,
            curve: Rows::of_curve(b.transpose(), mirrored),
            b,
            halves: Halves::new(count),
        })
    }

    /// Computes the control points of these points, and their distances from the curve. `lanes` is
    /// scratch memory for the points in columns. Returns `None` if a coordinate is not a position
    /// in a picture. Does not allocate.
    pub(crate) fn fit(
        &mut self,
        arch: lariat_portable::Arch,
        points: &[[f64; D]],
        lanes: &mut Points<D>,
        control_points: &mut [[f64; D]],
    ) -> Option<SquaredResiduals> {
        let curve = &self.curve;
        let steps = match &mut self.solve {
            Solve::Product(rows) => {
                let describe = describe(rows, &mut self.halves, points, lanes, control_points);
                return arch.dispatch(Fit { describe, curve });
            }
            Solve::Steps(steps) => steps,
        };
        let inside = arch.dispatch(Load {
            points,
            bound: MAX_COORDINATE_PX,
            into: lanes,
        });
        if !inside {
            return None;
        }
        steps.solve(arch, points, lanes, &mut self.halves, control_points);
        let (even, odd) = self.halves.of(curve);
        curve.fold_negated(control_points, even, odd);
        Some(arch.dispatch(Residuals {
            rows: curve,
            points: lanes,
            even,
            odd,
        }))
    }

    /// Like [`Linear::fit`], without residuals. Also returns `None` if the solver has no single
    /// product.
    pub(crate) fn describe(
        &mut self,
        arch: lariat_portable::Arch,
        points: &[[f64; D]],
        lanes: &mut Points<D>,
        control_points: &mut [[f64; D]],
    ) -> Option<()> {
        let Solve::Product(rows) = &self.solve else {
            return None;
        };
        let describe = describe(rows, &mut self.halves, points, lanes, control_points);
        arch.dispatch(describe).then_some(())
    }
}

fn describe<'a, const D: usize>(
    rows: &'a Rows,
    halves: &'a mut Halves<D>,
    points: &'a [[f64; D]],
    into: &'a mut Points<D>,
    control_points: &'a mut [[f64; D]],
) -> Describe<'a, D> {
    let (even, odd) = halves.of(rows);
    Describe {
        points,
        bound: MAX_COORDINATE_PX,
        into,
        rows,
        even,
        odd,
        control_points,
    }
}

impl Factored {
    fn new(basis: Basis, knots: &[f64], options: &Options) -> Self {
        let b = condition::matrix(basis, knots, options.points);
        let system = System::new(basis, b, options.ridge, options.pin_ends);
        if system.a.ncols() == 0 {
            return Self {
                system,
                factors: None,
                condition: 1.0,
            };
        }
        let factors = Qr::new(system.a.as_ref());
        Self {
            condition: factors.condition(),
            factors: Some(factors),
            system,
        }
    }
}

/// Creates the error for a basis whose condition number exceeds the solver's limit. It names the
/// largest basis that stays below the limit.
fn refusal(basis: Basis, options: &Options, condition: f64) -> FitterError {
    let limit = condition::limit(options.solver);
    let is_allowed = |smaller: &Basis| {
        let knots = condition::even_knots(*smaller, options.points);
        Factored::new(*smaller, &knots, options).condition <= limit
    };
    FitterError::IllConditioned {
        basis,
        points: options.points,
        solver: options.solver,
        condition,
        limit,
        nearest: std::iter::successors(basis.smaller(), |basis| basis.smaller()).find(is_allowed),
    }
}

/// Restores the exact mirror symmetry of `m`, which rounding has disturbed: the mean of `m` and its
/// mirror image.
fn mirrored_mean(m: &Mat<f64>) -> Mat<f64> {
    let (rows, columns) = (m.nrows(), m.ncols());
    Mat::from_fn(rows, columns, |j, i| {
        0.5 * (m[(j, i)] + m[(rows - 1 - j, columns - 1 - i)])
    })
}
