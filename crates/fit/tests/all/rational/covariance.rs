//! Uncertainty of a fit.

use super::sampling::*;
use crate::dense::Dense;
use lariat_fit::RationalFitter;
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn the_covariance_factor_is_that_of_the_control_points_at_the_weights(
        (control_points, weights) in any_rational(2..=5),
        pinned in any::<bool>(),
        seed in any::<u64>(),
    ) {
        let points = with_noise(&sampled(&control_points, &weights, 40), 0.3, seed);
        let count = weights.len();
        let mut fitter = RationalFitter::new(count - 1, 40, pinned);
        let weights = fitter.fit(&points).weights.to_vec();
        let found = fitter.covariance_factor().to_owned();
        // P, whose row k gives control point k from the points, by the textbook's formula.
        let basis = rational_basis(&weights, 40);
        let ends = usize::from(pinned);
        let r = Dense::from_fn(40, count - 2 * ends, |i, k| basis[i][k + ends]);
        let gram = r.transposed().times(&r);
        let inverse = gram.inverse();
        let inner = inverse.times(&r.transposed());
        let mut p = Dense::from_fn(count, 40, |_, _| 0.0);
        for k in 0..count - 2 * ends {
            for i in 0..40 {
                p[(k + ends, i)] += inner[(k, i)];
                if pinned {
                    p[(k + 1, 0)] -= inner[(k, i)] * basis[i][0];
                    p[(k + 1, 39)] -= inner[(k, i)] * basis[i][count - 1];
                }
            }
        }
        if pinned {
            p[(0, 0)] = 1.0;
            p[(count - 1, 39)] = 1.0;
        }
        let expected = p.times(&p.transposed());
        for k in 0..count {
            for l in 0..count {
                let scale = (expected[(k, k)] * expected[(l, l)]).sqrt();
                prop_assert!((found[(k, l)] - expected[(k, l)]).abs() < 1e-7 * scale);
            }
        }
    }
}

#[test]
fn the_joint_covariance_is_that_of_many_noisy_fits() {
    let control_points = [
        [100.0, 100.0],
        [200.0, 400.0],
        [420.0, 350.0],
        [500.0, 120.0],
    ];
    let truth = sampled(&control_points, &[1.0, 0.6, 1.5, 0.9], 120);
    let (draws, deviation, count) = (8000, 0.1, 4);
    for pinned in [false, true] {
        let mut fitter = RationalFitter::new(count - 1, 120, pinned);
        fitter.fit(&truth);
        // The prior's ridge depends on the noise, so the factor is taken from a noisy fit.
        fitter.fit(&with_noise(&truth, deviation, 1));
        let expected = fitter.joint_covariance_factor().to_owned();
        let size = 3 * count;
        assert_eq!(expected.shape(), (size, size));
        let (mut mean, mut products) = (vec![0.0; size], vec![0.0; size * size]);
        for draw in 0..draws {
            let fit = fitter.fit(&with_noise(&truth, deviation, 100 + draw));
            assert!(fit.converged);
            let logs = fit
                .weights
                .iter()
                .zip([1.0f64, 0.6, 1.5, 0.9])
                .map(|(w, t)| w.ln() - t.ln());
            let offsets = fit.control_points.iter().zip(&control_points);
            let offsets = offsets.flat_map(|(p, t)| [p[0] - t[0], p[1] - t[1]]);
            let state: Vec<f64> = offsets.chain(logs).collect();
            for k in 0..size {
                mean[k] += state[k] / draws as f64;
                for l in 0..size {
                    products[k * size + l] += state[k] * state[l] / draws as f64;
                }
            }
        }
        for k in 0..size {
            for l in 0..size {
                let found = (products[k * size + l] - mean[k] * mean[l]) / deviation.powi(2);
                let scale = (expected[(k, k)] * expected[(l, l)]).sqrt();
                // A covariance of 8000 draws is accurate to √(2/8000) = 1.6 %. The bound is four
                // times that for the largest of 144, and the rest for nonlinearity.
                assert!(
                    (found - expected[(k, l)]).abs() < 0.08 * scale,
                    "{pinned} {k} {l}: {found} {}",
                    expected[(k, l)]
                );
            }
        }
    }
}

#[test]
fn after_a_fit_that_did_not_converge_the_weights_are_known() {
    let mut points = rope([0.8, -0.5, 0.3], 30);
    let mut fitter = RationalFitter::new(3, 30, true);
    points[7][0] = f64::NAN;
    assert!(!fitter.fit(&points).converged);
    let joint = fitter.joint_covariance_factor().to_owned();
    let fixed = fitter.covariance_factor();
    for k in 0..12 {
        for l in 0..12 {
            let known = k < 8 && l < 8 && k % 2 == l % 2;
            let expected = if known { fixed[(k / 2, l / 2)] } else { 0.0 };
            assert_eq!(joint[(k, l)], expected);
        }
    }
}
