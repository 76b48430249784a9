//! Points without noise.

use super::sampling::*;
use lariat_fit::{RationalFitter, point_at};
use proptest::prelude::*;

#[test]
fn arcs_of_circles_are_found_with_the_weights_of_the_textbook() {
    // The middle weight of an arc is the cosine of half its angle (L. Piegl, W. Tiller, The NURBS
    // Book, 7.3).
    for degrees in [20.0f64, 60.0, 90.0, 120.0, 150.0] {
        for pinned in [false, true] {
            let half = degrees.to_radians() / 2.0;
            let tip = 100.0 / half.cos();
            let control_points = [
                [300.0 - 100.0 * half.sin(), 200.0 + 100.0 * half.cos()],
                [300.0, 200.0 + tip],
                [300.0 + 100.0 * half.sin(), 200.0 + 100.0 * half.cos()],
            ];
            let arc = sampled(&control_points, &[1.0, half.cos(), 1.0], 120);
            for p in &arc {
                assert!((distance(p, &[300.0, 200.0]) - 100.0).abs() < 1e-9);
            }
            let mut fitter = RationalFitter::new(2, 120, pinned);
            let fit = fitter.fit(&arc);
            assert!(fit.converged);
            assert!(fit.max_px < 1e-6, "{degrees}: {fit:?}");
            assert!(
                (fit.weights[1] / fit.weights[0] - half.cos()).abs() < 1e-7,
                "{degrees}: {fit:?}"
            );
            assert!((fit.weights[2] / fit.weights[0] - 1.0).abs() < 1e-7);
            assert!(apart(fit.control_points, &control_points) < 1e-5);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn a_rational_curve_is_found_exactly_with_its_weights(
        (control_points, weights) in any_rational(2..=6),
        pinned in any::<bool>(),
    ) {
        let points = sampled(&control_points, &weights, 120);
        let sensitivity = least_sensitivity(&control_points, &weights, 120);
        // Below this, the points do not determine some combination of weights.
        prop_assume!(sensitivity > 1e-3);
        let mut fitter = RationalFitter::new(weights.len() - 1, 120, pinned);
        let fit = fitter.fit(&points);
        prop_assert!(fit.converged, "{:?}", fit);
        prop_assert!(fit.max_px < 1e-6);
        let known_to = 1e-9 + 10.0 * fit.squared_residuals.sqrt() / sensitivity;
        for (found, true_weight) in log_weights(fit.weights).iter().zip(log_weights(&weights)) {
            prop_assert!((found - true_weight).abs() < known_to, "{} {} {}", found, true_weight, known_to);
        }
        is_sound(&fit, &points, pinned)?;
    }

    #[test]
    fn an_affine_map_leaves_a_rational_curves_weights(
        (control_points, weights) in any_rational(2..=4),
        map in prop::array::uniform6(-2.0f64..2.0),
    ) {
        prop_assume!((map[0] * map[4] - map[1] * map[3]).abs() > 0.2);
        let apply = |p: &[f64; 2]| [
            map[0] * p[0] + map[1] * p[1] + 100.0 * map[2],
            map[3] * p[0] + map[4] * p[1] + 100.0 * map[5],
        ];
        let points = sampled(&control_points, &weights, 100);
        let sensitivity = least_sensitivity(&control_points, &weights, 100);
        prop_assume!(sensitivity > 1e-3);
        let moved: Vec<_> = points.iter().map(apply).collect();
        let mut fitter = RationalFitter::new(weights.len() - 1, 100, false);
        let first = log_weights(fitter.fit(&points).weights);
        fitter.forget();
        let second = log_weights(fitter.fit(&moved).weights);
        for (a, b) in first.iter().zip(&second) {
            prop_assert!((a - b).abs() < 1e-6 / sensitivity.min(1.0), "{first:?} {second:?}");
        }
    }

    #[test]
    fn a_straight_line_is_a_polynomial_with_weights_of_one(
        from in prop::array::uniform2(0.0f64..640.0),
        to in prop::array::uniform2(0.0f64..640.0),
        order in 1usize..=8,
        pinned in any::<bool>(),
    ) {
        let points = sampled(&[from, to], &[1.0; 2], 60);
        let mut fitter = RationalFitter::new(order, 60, pinned);
        let fit = fitter.fit(&points);
        prop_assert!(fit.converged);
        prop_assert_eq!(fit.steps, 0);
        prop_assert!(fit.weights.iter().all(|w| *w == 1.0));
        prop_assert!(fit.max_px < 1e-9);
        is_sound(&fit, &points, pinned)?;
    }
}

#[test]
fn points_that_are_all_the_same_are_a_polynomial() {
    for order in [1, 4, 8] {
        let mut fitter = RationalFitter::new(order, 40, false);
        let fit = fitter.fit(&[[17.0, 23.0]; 40]);
        assert!(fit.converged && fit.steps == 0);
        assert!(fit.weights.iter().all(|w| *w == 1.0));
        assert!(fit.max_px < 1e-12);
        assert!(apart(fit.control_points, &[[17.0, 23.0]; 9]) < 1e-10);
    }
}

#[test]
fn curves_in_space_are_fitted_alike() {
    let control_points = [
        [0.0, 10.0, 500.0],
        [100.0, 200.0, 620.0],
        [300.0, -50.0, 480.0],
        [400.0, 90.0, 550.0],
    ];
    let points = sampled(&control_points, &[1.0, 0.4, 2.0, 0.8], 90);
    let mut fitter = RationalFitter::new(3, 90, false);
    let fit = fitter.fit(&points);
    assert!(fit.converged && fit.max_px < 1e-6);
    assert!(apart(fit.control_points, &control_points) < 1e-5);
    assert_eq!(fit.degrees_of_freedom, 3 * (90 - 4) - 3);
}

#[test]
fn a_polynomial_curve_keeps_its_control_points() {
    let control_points = [
        [30.0, 40.0],
        [600.0, -200.0],
        [-300.0, 500.0],
        [610.0, 450.0],
    ];
    let points: Vec<_> = (0..100)
        .map(|i| point_at(&control_points, i as f64 / 99.0))
        .collect();
    let mut fitter = RationalFitter::new(3, 100, false);
    let fit = fitter.fit(&points);
    assert!(fit.converged && fit.weights.iter().all(|w| *w == 1.0));
    assert!(apart(fit.control_points, &control_points) < 1e-9);
}
