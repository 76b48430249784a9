//! The families of curves that are compared, and the error of a fit.

use lariat_fit::{Basis, Curve, Fit, Fitter, Knots, Options};

use crate::PaperError;
use crate::polyline::apart_px;
use crate::shapes::POINTS;

/// The orders that the paper compares.
pub(crate) const PAPERS: [usize; 4] = [2, 4, 6, 8];

/// Returns a cubic B-spline with this many control points. With only two or three, the degree is
/// the highest that this number allows.
pub(crate) fn bspline(control_points: usize) -> Basis {
    Basis::BSpline {
        degree: 3.min(control_points - 1),
        control_points,
        knots: Knots::Uniform,
    }
}

/// Creates a fitter for N points with default options except for the basis.
pub(crate) fn fitter(basis: Basis) -> Result<Fitter, PaperError> {
    Ok(Fitter::new(Options::default().basis(basis).points(POINTS))?)
}

/// Returns the curve of a fit.
pub(crate) fn curve(fit: &Fit) -> Result<Curve<'_>, PaperError> {
    Ok(Curve::new(
        fit.basis,
        &fit.control_points,
        &fit.weights,
        &fit.knots,
    )?)
}

/// Returns the root mean square distance between the curve and `reference` at the same even steps
/// of ρ, px. The paper's Q is the sum of these squared distances.
pub(crate) fn off_at_rho_px(fit: &Fit, reference: &[[f64; 2]]) -> Result<f64, PaperError> {
    let curve = curve(fit)?;
    let steps = (reference.len() - 1) as f64;
    let squares = reference
        .iter()
        .enumerate()
        .map(|(i, &p)| apart_px(curve.point(i as f64 / steps), p).powi(2));
    Ok((squares.sum::<f64>() / reference.len() as f64).sqrt())
}

/// Returns `count` points along the curve at even steps of ρ.
pub(crate) fn sampled(fit: &Fit, count: usize) -> Result<Vec<[f64; 2]>, PaperError> {
    let curve = curve(fit)?;
    let steps = (count - 1) as f64;
    Ok((0..count).map(|i| curve.point(i as f64 / steps)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_is_off_by_what_its_points_are_moved() {
        let line: Vec<[f64; 2]> = (0..POINTS).map(|i| [3.0 * i as f64, 0.0]).collect();
        let moved: Vec<[f64; 2]> = line.iter().map(|p| [p[0], 2.0]).collect();
        for basis in [Basis::Bezier { order: 4 }, bspline(5), bspline(2)] {
            let mut fitter = fitter(basis).unwrap();
            let fit = fitter.fit(&line).unwrap();
            assert!((off_at_rho_px(fit, &moved).unwrap() - 2.0).abs() < 1e-6);
            assert!((sampled(fit, 3).unwrap()[1][0] - 178.5).abs() < 1e-6);
        }
    }
}
