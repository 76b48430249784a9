//! What a [`Fitter`](crate::Fitter) is asked for.

use std::fmt;
use std::str::FromStr;

/// The highest order: 32 control points.
pub const MAX_ORDER: usize = 31;

/// The most points of a centerline.
pub const MAX_POINTS: usize = 256;

/// The family of curves that a descriptor's control points belong to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Basis {
    /// Bernstein polynomials: a Bezier curve.
    Bezier,
}

impl fmt::Display for Basis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Basis::Bezier => "bezier",
        })
    }
}

/// How `s = (BᵀB)⁻¹Bᵀc̄` is computed. All three give the same control points; they differ in cost and in
/// the orders they can be trusted with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Solver {
    /// The matrix `(BᵀB)⁻¹Bᵀ`, computed once: a fit is one product. The fastest.
    Pinv,
    /// The Cholesky factor of `BᵀB`, computed once: a fit is a product and two triangular solves. Its
    /// error goes with the square of the condition number.
    Cholesky,
    /// The Householder QR of `B`, computed once: a fit is `Qᵀc̄` and one triangular solve.
    Qr,
}

impl fmt::Display for Solver {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Solver::Pinv => "pinv",
            Solver::Cholesky => "cholesky",
            Solver::Qr => "qr",
        })
    }
}

/// A name that is no solver's.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("there is no solver \"{0}\": choose pinv, cholesky or qr")]
pub struct UnknownSolver(String);

impl FromStr for Solver {
    type Err = UnknownSolver;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        match name {
            "pinv" => Ok(Solver::Pinv),
            "cholesky" => Ok(Solver::Cholesky),
            "qr" => Ok(Solver::Qr),
            other => Err(UnknownSolver(other.to_owned())),
        }
    }
}

/// What is fixed when a [`Fitter`](crate::Fitter) is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Options {
    /// The curve's order `n`, from 1 to [`MAX_ORDER`]; it has `n + 1` control points. Default: 8, the best
    /// of the paper's four.
    pub order: usize,
    /// How many points `N` a centerline has, from 2 to [`MAX_POINTS`] and no fewer than `n + 1`.
    /// Default: 120, as in the paper.
    pub points: usize,
    /// Default: [`Solver::Pinv`].
    pub solver: Solver,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            order: 8,
            points: 120,
            solver: Solver::Pinv,
        }
    }
}
