//! Splits a Bezier curve in two, and reverses any curve.

use super::OwnedCurve;
use crate::basis::Basis;
use crate::curve::Curve;

/// Splits a Bezier curve at `rho` into two parts of the same order. Returns their control points:
/// the edges of de Casteljau's triangle. If `rho` is outside 0 to 1, the parts overlap on the
/// curve's continuation.
///
/// To split a rational curve, pass the control points times their weights, with the weight as the
/// last coordinate. They define the polynomial curve whose projection the rational curve is.
pub fn split_at<const D: usize>(
    control_points: &[[f64; D]],
    rho: f64,
) -> (Vec<[f64; D]>, Vec<[f64; D]>) {
    let mut second = control_points.to_vec();
    let mut first = Vec::with_capacity(second.len());
    for remaining in (0..second.len()).rev() {
        first.push(second[0]);
        for j in 0..remaining {
            let next = second[j + 1];
            for (axis, coordinate) in second[j].iter_mut().enumerate() {
                *coordinate = (1.0 - rho) * *coordinate + rho * next[axis];
            }
        }
    }
    (first, second)
}

/// Reverses a curve: the new point at ρ is the old point at 1 − ρ.
pub fn reverse<const D: usize>(curve: &Curve<'_, D>) -> OwnedCurve<D> {
    let mut reversed = OwnedCurve::from(curve);
    if let Basis::Fourier { .. } = reversed.basis {
        // Reversal keeps the cosine terms and negates the sine terms.
        for sine in reversed.control_points.iter_mut().skip(2).step_by(2) {
            *sine = sine.map(|c| -c);
        }
        return reversed;
    }
    reversed.control_points.reverse();
    reversed.weights.reverse();
    reversed.knots.reverse();
    for knot in &mut reversed.knots {
        *knot = 1.0 - *knot;
    }
    reversed
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn two_parts_are_the_whole(
            control_points in prop::collection::vec(prop::array::uniform2(-1e3f64..1e3), 1..=32),
            at in 0.0f64..=1.0,
            rho in 0.0f64..=1.0,
        ) {
            let (first, second) = split_at(&control_points, at);
            let whole = Curve::bezier(&control_points).unwrap();
            let before = Curve::bezier(&first).unwrap().point(rho);
            let after = Curve::bezier(&second).unwrap().point(rho);
            for axis in 0..2 {
                prop_assert!((before[axis] - whole.point(at * rho)[axis]).abs() < 1e-9);
                let there = at + (1.0 - at) * rho;
                prop_assert!((after[axis] - whole.point(there)[axis]).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn no_control_points_have_no_parts() {
        assert_eq!(split_at::<2>(&[], 0.5), (vec![], vec![]));
    }
}
