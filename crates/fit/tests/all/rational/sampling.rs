//! Rational curves and ropes to fit, and properties of every fit.

use crate::dense::Dense;
use lariat_fit::{Fitter, MAX_WEIGHT, Options, RationalFit, bernstein};
use lariat_portable::SplitMix64;
use proptest::prelude::*;

/// Points on the rational curve, `ρᵢ = i/(N − 1)`.
pub(crate) fn sampled<const D: usize>(
    control_points: &[[f64; D]],
    weights: &[f64],
    points: usize,
) -> Vec<[f64; D]> {
    let basis = rational_basis(weights, points);
    let point = |row: &Vec<f64>| {
        std::array::from_fn(|axis| {
            row.iter()
                .zip(control_points)
                .map(|(r, p)| r * p[axis])
                .sum()
        })
    };
    basis.iter().map(point).collect()
}

/// `Rₖ(ρᵢ)`, a row for each point.
pub(crate) fn rational_basis(weights: &[f64], points: usize) -> Vec<Vec<f64>> {
    let mut values = vec![0.0; weights.len()];
    (0..points)
        .map(|i| {
            bernstein(
                weights.len() - 1,
                i as f64 / (points - 1) as f64,
                &mut values,
            );
            let sum: f64 = values.iter().zip(weights).map(|(b, w)| b * w).sum();
            values
                .iter()
                .zip(weights)
                .map(|(b, w)| b * w / sum)
                .collect()
        })
        .collect()
}

pub(crate) fn distance<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).powi(2))
        .sum::<f64>()
        .sqrt()
}

/// The largest distance between corresponding points.
pub(crate) fn apart<const D: usize>(a: &[[f64; D]], b: &[[f64; D]]) -> f64 {
    a.iter()
        .zip(b)
        .map(|(a, b)| distance(a, b))
        .fold(0.0, f64::max)
}

pub(crate) fn log_weights(weights: &[f64]) -> Vec<f64> {
    let mean = weights.iter().map(|w| w.ln()).sum::<f64>() / weights.len() as f64;
    weights.iter().map(|w| w.ln() - mean).collect()
}

/// The smallest singular value of the sampled curve's derivative with respect to control points and
/// log-weights, except the one that is 0 because a common factor of all weights has no effect.
/// Residuals of size `r` leave the log-weights uncertain by `r` divided by it.
pub(crate) fn least_sensitivity(
    control_points: &[[f64; 2]],
    weights: &[f64],
    points: usize,
) -> f64 {
    let basis = rational_basis(weights, points);
    let curve = sampled(control_points, weights, points);
    let count = weights.len();
    let change = Dense::from_fn(2 * points, 3 * count, |row, column| {
        let (i, axis, k) = (row / 2, row % 2, column % count);
        match column / count {
            0 => basis[i][k] * (control_points[k][axis] - curve[i][axis]),
            moved if moved - 1 == axis => basis[i][k],
            _ => 0.0,
        }
    });
    let values = change.singular_values();
    values[values.len() - 2]
}

/// Control points like a rope's, and weights.
pub(crate) fn any_rational(
    orders: std::ops::RangeInclusive<usize>,
) -> impl Strategy<Value = (Vec<[f64; 2]>, Vec<f64>)> {
    orders.prop_flat_map(|order| {
        let control_point = (0.0f64..60.0, -150.0f64..150.0);
        (
            prop::collection::vec(control_point, order + 1).prop_map(|points| {
                let place = |(j, (x, y)): (usize, &(f64, f64))| [100.0 * j as f64 + x, 200.0 + y];
                points.iter().enumerate().map(place).collect()
            }),
            prop::collection::vec(0.3f64..3.0, order + 1),
        )
    })
}

pub(crate) fn any_points(count: std::ops::Range<usize>) -> impl Strategy<Value = Vec<[f64; 2]>> {
    prop::collection::vec(prop::array::uniform2(-1e3f64..1e3), count)
}

/// Adds independent normal noise.
pub(crate) fn with_noise<const D: usize>(
    points: &[[f64; D]],
    deviation: f64,
    seed: u64,
) -> Vec<[f64; D]> {
    let mut random = SplitMix64::new(seed);
    points
        .iter()
        .map(|p| p.map(|c| c + deviation * random.normal()))
        .collect()
}

/// Sum of the squared residuals of the polynomial of that order.
pub(crate) fn polynomial_squared(order: usize, points: &[[f64; 2]]) -> f64 {
    let mut fitter = Fitter::new(Options::bezier(order).points(points.len())).unwrap();
    let rms_px = fitter.fit(points).unwrap().rms_px;
    points.len() as f64 * rms_px * rms_px
}

/// Checks properties of every fit, whatever the points.
pub(crate) fn is_sound(
    fit: &RationalFit<'_, 2>,
    points: &[[f64; 2]],
    pinned: bool,
) -> Result<(), TestCaseError> {
    let product: f64 = fit.weights.iter().map(|w| w.ln()).sum();
    prop_assert!(product.abs() < 1e-9);
    for weight in fit.weights {
        prop_assert!(*weight >= 1.0 / MAX_WEIGHT / 1.000001 && *weight <= MAX_WEIGHT * 1.000001);
    }
    let curve = sampled(fit.control_points, fit.weights, points.len());
    let squared: f64 = curve
        .iter()
        .zip(points)
        .map(|(f, c)| distance(f, c).powi(2))
        .sum();
    prop_assert!((squared - fit.squared_residuals).abs() < 1e-9 * (1.0 + squared));
    prop_assert!((apart(&curve, points) - fit.max_px).abs() < 1e-7);
    if pinned {
        prop_assert_eq!(fit.control_points[0], points[0]);
        prop_assert_eq!(fit.control_points.last(), points.last());
    }
    Ok(())
}

/// Points 4 px apart along a curve with these bends.
pub(crate) fn rope(bends: [f64; 3], points: usize) -> Vec<[f64; 2]> {
    let mut at = [100.0, 200.0];
    (0..points)
        .map(|i| {
            let rho = i as f64 / (points - 1) as f64;
            let waves = [3.0 * rho, 6.0 * rho, 9.0 * rho].map(f64::sin);
            let heading: f64 = waves.iter().zip(&bends).map(|(w, b)| w * b).sum();
            at = [at[0] + 4.0 * heading.cos(), at[1] + 4.0 * heading.sin()];
            at
        })
        .collect()
}
