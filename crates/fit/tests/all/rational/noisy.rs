//! Points with noise, and arbitrary points.

use super::sampling::*;
use lariat_fit::RationalFitter;
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// With noise, least squares itself changes under maps that are not similarities.
    #[test]
    fn a_moved_turned_and_scaled_rope_has_the_same_weights(
        (control_points, weights) in any_rational(2..=6),
        angle in 0.0f64..7.0,
        scale in 0.5f64..2.0,
        seed in any::<u64>(),
    ) {
        let points = with_noise(&sampled(&control_points, &weights, 80), 0.3, seed);
        let (sin, cos) = (scale * angle.sin(), scale * angle.cos());
        let apply = |p: &[f64; 2]| [cos * p[0] - sin * p[1] + 30.0, sin * p[0] + cos * p[1] - 70.0];
        let moved: Vec<_> = points.iter().map(apply).collect();
        let mut fitter = RationalFitter::new(weights.len() - 1, 80, false);
        let fit = fitter.fit(&points);
        let (first, converged) = (sampled(fit.control_points, fit.weights, 80), fit.converged);
        fitter.forget();
        let fit = fitter.fit(&moved);
        prop_assert_eq!(fit.converged, converged);
        let expected: Vec<_> = first.iter().map(apply).collect();
        // Both stop within a tenth of a standard deviation of the optimum.
        prop_assert!(apart(&sampled(fit.control_points, fit.weights, 80), &expected) < 0.06 * scale);
    }

    #[test]
    fn a_rope_read_backwards_has_its_weights_backwards(
        (control_points, weights) in any_rational(2..=6),
        seed in any::<u64>(),
    ) {
        let points = with_noise(&sampled(&control_points, &weights, 80), 0.3, seed);
        let backwards: Vec<_> = points.iter().rev().copied().collect();
        let mut fitter = RationalFitter::new(weights.len() - 1, 80, true);
        let fit = fitter.fit(&points);
        let (first, converged) = (sampled(fit.control_points, fit.weights, 80), fit.converged);
        fitter.forget();
        let fit = fitter.fit(&backwards);
        prop_assert_eq!(fit.converged, converged);
        let mut second = sampled(fit.control_points, fit.weights, 80);
        second.reverse();
        prop_assert!(apart(&first, &second) < 0.06);
    }

    #[test]
    fn no_points_are_fitted_worse_than_by_the_polynomial(
        (order, points) in (1usize..=8).prop_flat_map(|order| (Just(order), any_points(order + 1..130))),
    ) {
        let mut fitter = RationalFitter::new(order, points.len(), false);
        let polynomial = polynomial_squared(order, &points);
        for _ in 0..2 {
            let fit = fitter.fit(&points);
            prop_assert!(fit.squared_residuals <= polynomial * (1.0 + 1e-9) + 1e-12);
            prop_assert!(fit.steps <= 30);
            is_sound(&fit, &points, false)?;
            if !fit.converged {
                prop_assert!(fit.weights.iter().all(|w| *w == 1.0));
                prop_assert!(fit.squared_residuals >= polynomial * (1.0 - 1e-9) - 1e-12);
            }
        }
    }

    #[test]
    fn a_noisy_rope_has_sound_weights_and_is_met_better_than_by_the_polynomial(
        bends in prop::array::uniform3(-1.0f64..1.0),
        order in 3usize..=10,
        deviation in 0.05f64..1.0,
        seed in any::<u64>(),
    ) {
        let points = with_noise(&rope(bends, 120), deviation, seed);
        let mut fitter = RationalFitter::new(order, 120, false);
        let polynomial = polynomial_squared(order, &points);
        let fit = fitter.fit(&points);
        is_sound(&fit, &points, false)?;
        prop_assert!(fit.squared_residuals <= polynomial * (1.0 + 1e-9));
    }

    #[test]
    fn where_the_search_starts_does_not_show_in_the_curve(
        (control_points, weights) in any_rational(2..=4),
        seed in any::<u64>(),
    ) {
        let truth = sampled(&control_points, &weights, 120);
        let [before, now] = [seed, seed ^ 0xabcdef].map(|seed| with_noise(&truth, 0.1, seed));
        let mut fitter = RationalFitter::new(weights.len() - 1, 120, false);
        let cold_fit = fitter.fit(&now);
        let (cold, converged) = (sampled(cold_fit.control_points, cold_fit.weights, 120), cold_fit.converged);
        fitter.forget();
        fitter.fit(&before);
        let warm_fit = fitter.fit(&now);
        prop_assert_eq!(warm_fit.converged, converged);
        let warm = sampled(warm_fit.control_points, warm_fit.weights, 120);
        // Each is within a tenth of a standard deviation of the optimum.
        prop_assert!(apart(&warm, &cold) < 0.02, "{}", apart(&warm, &cold));
    }

    #[test]
    fn any_numbers_at_all_are_answered_and_harm_no_later_fit(
        points in prop::collection::vec(prop::array::uniform2(prop::num::f64::ANY), 20),
        order in 1usize..=19,
        pinned in any::<bool>(),
    ) {
        let rope: Vec<[f64; 2]> = (0..20).map(|i| [i as f64, (i * i) as f64 + 0.1 * (i % 3) as f64]).collect();
        let mut fitter = RationalFitter::new(order, 20, pinned);
        fitter.fit(&points);
        let fit = fitter.fit(&rope);
        // Earlier input does not affect a frame.
        prop_assert!(fit.control_points.iter().flatten().all(|c| c.is_finite()));
        is_sound(&fit, &rope, pinned)?;
    }
}

#[test]
fn as_many_points_as_control_points_say_nothing_of_weights() {
    for (order, pinned) in [(1, false), (3, false), (8, false), (3, true)] {
        let points: Vec<[f64; 2]> = rope([0.8, -0.5, 0.3], order + 1);
        let mut fitter = RationalFitter::new(order, order + 1, pinned);
        let fit = fitter.fit(&points);
        assert!(!fit.converged || fit.steps == 0);
        assert!(fit.weights.iter().all(|w| *w == 1.0));
        assert!(fit.max_px < 1e-9);
    }
}

#[test]
fn a_fit_that_did_not_converge_is_the_polynomials() {
    // NaN never converges, and the result says so.
    let mut points: Vec<[f64; 2]> = rope([0.8, -0.5, 0.3], 50);
    points[25][1] = f64::NAN;
    let mut fitter = RationalFitter::new(4, 50, false);
    let fit = fitter.fit(&points);
    assert!(!fit.converged);
    assert!(fit.weights.iter().all(|w| *w == 1.0));
    assert_eq!(fit.degrees_of_freedom, 2 * (50 - 5));
    points[25][1] = 200.0;
    assert!(
        fitter
            .fit(&points)
            .control_points
            .iter()
            .flatten()
            .all(|c| c.is_finite())
    );
}
