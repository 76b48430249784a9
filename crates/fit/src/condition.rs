//! The matrix `B` and the accuracy of each solver with it: the conditions for a stable descriptor.
//!
//! The paper asks for `N ≫ n + 1`, so that `BᵀB` has an inverse (below its equation 8). The exact
//! conditions are:
//!
//! 1. at least as many points as control points, `N ≥ n + 1`;
//! 2. as many *different* values of ρ among them. Bernstein polynomials of order `n` are a basis of
//!    the polynomials of degree `n`, of which only 0 has `n + 1` zeros, so that `B` has full rank.
//!    For B-splines each function also needs a ρ of its own where it is not 0 (Schoenberg and
//!    Whitney 1953);
//! 3. a condition number of `B` below [`limit`], so that rounding errors of the control points stay
//!    below the accuracy of a centerline.
//!
//! The first two guarantee that the descriptor exists and is unique, the third that it can be
//! computed. The effect of *noise* in the points is measured by another number, the noise gain
//! `√max((BᵀB)⁻¹)ⱼⱼ`.

use crate::basis::Basis;
use crate::functions::{self, MAX_KNOTS};
use crate::options::Solver;
use faer::Mat;

/// Acceptable relative error of the control points: a thousandth of a pixel in a picture a thousand
/// pixels wide, two orders of magnitude below the accuracy of a centerline.
const ACCURACY: f64 = 1e-6;

/// Highest condition number of `B` at which `solver` keeps [`ACCURACY`].
///
/// A backward stable method on `B` itself loses `ε cond(B)` (Björck, *Numerical Methods for Least
/// Squares Problems*, 1.4; the term in `cond²` is proportional to the residual, which is small for
/// a centerline). The normal equations lose `ε cond(BᵀB) = ε cond(B)²` (ibid. 2.2). With ε =
/// 2.2·10⁻¹⁶ that is 4.5·10⁹ for `pinv` and `qr`, and 6.7·10⁴ for `cholesky`.
pub(crate) fn limit(solver: Solver) -> f64 {
    match solver {
        Solver::Pinv | Solver::Qr => ACCURACY / f64::EPSILON,
        Solver::Cholesky => (ACCURACY / f64::EPSILON).sqrt(),
    }
}

/// Returns whether `B` of this basis on the even grid is mirror-symmetric: `Bᵢⱼ = B₍N₋₁₋ᵢ₎₍ₘ₋₁₋ⱼ₎`.
pub(crate) fn is_mirrored(basis: Basis) -> bool {
    use crate::basis::Knots;
    match basis {
        Basis::Bezier { .. } | Basis::RationalBezier { .. } => true,
        Basis::BSpline { knots, .. } => knots == Knots::Uniform,
        Basis::Fourier { .. } | Basis::FeaturePoints { .. } | Basis::CenterOfMass => false,
    }
}

/// The knots of the basis on the even grid.
pub(crate) fn even_knots(basis: Basis, points: usize) -> Vec<f64> {
    let grid: Vec<f64> = (0..points).map(|i| basis.even_rho(i, points)).collect();
    let mut knots = [0.0; MAX_KNOTS];
    let total = functions::knots(basis, &grid, &mut knots);
    knots[..total].to_vec()
}

/// The matrix `B` of equation 7 on the even grid of ρ: `points` × control points.
///
/// If it is mirror-symmetric, the symmetry is exact. The mirror image of a centerline then has the
/// mirror image of its descriptor.
pub(crate) fn matrix(basis: Basis, knots: &[f64], points: usize) -> Mat<f64> {
    let count = basis.control_points();
    let mut b = Mat::zeros(points, count);
    let mut values = vec![0.0; count];
    let mirrored = is_mirrored(basis);
    let rows = if mirrored { points.div_ceil(2) } else { points };
    for i in 0..rows {
        functions::values(basis, knots, basis.even_rho(i, points), &mut values);
        let other = points - 1 - i;
        for j in 0..count {
            if mirrored && i == other {
                // ρ = 1/2 is its own mirror image.
                b[(i, j)] = 0.5 * (values[j] + values[count - 1 - j]);
            } else {
                b[(i, j)] = values[j];
                if mirrored {
                    b[(other, count - 1 - j)] = values[j];
                }
            }
        }
    }
    b
}
