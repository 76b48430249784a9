//! Places knots where a rope bends, for ropes that a spline of even knots cannot follow.
//!
//! The density of the knots along the rope is raised where the curve misses its points and lowered
//! elsewhere, in several rounds. De Boor's NEWNOT (*A Practical Guide to Splines*, chapter XII)
//! instead uses an estimate of the next derivative, which is dominated by the noise of the points.

use crate::basis::{Basis, MAX_CONTROL_POINTS};
use crate::functions;
use crate::tolerance::Tolerance;

/// Number of times that knots are moved.
const ROUNDS: usize = 8;
/// Without any error, the density is multiplied by the eighth root of this.
const FLOOR: f64 = 0.05;
/// Maximum density of knots relative to even ones.
const CLOSEST: f64 = 2.0;
/// Degree of the pieces, which are cubic.
pub(crate) const DEGREE: usize = 3;
/// Number of nonzero entries in a row of the normal equations, from the diagonal on.
const BAND: usize = DEGREE + 1;

/// Finds the clamped knots of the cubic B-spline with this many control points that is nearest to
/// the points, by the tolerance's measure. Also returns the factor by which the tolerance would
/// have to grow. Returns `None` if there are too few points for knots closer than even ones.
pub(crate) fn knots<const D: usize>(
    control_points: usize,
    points: &[[f64; D]],
    hidden: &[bool],
    tolerance: Tolerance,
) -> Option<(f64, Vec<f64>)> {
    let spans = control_points.checked_sub(DEGREE)?;
    let steps = points.len().checked_sub(1)?;
    if (steps as f64) < CLOSEST * spans as f64 {
        return None;
    }
    let mut density = vec![1.0; steps];
    let mut best = (f64::INFINITY, Vec::new());
    for _ in 0..=ROUNDS {
        let knots = spread(&density, control_points);
        let mut squared = squared_distances(&knots, points)?;
        for (distance, _) in squared
            .iter_mut()
            .zip(hidden)
            .filter(|(_, hidden)| **hidden)
        {
            *distance = 0.0;
        }
        let excess = tolerance.excess(&mut squared.clone(), hidden);
        if excess < best.0 {
            best = (excess, knots);
        }
        thicken(&mut density, &squared);
    }
    (!best.1.is_empty()).then_some(best)
}

/// Places knots with equal shares of the density between them.
fn spread(density: &[f64], control_points: usize) -> Vec<f64> {
    let (steps, spans) = (density.len(), control_points - DEGREE);
    let share = density.iter().sum::<f64>() / spans as f64;
    let mut knots = vec![0.0; DEGREE + 1];
    let (mut step, mut before) = (0, 0.0);
    for knot in 1..spans {
        let wanted = share * knot as f64;
        while step + 1 < steps && before + density[step] < wanted {
            before += density[step];
            step += 1;
        }
        knots.push((step as f64 + (wanted - before) / density[step]) / steps as f64);
    }
    knots.resize(control_points + DEGREE + 1, 1.0);
    knots
}

/// Raises the density where points are far off.
fn thicken(density: &mut [f64], squared: &[f64]) {
    let error = smoothed(squared, 2);
    let mean = error.iter().sum::<f64>() / error.len() as f64;
    if mean.is_nan() || mean <= 0.0 {
        return;
    }
    for (step, density) in density.iter_mut().enumerate() {
        let here = 0.5 * (error[step] + error[step + 1]) / mean;
        // The eighth root, because a squared error is proportional to the eighth power of the steps
        // between knots.
        *density *= (here + FLOOR).sqrt().sqrt().sqrt();
    }
    let mut even = smoothed(density, 1);
    // Clipping lowers the mean, so normalizing and clipping are repeated.
    for _ in 0..4 {
        let mean = even.iter().sum::<f64>() / even.len() as f64;
        even.iter_mut().for_each(|d| *d = (*d / mean).min(CLOSEST));
    }
    density.copy_from_slice(&even);
}

/// The mean over `reach` neighbors on either side, or as many as there are.
fn smoothed(values: &[f64], reach: usize) -> Vec<f64> {
    let around = |i: usize| {
        let near = &values[i.saturating_sub(reach)..(i + reach + 1).min(values.len())];
        near.iter().sum::<f64>() / near.len() as f64
    };
    (0..values.len()).map(around).collect()
}

/// Squared distances of evenly spaced points from the nearest spline, by its normal equations.
/// `None` if the points do not determine it.
fn squared_distances<const D: usize>(knots: &[f64], points: &[[f64; D]]) -> Option<Vec<f64>> {
    let count = knots.len() - DEGREE - 1;
    let basis = Basis::BSpline {
        degree: DEGREE,
        control_points: count,
        knots: crate::basis::Knots::Placed,
    };
    let mut values = [0.0; MAX_CONTROL_POINTS];
    // First nonzero function of the i-th point, and the values of its functions.
    let rows: Vec<(usize, [f64; BAND])> = (0..points.len())
        .map(|i| {
            let rho = basis.even_rho(i, points.len());
            let first = functions::span(DEGREE, knots, rho) - DEGREE;
            functions::values(basis, knots, rho, &mut values[..count]);
            (first, std::array::from_fn(|k| values[first + k]))
        })
        .collect();
    let mut matrix = vec![[0.0; BAND]; count];
    let mut right = vec![[0.0; D]; count];
    for ((first, row), point) in rows.iter().zip(points) {
        for (k, value) in row.iter().enumerate() {
            for (to, other) in matrix[first + k].iter_mut().zip(&row[k..]) {
                *to += value * other;
            }
            for (to, c) in right[first + k].iter_mut().zip(point) {
                *to += value * c;
            }
        }
    }
    solve(&mut matrix, &mut right)?;
    let distance = |((first, row), point): (&(usize, [f64; BAND]), &[f64; D])| {
        let mut sum = 0.0;
        for axis in 0..D {
            let mut off = point[axis];
            for (k, value) in row.iter().enumerate() {
                off -= value * right[first + k][axis];
            }
            sum += off * off;
        }
        sum
    };
    Some(rows.iter().zip(points).map(distance).collect())
}

/// Solves a positive definite banded system in place by LDLᵀ. `matrix` holds each row from its
/// diagonal on.
fn solve<const D: usize>(matrix: &mut [[f64; BAND]], right: &mut [[f64; D]]) -> Option<()> {
    let count = matrix.len();
    for j in 0..count {
        let row = matrix[j];
        // Condition numbers are small, so a 0 here means a basis function without points.
        if row[0].is_nan() || row[0] <= 1e-9 {
            return None;
        }
        for k in 1..BAND.min(count - j) {
            let factor = row[k] / row[0];
            for l in k..BAND {
                matrix[j + k][l - k] -= factor * row[l];
            }
            let above = right[j];
            for (to, from) in right[j + k].iter_mut().zip(above) {
                *to -= factor * from;
            }
        }
    }
    for j in (0..count).rev() {
        let row = matrix[j];
        right[j] = std::array::from_fn(|axis| {
            let known: f64 = (1..BAND.min(count - j))
                .map(|k| row[k] * right[j + k][axis])
                .sum();
            (right[j][axis] - known) / row[0]
        });
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_density_has_even_knots_and_a_thicker_part_more_of_them() {
        let even = spread(&[1.0; 116], 32);
        for (k, knot) in even[4..32].iter().enumerate() {
            assert!((knot - (k + 1) as f64 / 29.0).abs() < 1e-12);
        }
        let mut density = [1.0; 116];
        density[58..].fill(2.0);
        let uneven = spread(&density, 32);
        let later = uneven[4..32].iter().filter(|knot| **knot > 0.5).count();
        assert_eq!((uneven.len(), later), (36, 19));
        assert!(uneven.is_sorted());
    }

    #[test]
    fn a_spline_on_its_own_knots_is_found_again() {
        let knots = spread(&[1.0; 119], 12);
        let line: Vec<[f64; 2]> = (0..120)
            .map(|i| {
                let rho = f64::from(i) / 119.0;
                [400.0 * rho, 90.0 * rho * rho * (1.0 - rho)]
            })
            .collect();
        let squared = squared_distances(&knots, &line).unwrap();
        assert!(squared.iter().all(|d| *d < 1e-18), "{squared:?}");
    }
}
