//! Converts between Bezier curves and powers of ρ.

/// Computes the coefficients `a₀ … aₙ` of the same curve as powers, `Σ aₖ ρᵏ`: `aₖ = C(n,k) Δᵏp₀`.
///
/// Powers are a poor representation. They amplify rounding of the control points by up to `3ⁿ`
/// (some 1e4 at order 8, and all digits at order 31), and large coefficients cancel near ρ = 1. Use
/// them only to pass low orders to a program that needs them, and compute with the control points.
pub fn to_monomial<const D: usize>(control_points: &[[f64; D]]) -> Vec<[f64; D]> {
    let mut coefficients = control_points.to_vec();
    let count = coefficients.len();
    for done in 1..count {
        for j in (done..count).rev() {
            let before = coefficients[j - 1];
            for (axis, coordinate) in coefficients[j].iter_mut().enumerate() {
                *coordinate -= before[axis];
            }
        }
    }
    for (coefficient, binomial) in coefficients.iter_mut().zip(binomials(count)) {
        *coefficient = coefficient.map(|c| c * binomial);
    }
    coefficients
}

/// Computes the control points of the Bezier curve that is `Σ aₖ ρᵏ` from 0 to 1:
/// `pⱼ = Σ C(j,k)/C(n,k) aₖ`.
///
/// The result is as accurate as the coefficients: see [`to_monomial`].
pub fn from_monomial<const D: usize>(coefficients: &[[f64; D]]) -> Vec<[f64; D]> {
    let mut control_points = coefficients.to_vec();
    let count = control_points.len();
    for (point, binomial) in control_points.iter_mut().zip(binomials(count)) {
        *point = point.map(|c| c / binomial);
    }
    for done in 1..count {
        for j in (done..count).rev() {
            let before = control_points[j - 1];
            for (axis, coordinate) in control_points[j].iter_mut().enumerate() {
                *coordinate += before[axis];
            }
        }
    }
    control_points
}

/// C(count − 1, k), k from 0.
fn binomials(count: usize) -> impl Iterator<Item = f64> {
    (0..count).scan(1.0, move |next, k| {
        let binomial = *next;
        *next = binomial * (count - 1 - k) as f64 / (k + 1) as f64;
        Some(binomial)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve::Curve;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn powers_make_the_same_curve_and_lead_back(
            control_points in prop::collection::vec(prop::array::uniform3(-1e3f64..1e3), 1..=13),
            rho in 0.0f64..=1.0,
        ) {
            let coefficients = to_monomial(&control_points);
            let horner = coefficients.iter().rev().fold([0.0; 3], |sum, a| {
                [0, 1, 2].map(|axis| sum[axis] * rho + a[axis])
            });
            let point = Curve::bezier(&control_points).unwrap().point(rho);
            let back = from_monomial(&coefficients);
            // 3¹² ulp of 1e3.
            for axis in 0..3 {
                prop_assert!((horner[axis] - point[axis]).abs() < 1e-6);
                for (p, q) in back.iter().zip(&control_points) {
                    prop_assert!((p[axis] - q[axis]).abs() < 1e-6);
                }
            }
        }
    }

    #[test]
    fn a_cubic_has_the_powers_of_the_textbook() {
        let cubic = [[0.0], [1.0], [3.0], [4.0]];
        assert_eq!(to_monomial(&cubic), [[0.0], [3.0], [3.0], [-2.0]]);
        assert_eq!(from_monomial(&to_monomial(&cubic)), cubic);
        assert!(to_monomial::<2>(&[]).is_empty());
    }
}
