//! Least squares by QR of the whole weighted matrix, the definition that tests compare with; and
//! random numbers.

use crate::bezier::bernstein;
use crate::factor::{Qr, least_squares};
use crate::matrix::row_by_row;
use faer::Mat;
use lariat_portable::SplitMix64;

/// The Bernstein polynomials of order `count − 1` at each `ρ`, row by row.
pub(crate) fn bernstein_rows(rho: &[f64], count: usize) -> Vec<f64> {
    let mut rows = vec![0.0; rho.len() * count];
    for (row, &rho) in rows.chunks_exact_mut(count).zip(rho) {
        bernstein(count - 1, rho, row);
    }
    rows
}

/// `points` evenly spaced in [0, 1].
pub(crate) fn uniform(points: usize) -> Vec<f64> {
    (0..points)
        .map(|i| i as f64 / (points - 1) as f64)
        .collect()
}

pub(crate) fn matrix(rows: &[f64], width: usize) -> Mat<f64> {
    Mat::from_fn(rows.len() / width, width, |i, j| rows[i * width + j])
}

/// `R⁻¹` of the QR of `rows`, row by row.
pub(crate) fn r_inverse(rows: &[f64], width: usize) -> Vec<f64> {
    let factors = Qr::new(matrix(rows, width).as_ref());
    row_by_row(factors.inverse_of_r().as_ref())
}

/// `√λ D`, second differences of control points, row by row.
pub(crate) fn differences(count: usize, lambda: f64) -> Vec<f64> {
    let mut rows = vec![0.0; count.saturating_sub(2) * count];
    for (i, row) in rows.chunks_exact_mut(count).enumerate() {
        for (number, weight) in row[i..].iter_mut().zip([1.0, -2.0, 1.0]) {
            *number = lambda.sqrt() * weight;
        }
    }
    rows
}

/// `rowsᵀ rows`.
pub(crate) fn gram(rows: &[f64], width: usize) -> Vec<f64> {
    let mut gram = vec![0.0; width * width];
    for row in rows.chunks_exact(width) {
        for (a, gram) in row.iter().zip(gram.chunks_exact_mut(width)) {
            for (b, number) in row.iter().zip(gram) {
                *number += a * b;
            }
        }
    }
    gram
}

/// Computes the control points by QR. `penalty` are rows like those of [`differences`], or empty.
pub(crate) fn solve<const D: usize>(
    b: &[f64],
    points: &[[f64; D]],
    weights: &[f64],
    pins: bool,
    penalty: &[f64],
) -> Vec<[f64; D]> {
    let count = b.len() / points.len();
    let skipped = usize::from(pins);
    let free = skipped..count - skipped;
    let rows: Vec<(&[f64], f64, [f64; D])> = b
        .chunks_exact(count)
        .zip(weights)
        .zip(points)
        .map(|((row, weight), &point)| {
            (
                row,
                weight.sqrt(),
                if *weight > 0.0 { point } else { [0.0; D] },
            )
        })
        .chain(penalty.chunks_exact(count).map(|row| (row, 1.0, [0.0; D])))
        .collect();
    let left = Mat::from_fn(rows.len(), free.len(), |i, j| {
        rows[i].1 * rows[i].0[free.start + j]
    });
    let ends = [points[0], points[points.len() - 1]];
    let right = Mat::from_fn(rows.len(), D, |i, axis| {
        let (row, scale, point) = rows[i];
        let mut right = point[axis];
        if pins {
            right -= row[0] * ends[0][axis] + row[count - 1] * ends[1][axis];
        }
        scale * right
    });
    let inner = least_squares(left.as_ref(), right.as_ref());
    let mut control_points: Vec<[f64; D]> = (0..free.len())
        .map(|j| std::array::from_fn(|axis| inner[(j, axis)]))
        .collect();
    if pins {
        control_points.insert(0, ends[0]);
        control_points.push(ends[1]);
    }
    control_points
}

/// The points of the curve at the rows of `b`.
pub(crate) fn curve<const D: usize>(b: &[f64], control_points: &[[f64; D]]) -> Vec<[f64; D]> {
    b.chunks_exact(control_points.len())
        .map(|row| {
            std::array::from_fn(|axis| {
                row.iter()
                    .zip(control_points)
                    .map(|(b, s)| b * s[axis])
                    .sum()
            })
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

/// The largest distance between two lists of points.
pub(crate) fn apart<const D: usize>(a: &[[f64; D]], b: &[[f64; D]]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter()
        .zip(b)
        .map(|(a, b)| distance(a, b))
        .fold(0.0, f64::max)
}

/// A smooth rope some hundred pixels long, with noise of this standard deviation.
pub(crate) fn rope<const D: usize>(
    rho: &[f64],
    noise_px: f64,
    random: &mut SplitMix64,
) -> Vec<[f64; D]> {
    let phase = 6.0 * random.unit();
    rho.iter()
        .map(|&rho| {
            std::array::from_fn(|axis| {
                let axis = axis as f64;
                300.0
                    + 200.0 * ((2.0 + axis) * rho + phase + axis).sin()
                    + noise_px * random.normal()
            })
        })
        .collect()
}
