//! Points, derivatives, tangents and curvatures of curves of every family.

use crate::any_curve;

use any_curve::{any_curve, apart, circle, quarter_circle};
use lariat_fit::{Basis, Curve, CurveError, Knots, elevate_degree, reverse};
use proptest::prelude::*;
use std::f64::consts::{FRAC_1_SQRT_2, TAU};

/// Returns whether ρ is so near to a knot that a difference would reach across it.
fn near_a_knot(curve: &Curve, rho: f64) -> bool {
    curve.knots().iter().any(|knot| (knot - rho).abs() < 1e-3)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn derivatives_are_the_limits_of_differences(owned in any_curve(10), rho in 0.01f64..0.99) {
        let curve = owned.as_curve().unwrap();
        prop_assume!(!near_a_knot(&curve, rho));
        for k in 1..=3 {
            // The error of central differences is bounded by the largest of this derivative and of
            // the third one after it.
            let size = (0..=100)
                .map(|i| curve.derivative(f64::from(i) / 100.0, k))
                .map(|d| d[0].hypot(d[1]))
                .fold(1.0, f64::max);
            let step = 1e-5;
            let after = curve.derivative(rho + step, k - 1);
            let before = curve.derivative(rho - step, k - 1);
            let found = curve.derivative(rho, k);
            for axis in 0..2 {
                let difference = (after[axis] - before[axis]) / (2.0 * step);
                prop_assert!(
                    (found[axis] - difference).abs() < 1e-4 * size,
                    "{k}: {found:?} {difference} of {size}"
                );
            }
        }
    }

    #[test]
    fn a_point_is_the_sum_of_control_points_by_the_jacobian(owned in any_curve(32), rho in 0.0f64..=1.0) {
        let curve = owned.as_curve().unwrap();
        let mut shares = vec![0.0; owned.control_points.len()];
        curve.jacobian(rho, &mut shares);
        let point = curve.point(rho);
        for axis in 0..2 {
            let weighed = owned.control_points.iter().zip(&shares);
            let sum: f64 = weighed.map(|(p, share)| p[axis] * share).sum();
            prop_assert!((sum - point[axis]).abs() < 1e-9);
        }
        if !matches!(owned.basis, Basis::Fourier { .. }) {
            prop_assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn the_jacobian_by_the_weights_is_the_limit_of_differences(
        owned in any_curve(8),
        rho in 0.0f64..=1.0,
    ) {
        let curve = owned.as_curve().unwrap();
        let mut found = vec![[7.0; 2]; owned.control_points.len()];
        curve.weight_jacobian(rho, &mut found);
        if owned.weights.is_empty() {
            prop_assert!(found.iter().all(|v| *v == [0.0; 2]));
        }
        for (j, found) in found.iter().enumerate().take(owned.weights.len()) {
            let moved = |by: f64| {
                let mut other = owned.clone();
                other.weights[j] += by;
                other.as_curve().unwrap().point(rho)
            };
            let (after, before) = (moved(1e-5), moved(-1e-5));
            for axis in 0..2 {
                let difference = (after[axis] - before[axis]) / 2e-5;
                prop_assert!((found[axis] - difference).abs() < 1e-5);
            }
        }
    }

    #[test]
    fn a_reversed_curve_is_the_same_from_the_other_end(owned in any_curve(32), rho in 0.0f64..=1.0) {
        let curve = owned.as_curve().unwrap();
        let reversed = reverse(&curve);
        let reversed = reversed.as_curve().unwrap();
        prop_assert!(apart(curve.point(rho), reversed.point(1.0 - rho)) < 1e-9);
        prop_assert!((curve.length() - reversed.length()).abs() <= 1e-9 * curve.length());
        if let (Some(one), Some(other)) = (curve.curvature(rho), reversed.curvature(1.0 - rho))
            && !near_a_knot(&curve, rho)
        {
            prop_assert!((one + other).abs() <= 1e-6 * one.abs().max(1e-3), "{one} {other}");
        }
        let back = reverse(&reversed);
        prop_assert!(apart(back.as_curve().unwrap().point(rho), curve.point(rho)) < 1e-9);
    }

    #[test]
    fn a_moved_turned_and_scaled_curve_is_the_curve_of_moved_turned_and_scaled_control_points(
        owned in any_curve(12),
        rho in 0.0f64..=1.0,
        angle in 0.0..TAU,
        scale in 0.1f64..10.0,
        by in prop::array::uniform2(-1e3f64..1e3),
    ) {
        let (sin, cos) = angle.sin_cos();
        let turn = |p: [f64; 2]| [cos * p[0] - sin * p[1], sin * p[0] + cos * p[1]].map(|c| scale * c);
        let there = |p: [f64; 2]| { let [x, y] = turn(p); [x + by[0], y + by[1]] };
        let mut moved = owned.clone();
        for (j, point) in moved.control_points.iter_mut().enumerate() {
            // Waves do not sum to one: only the mean is a position.
            let is_place = j == 0 || !owned.basis.is_closed();
            *point = if is_place { there(*point) } else { turn(*point) };
        }
        let (curve, moved) = (owned.as_curve().unwrap(), moved.as_curve().unwrap());
        prop_assert!(apart(there(curve.point(rho)), moved.point(rho)) < 1e-9);
        let (length, scaled) = (curve.length(), moved.length());
        prop_assert!((scale * length - scaled).abs() <= 1e-9 * scaled);
        if let (Some(before), Some(after)) = (curve.curvature(rho), moved.curvature(rho)) {
            prop_assert!((before - scale * after).abs() <= 1e-6 * before.abs().max(1e-3));
        }
    }

    #[test]
    fn a_tangent_is_the_velocity_made_one_long(owned in any_curve(32), rho in 0.0f64..=1.0) {
        let curve = owned.as_curve().unwrap();
        match curve.tangent(rho) {
            None => prop_assert_eq!(owned.basis, Basis::CenterOfMass),
            Some(tangent) => {
                let velocity = curve.derivative(rho, 1);
                let speed = velocity[0].hypot(velocity[1]);
                prop_assert!((tangent[0].hypot(tangent[1]) - 1.0).abs() < 1e-12);
                prop_assert!((tangent[0] * velocity[1] - tangent[1] * velocity[0]).abs() < 1e-9 * speed);
            }
        }
    }
}

#[test]
fn where_control_points_meet_the_tangent_is_the_way_on() {
    let start = Curve::bezier(&[[3.0, 4.0], [3.0, 4.0], [6.0, 8.0], [9.0, 0.0]]).unwrap();
    let tangent = start.tangent(0.0).unwrap();
    assert!(apart(tangent, [0.6, 0.8]) < 1e-12);
    // The direction is that of the curve a little later.
    assert!(apart(tangent, start.tangent(1e-6).unwrap()) < 1e-4);
    let end = Curve::bezier(&[[9.0, 0.0], [6.0, 8.0], [3.0, 4.0], [3.0, 4.0]]).unwrap();
    assert!(apart(end.tangent(1.0).unwrap(), [-0.6, -0.8]) < 1e-12);
    let twice = Curve::bezier(&[[9.0, 1.0], [3.0, 1.0], [3.0, 1.0], [3.0, 1.0]]).unwrap();
    assert!(apart(twice.tangent(1.0).unwrap(), [-1.0, 0.0]) < 1e-12);
    assert_eq!(start.curvature(0.0), None);
    let point = Curve::bezier(&[[0.1, 0.7]; 9]).unwrap();
    assert_eq!(point.tangent(0.3), None);
    assert_eq!(point.curvature(0.3), None);
}

#[test]
fn circles_bend_by_one_over_their_radius() {
    for owned in [quarter_circle(), circle()] {
        let curve = owned.as_curve().unwrap();
        let reversed = reverse(&curve);
        for i in 0..=100 {
            let rho = f64::from(i) / 100.0;
            // From the x axis to the y axis.
            assert!((curve.curvature(rho).unwrap() - 0.02).abs() < 1e-14);
            let reversed = reversed.as_curve().unwrap();
            assert!((reversed.curvature(rho).unwrap() + 0.02).abs() < 1e-14);
        }
    }
    let curve = quarter_circle();
    let curve = curve.as_curve().unwrap();
    for i in 0..=100 {
        let [x, y] = curve.point(f64::from(i) / 100.0);
        assert!((x.hypot(y) - 50.0).abs() < 1e-12);
    }
}

#[test]
fn in_space_a_curve_bends_to_no_side() {
    // A flat parabola, tilted by 45°.
    let flat = [[0.0, 0.0], [1.0, 2.0], [2.0, 0.0]];
    let tipped = flat.map(|[x, y]| [x, y * FRAC_1_SQRT_2, y * FRAC_1_SQRT_2]);
    let (flat, tipped) = (
        Curve::bezier(&flat).unwrap(),
        Curve::bezier(&tipped).unwrap(),
    );
    for i in 0..=10 {
        let rho = f64::from(i) / 10.0;
        let size = tipped.curvature(rho).unwrap();
        assert!((size + flat.curvature(rho).unwrap()).abs() < 1e-14);
    }
    assert!((tipped.length() - flat.length()).abs() < 1e-13);
}

#[test]
fn order_31_is_as_good_as_order_3() {
    let cubic = [[0.0, 0.0], [100.0, 300.0], [400.0, -200.0], [640.0, 480.0]];
    let elevated = elevate_degree(&cubic, 28);
    let (low, high) = (
        Curve::bezier(&cubic).unwrap(),
        Curve::bezier(&elevated).unwrap(),
    );
    for i in 0..=1000 {
        let rho = f64::from(i) / 1000.0;
        assert!(apart(low.point(rho), high.point(rho)) < 1e-11);
        // Rounding of the control points, some 1e-13, times 31 and 31 · 30 · 29.
        assert!(apart(low.derivative(rho, 1), high.derivative(rho, 1)) < 1e-9);
        assert!(apart(low.derivative(rho, 3), high.derivative(rho, 3)) < 1e-6);
    }
}

#[test]
fn what_is_no_curve_is_refused_with_a_sentence() {
    let points = [[0.0, 0.0], [1.0, 2.0], [3.0, 1.0], [4.0, 4.0]];
    let spline = |knots| Basis::BSpline {
        degree: 2,
        control_points: 4,
        knots,
    };
    let refused = |basis, points: &[[f64; 2]], weights: &[f64], knots: &[f64]| {
        let error = Curve::new(basis, points, weights, knots).unwrap_err();
        assert!(error.to_string().contains(':') || error == CurveError::KnotsWanted);
        error
    };
    let bezier = Basis::Bezier { order: 3 };
    let rational = Basis::RationalBezier { order: 3 };
    let uniform = spline(Knots::Uniform);
    use CurveError as E;
    assert!(matches!(
        refused(Basis::Bezier { order: 32 }, &[[0.0; 2]; 33], &[], &[]),
        E::Size { .. }
    ));
    assert!(matches!(
        refused(Basis::Bezier { order: usize::MAX }, &points, &[], &[]),
        E::Size { .. }
    ));
    assert!(matches!(
        refused(Basis::FeaturePoints { count: 1 }, &points[..1], &[], &[]),
        E::Size { .. }
    ));
    assert!(matches!(
        refused(bezier, &points[..3], &[], &[]),
        E::ControlPoints { given: 3, .. }
    ));
    assert!(matches!(
        refused(bezier, &points, &[1.0; 4], &[]),
        E::Weights { .. }
    ));
    assert!(matches!(
        refused(rational, &points, &[], &[]),
        E::Weights { expected: 4, .. }
    ));
    assert!(matches!(
        refused(rational, &points, &[1.0, 1.0, 0.0, 1.0], &[]),
        E::Weight { index: 2, .. }
    ));
    assert!(matches!(
        refused(bezier, &[[0.0, f64::NAN]; 4], &[], &[]),
        E::NotFinite { index: 0 }
    ));
    assert!(matches!(
        refused(bezier, &points, &[], &[0.0, 1.0]),
        E::NoKnots { .. }
    ));
    assert!(matches!(
        refused(spline(Knots::Averaged), &points, &[], &[]),
        E::KnotsWanted
    ));
    assert!(matches!(
        refused(uniform, &points, &[], &[0.0; 5]),
        E::KnotCount { expected: 7, .. }
    ));
    for (index, knots) in [
        (1, [0.0, 0.1, 0.2, 0.5, 1.0, 1.0, 1.0]),
        (3, [0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]),
        (3, [0.0, 0.0, 0.0, f64::NAN, 1.0, 1.0, 1.0]),
        (5, [0.0, 0.0, 0.0, 0.5, 1.0, 2.0, 1.0]),
    ] {
        let error = refused(uniform, &points, &[], &knots);
        assert!(
            matches!(error, E::Knot { index: at, .. } if at == index),
            "{error}"
        );
    }
    assert!(Curve::<2>::bezier(&[]).is_err());
}
