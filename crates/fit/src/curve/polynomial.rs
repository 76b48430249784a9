//! Evaluates Bezier polynomials and their derivatives in a number of steps proportional to the
//! order, by nested multiplication of the Bernstein form (Schumaker and Volk, *Efficient evaluation
//! of multivariate polynomials*, Computer Aided Geometric Design 3, 1986).
//!
//! ```text
//! Σ C(n,j) bⱼ ρʲ (1−ρ)ⁿ⁻ʲ = (1−ρ)ⁿ (((C(n,n) bₙ r + C(n,n−1) bₙ₋₁) r + …) r + b₀),   r = ρ/(1−ρ)
//! ```
//!
//! For ρ > ½ it starts from the other end, so that |r| ≤ 1. As in de Casteljau's recurrence, all
//! factors are positive, so the error is a few n ulp of the largest control point at any order. The
//! k-th derivative is such a polynomial too, with the coefficients `n!/(n−k)! Δᵏbⱼ`.

use crate::basis::MAX_CONTROL_POINTS;

/// `BINOMIALS[n][j]` is C(n, j); exact, as all are below 2⁵³.
const BINOMIALS: [[f64; MAX_CONTROL_POINTS]; MAX_CONTROL_POINTS] = {
    let mut table = [[0.0; MAX_CONTROL_POINTS]; MAX_CONTROL_POINTS];
    let mut n = 0;
    while n < MAX_CONTROL_POINTS {
        table[n][0] = 1.0;
        let mut j = 1;
        while j <= n {
            table[n][j] = table[n - 1][j - 1] + table[n - 1][j];
            j += 1;
        }
        n += 1;
    }
    table
};

/// The binomial coefficients C(n, j), j from 0 to n.
#[inline]
pub(crate) fn binomials(n: usize) -> &'static [f64] {
    &BINOMIALS[n][..=n]
}

/// Derivatives 0 to `K − 1` at `rho` of the Bezier polynomial with these 1 to 32 control points.
/// `K` is at most 4.
#[inline]
pub(crate) fn jet<const D: usize, const K: usize>(points: &[[f64; D]], rho: f64) -> [[f64; D]; K] {
    // Derivatives above the order are 0.
    match points.len() {
        count if count >= K => nested(points, rho),
        3 => padded(nested::<D, 3>(points, rho)),
        2 => padded(nested::<D, 2>(points, rho)),
        _ => padded(nested::<D, 1>(points, rho)),
    }
}

fn padded<const D: usize, const L: usize, const K: usize>(jet: [[f64; D]; L]) -> [[f64; D]; K] {
    std::array::from_fn(|k| jet.get(k).copied().unwrap_or([0.0; D]))
}

/// Evaluates all K polynomials together, because each step of a polynomial waits for its previous
/// step. Polynomials of higher differences are shorter, and begin later or end earlier.
#[inline]
fn nested<const D: usize, const K: usize>(points: &[[f64; D]], rho: f64) -> [[f64; D]; K] {
    let order = points.len() - 1;
    let rest = 1.0 - rho;
    let low = rho <= 0.5;
    let (ratio, base) = if low {
        (rho / rest, rest)
    } else {
        (rest / rho, rho)
    };
    let rows: [&[f64]; K] = std::array::from_fn(|k| binomials(order - k));
    let mut jet = [[0.0; D]; K];
    // The last points have fewer differences than K.
    let shared = order + 1 - K;
    if low {
        for j in (shared + 1..=order).rev() {
            step(
                &mut jet,
                j,
                differences(&points[j..]),
                order + 1 - j,
                ratio,
                &rows,
            );
        }
        for (j, window) in points.windows(K).enumerate().rev() {
            step(&mut jet, j, differences(window), K, ratio, &rows);
        }
    } else {
        for (j, window) in points.windows(K).enumerate() {
            step(&mut jet, j, differences(window), K, ratio, &rows);
        }
        for j in shared + 1..=order {
            step(
                &mut jet,
                j,
                differences(&points[j..]),
                order + 1 - j,
                ratio,
                &rows,
            );
        }
    }
    let mut power = base.powi((order + 1 - K) as i32);
    for (k, derivative) in jet.iter_mut().enumerate().rev() {
        let falling = (0..k).fold(power, |product, i| product * (order - i) as f64);
        *derivative = derivative.map(|nested| nested * falling);
        power *= base;
    }
    jet
}

#[inline(always)]
fn step<const D: usize, const K: usize>(
    jet: &mut [[f64; D]; K],
    j: usize,
    differences: [[f64; D]; K],
    count: usize,
    ratio: f64,
    rows: &[&[f64]; K],
) {
    for k in 0..count {
        let binomial = rows[k][j];
        for axis in 0..D {
            jet[k][axis] = jet[k][axis] * ratio + binomial * differences[k][axis];
        }
    }
}

/// Differences of the first point. Those for which there are too few points are meaningless.
#[inline(always)]
fn differences<const D: usize, const K: usize>(points: &[[f64; D]]) -> [[f64; D]; K] {
    let mut level: [_; K] = std::array::from_fn(|j| points.get(j).copied().unwrap_or([0.0; D]));
    for done in 1..K {
        for j in (done..K).rev() {
            let before = level[j - 1];
            for axis in 0..D {
                level[j][axis] -= before[axis];
            }
        }
    }
    level
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bezier::point_at;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn nested_multiplication_equals_de_casteljau(
            points in prop::collection::vec(prop::array::uniform2(-1e3f64..1e3), 1..=32),
            rho in 0.0f64..=1.0,
        ) {
            let [point] = jet::<2, 1>(&points, rho);
            let expected = point_at(&points, rho);
            for axis in 0..2 {
                // Some 3 n roundings of numbers up to 1e3.
                prop_assert!((point[axis] - expected[axis]).abs() < 1e-10 / 5.0);
            }
        }

        #[test]
        fn a_derivative_is_the_curve_of_the_differences(
            points in prop::collection::vec(prop::array::uniform2(-1e3f64..1e3), 4..=32),
            rho in 0.0f64..=1.0,
        ) {
            let found = jet::<2, 4>(&points, rho);
            let mut differences = points.clone();
            let mut size = 1e3;
            for derivative in found {
                let expected = point_at(&differences, rho);
                for axis in 0..2 {
                    prop_assert!((derivative[axis] - expected[axis]).abs() < 1e-13 * size);
                }
                let factor = (differences.len() - 1) as f64;
                differences = differences
                    .windows(2)
                    .map(|pair| [0, 1].map(|axis| factor * (pair[1][axis] - pair[0][axis])))
                    .collect();
                size *= 2.0 * factor.max(1.0);
                if differences.is_empty() {
                    break;
                }
            }
        }
    }

    #[test]
    fn the_ends_are_the_outer_control_points_exactly() {
        let points: Vec<[f64; 1]> = (0..32).map(|i| [0.1 * f64::from(i * i)]).collect();
        assert_eq!(jet::<1, 1>(&points, 0.0)[0], points[0]);
        assert_eq!(jet::<1, 1>(&points, 1.0)[0], points[31]);
        assert_eq!(jet::<1, 4>(&points[..1], 0.3), [[0.0], [0.0], [0.0], [0.0]]);
    }

    #[test]
    fn binomials_are_pascals() {
        assert_eq!(binomials(4), [1.0, 4.0, 6.0, 4.0, 1.0]);
        assert_eq!(binomials(31)[15], 300_540_195.0);
    }
}
