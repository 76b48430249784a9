//! Values of the basis functions at one ρ: a row of the matrix `B`.

use crate::basis::{Basis, Knots, MAX_CONTROL_POINTS};
use crate::bezier::bernstein;
use std::f64::consts::TAU;

/// Maximum number of knots of a B-spline: with degree `d` and `m` control points it has
/// `m + d + 1`, and `d < m`.
pub const MAX_KNOTS: usize = 2 * MAX_CONTROL_POINTS;

/// Writes the clamped knots of a curve of this basis, fitted to points at `rho` (ascending), to
/// `knots`. Returns their number, which is 0 for a basis without knots.
pub(crate) fn knots(basis: Basis, rho: &[f64], knots: &mut [f64; MAX_KNOTS]) -> usize {
    let (degree, count, placed) = match basis {
        Basis::BSpline {
            degree,
            control_points,
            knots,
        } => (degree, control_points, knots),
        // Straight lines between points in even steps.
        Basis::FeaturePoints { count } => (1, count, Knots::Uniform),
        _ => return 0,
    };
    let spans = count - degree;
    let total = count + degree + 1;
    for (place, knot) in knots[..total].iter_mut().enumerate() {
        *knot = if place <= degree {
            0.0
        } else if place >= count {
            1.0
        } else {
            let interior = place - degree;
            match placed {
                Knots::Uniform | Knots::Placed => interior as f64 / spans as f64,
                Knots::Averaged => averaged(rho, interior as f64 * rho.len() as f64 / spans as f64),
            }
        };
    }
    total
}

/// Interpolates ρ at a place between the points, counted as in Piegl and Tiller (equation 9.69): at
/// `i + α` it is `(1 − α) ρᵢ₋₁ + α ρᵢ`.
fn averaged(rho: &[f64], place: f64) -> f64 {
    let last = rho.len() - 1;
    let i = (place as usize).clamp(1, last);
    let share = (place - i as f64).clamp(0.0, 1.0);
    (1.0 - share) * rho[i - 1] + share * rho[i]
}

/// Writes the values of the basis functions at `rho` to `values`, one per control point. A rational
/// basis gives its polynomials, without weights. `knots` are those that [`knots`] computed.
///
/// Outside `[0, 1]`, the first and the last piece of a B-spline are continued as polynomials.
pub(crate) fn values(basis: Basis, knots: &[f64], rho: f64, values: &mut [f64]) {
    match basis {
        Basis::Bezier { order } | Basis::RationalBezier { order } => bernstein(order, rho, values),
        Basis::BSpline { degree, .. } => bspline(degree, knots, rho, values),
        Basis::FeaturePoints { .. } => bspline(1, knots, rho, values),
        Basis::Fourier { .. } => fourier(rho, values),
        Basis::CenterOfMass => values.fill(1.0),
    }
}

/// The span `k` that contains `rho`: `knots[k] ≤ rho < knots[k + 1]`, with 1 in the last span.
pub(crate) fn span(degree: usize, knots: &[f64], rho: f64) -> usize {
    let count = knots.len() - degree - 1;
    let interior = &knots[degree + 1..count];
    degree + interior.partition_point(|&knot| knot <= rho)
}

/// Cox and de Boor's recurrence in Piegl and Tiller's form (algorithm A2.2). It computes the
/// `degree + 1` functions that are not 0 in the span, and sets the others to 0.
fn bspline(degree: usize, knots: &[f64], rho: f64, values: &mut [f64]) {
    let span = span(degree, knots, rho);
    values.fill(0.0);
    let values = &mut values[span - degree..=span];
    values[0] = 1.0;
    for of in 1..=degree {
        let mut saved = 0.0;
        for r in 0..of {
            let (right, left) = (knots[span + r + 1], knots[span + 1 + r - of]);
            let share = values[r] / (right - left);
            values[r] = saved + (right - rho) * share;
            saved = (rho - left) * share;
        }
        values[of] = saved;
    }
}

fn fourier(rho: f64, values: &mut [f64]) {
    values[0] = 1.0;
    for (before, pair) in values[1..].chunks_exact_mut(2).enumerate() {
        let (sin, cos) = libm::sincos((before + 1) as f64 * TAU * rho);
        (pair[0], pair[1]) = (cos, sin);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn spline() -> impl Strategy<Value = (usize, usize)> {
        (1usize..=7).prop_flat_map(|degree| (Just(degree), degree + 1..=MAX_CONTROL_POINTS))
    }

    /// Cox and de Boor's definition, function by function.
    fn defined(j: usize, degree: usize, knots: &[f64], rho: f64) -> f64 {
        if degree == 0 {
            let last = knots[j] < 1.0 && knots[j + 1] == 1.0 && rho == 1.0;
            return f64::from((knots[j] <= rho && rho < knots[j + 1]) || last);
        }
        let share = |value: f64, length: f64, base: f64| {
            if length > 0.0 {
                value / length * base
            } else {
                0.0
            }
        };
        let lower = defined(j, degree - 1, knots, rho);
        let upper = defined(j + 1, degree - 1, knots, rho);
        share(rho - knots[j], knots[j + degree] - knots[j], lower)
            + share(
                knots[j + degree + 1] - rho,
                knots[j + degree + 1] - knots[j + 1],
                upper,
            )
    }

    proptest! {
        #[test]
        fn b_splines_are_what_cox_and_de_boor_define(
            (degree, control_points) in spline(),
            averaged in any::<bool>(),
            rho in 0.0f64..=1.0,
        ) {
            let basis = Basis::BSpline {
                degree,
                control_points,
                knots: if averaged { Knots::Averaged } else { Knots::Uniform },
            };
            let grid: Vec<f64> = (0..120).map(|i| basis.even_rho(i, 120)).collect();
            let mut made = [0.0; MAX_KNOTS];
            let total = knots(basis, &grid, &mut made);
            let made = &made[..total];
            prop_assert!(made.windows(2).all(|pair| pair[0] <= pair[1]));
            let mut found = [0.0; MAX_CONTROL_POINTS];
            for rho in [0.0, rho, 1.0] {
                values(basis, made, rho, &mut found[..control_points]);
                for (j, value) in found[..control_points].iter().enumerate() {
                    prop_assert!((value - defined(j, degree, made, rho)).abs() < 1e-12);
                }
            }
        }

        #[test]
        fn a_b_spline_of_one_piece_is_a_bezier_curve(order in 1usize..=12, rho in 0.0f64..=1.0) {
            let basis = Basis::BSpline {
                degree: order,
                control_points: order + 1,
                knots: Knots::Uniform,
            };
            let mut made = [0.0; MAX_KNOTS];
            let total = knots(basis, &[0.0, 1.0], &mut made);
            let (mut spline, mut polynomials) = (vec![0.0; order + 1], vec![0.0; order + 1]);
            values(basis, &made[..total], rho, &mut spline);
            values(Basis::Bezier { order }, &[], rho, &mut polynomials);
            for (a, b) in spline.iter().zip(&polynomials) {
                prop_assert!((a - b).abs() < 1e-14);
            }
        }
    }

    /// SciPy 1.17: `BSpline.design_matrix(0.3, [0,0,0,0,.25,.5,.75,1,1,1,1], 3)`.
    #[test]
    fn a_cubic_b_spline_has_the_values_of_the_textbook() {
        let basis = Basis::BSpline {
            degree: 3,
            control_points: 7,
            knots: Knots::Uniform,
        };
        let mut made = [0.0; MAX_KNOTS];
        let total = knots(basis, &[], &mut made);
        assert_eq!(made[..total][4..7], [0.25, 0.5, 0.75]);
        let mut found = [0.0; 7];
        values(basis, &made[..total], 0.3, &mut found);
        let expected = [
            0.0,
            0.128,
            0.588,
            0.282_666_666_666_666_7,
            0.001_333_333_333_333_333,
        ];
        for (value, expected) in found.iter().zip(expected) {
            assert!((value - expected).abs() < 1e-15, "{found:?}");
        }
    }
}
