//! The matrix `B` and how far each solver can be trusted with it.

use crate::bezier::bernstein;
use crate::error::FitterError;
use crate::options::{MAX_ORDER, MAX_POINTS, Options, Solver};
use faer::Mat;

/// The relative error of the control points that is still no error: a thousandth of a pixel in a picture
/// of a thousand, two orders below what a centerline is known to.
const ACCURACY: f64 = 1e-6;

/// The highest condition number of `B` at which `solver` keeps [`ACCURACY`].
///
/// A backward stable method on `B` itself loses `ε cond(B)` (Björck, *Numerical Methods for Least Squares
/// Problems*, 1.4; the term in `cond²` goes with the residual, which is small for a centerline). The
/// normal equations lose `ε cond(BᵀB) = ε cond(B)²` (ibid. 2.2). With ε = 2.2·10⁻¹⁶ that is 4.5·10⁹ for
/// `pinv` and `qr`, and 6.7·10⁴ for `cholesky`.
pub(crate) fn limit(solver: Solver) -> f64 {
    match solver {
        Solver::Pinv | Solver::Qr => ACCURACY / f64::EPSILON,
        Solver::Cholesky => (ACCURACY / f64::EPSILON).sqrt(),
    }
}

/// The matrix `B` of equation 7 on the uniform grid `ρᵢ = i / (N − 1)`: `points` × (`order` + 1).
///
/// Its second half is the first in reverse, `Bᵢⱼ = B₍N₋₁₋ᵢ₎₍ₙ₋ⱼ₎`, to the last bit: the mirror image of a
/// centerline has the mirror image of its descriptor.
pub(crate) fn matrix(order: usize, points: usize) -> Mat<f64> {
    let mut b = Mat::zeros(points, order + 1);
    let mut values = vec![0.0; order + 1];
    for i in 0..points.div_ceil(2) {
        bernstein(order, i as f64 / (points - 1) as f64, &mut values);
        let mirrored = points - 1 - i;
        for j in 0..=order {
            if i == mirrored {
                // ρ = 1/2 is its own mirror image.
                b[(i, j)] = 0.5 * (values[j] + values[order - j]);
            } else {
                b[(i, j)] = values[j];
                b[(mirrored, order - j)] = values[j];
            }
        }
    }
    b
}

/// The 2-norm condition number of `b`: its largest singular value by its smallest; infinite when that is 0
/// or the singular values cannot be found.
pub(crate) fn number(b: &Mat<f64>) -> f64 {
    match b.singular_values() {
        Ok(values) => match (values.first(), values.last()) {
            (Some(&largest), Some(&smallest)) if smallest > 0.0 => largest / smallest,
            _ => f64::INFINITY,
        },
        Err(_) => f64::INFINITY,
    }
}

/// `B` for these options and its condition number, or why there can be no fitter.
pub(crate) fn checked_matrix(options: &Options) -> Result<(Mat<f64>, f64), FitterError> {
    let Options {
        order,
        points,
        solver,
    } = *options;
    if !(1..=MAX_ORDER).contains(&order) {
        return Err(FitterError::Order { order });
    }
    if !(2..=MAX_POINTS).contains(&points) {
        return Err(FitterError::Points { points });
    }
    if points < order + 1 {
        return Err(FitterError::TooFewPoints { points, order });
    }
    let b = matrix(order, points);
    let condition = number(&b);
    if condition > limit(solver) {
        return Err(FitterError::IllConditioned {
            order,
            points,
            solver,
            condition,
            limit: limit(solver),
            highest_order: highest_order(order, points, solver),
        });
    }
    Ok((b, condition))
}

/// The highest order below `refused` that `solver` can be trusted with. Order 1 always can: its condition
/// number is at most √3.
fn highest_order(refused: usize, points: usize, solver: Solver) -> usize {
    (1..refused)
        .rev()
        .find(|&order| number(&matrix(order, points)) <= limit(solver))
        .unwrap_or(1)
}
