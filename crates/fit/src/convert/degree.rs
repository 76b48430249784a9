//! Changes the order of Bezier curves. A higher order represents the same curve; a lower one gives
//! the nearest curve of that order.

use crate::bezier::bernstein;
use crate::curve::{Curve, CurveError};
use crate::factor::least_squares;
use faer::Mat;

/// A Bezier curve reduced to a lower order.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Reduced<const D: usize = 2> {
    /// Control points: one more than the order.
    pub control_points: Vec<[f64; D]>,
    /// Largest distance between points of the old and of the new curve at the same ρ (px). No point
    /// of either curve is farther than this from the other curve.
    pub largest_distance: f64,
}

/// Elevates the order of a Bezier curve `by` this many. The curve is exactly the same: each new
/// control point is a mean of two control points of the order below. Orders above 31 are allowed,
/// although no [`Curve`] has them.
///
/// For a rational curve, pass the control points times their weights, with the weight as the last
/// coordinate.
pub fn elevate_degree<const D: usize>(control_points: &[[f64; D]], by: usize) -> Vec<[f64; D]> {
    let mut points = control_points.to_vec();
    let Some(&last) = points.last() else {
        return points;
    };
    for _ in 0..by {
        let order = points.len();
        points.push(last);
        for j in (1..order).rev() {
            let share = j as f64 / order as f64;
            let before = points[j - 1];
            for (axis, coordinate) in points[j].iter_mut().enumerate() {
                *coordinate = share * before[axis] + (1.0 - share) * *coordinate;
            }
        }
    }
    points
}

/// Finds the Bezier curve of a lower `order` that is nearest to this one. It minimizes the integral
/// over ρ of the squared distance between points at the same ρ. With `keep_ends`, both ends stay
/// (from order 1; a curve of order 0 is a point). An order that is not lower gives the same curve,
/// elevated.
///
/// # Errors
/// Fails for 0 or more than 32 control points, or if one is not finite.
pub fn reduce_degree<const D: usize>(
    control_points: &[[f64; D]],
    order: usize,
    keep_ends: bool,
) -> Result<Reduced<D>, CurveError> {
    let curve = Curve::bezier(control_points)?;
    let from = control_points.len() - 1;
    if order >= from {
        return Ok(Reduced {
            control_points: elevate_degree(control_points, order - from),
            largest_distance: 0.0,
        });
    }
    let mut reduced = vec![[0.0; D]; order + 1];
    // Indices of the control points to solve for.
    let sought = if keep_ends && order > 0 {
        (reduced[0], reduced[order]) = (control_points[0], control_points[from]);
        1..order
    } else {
        0..order + 1
    };
    if !sought.is_empty() {
        // The square of a difference has degree 2 n, so n + 1 nodes give its integral exactly.
        // Least squares over the nodes is then least squares over the whole curve.
        let nodes = gauss_legendre(from + 1);
        let mut matrix = Mat::zeros(nodes.len(), sought.len());
        let mut wanted = Mat::zeros(nodes.len(), D);
        let mut values = vec![0.0; order + 1];
        for (row, &[rho, weight]) in nodes.iter().enumerate() {
            let root = weight.sqrt();
            bernstein(order, rho, &mut values);
            for (column, j) in sought.clone().enumerate() {
                matrix[(row, column)] = root * values[j];
            }
            let point = curve.point(rho);
            for axis in 0..D {
                let kept: f64 = (0..=order).map(|j| values[j] * reduced[j][axis]).sum();
                wanted[(row, axis)] = root * (point[axis] - kept);
            }
        }
        let found = least_squares(matrix.as_ref(), wanted.as_ref());
        for (row, point) in reduced[sought].iter_mut().enumerate() {
            for axis in 0..D {
                point[axis] = found[(row, axis)];
            }
        }
    }
    let mut difference = elevate_degree(&reduced, from - order);
    for (there, here) in difference.iter_mut().zip(control_points) {
        for axis in 0..D {
            there[axis] -= here[axis];
        }
    }
    Ok(Reduced {
        largest_distance: Curve::bezier(&difference)?.farthest(),
        control_points: reduced,
    })
}

/// Gauss-Legendre nodes on [0, 1] and their weights: the zeros of the Legendre polynomial, by
/// Newton's method from Tricomi's guess (Press et al., *Numerical Recipes*, section 4.6).
fn gauss_legendre(count: usize) -> Vec<[f64; 2]> {
    (0..count)
        .map(|i| {
            let guess = std::f64::consts::PI * (i as f64 + 0.75) / (count as f64 + 0.5);
            let mut x = libm::cos(guess);
            let mut slope = 1.0;
            // Three steps are enough; more are harmless.
            for _ in 0..8 {
                let (mut here, mut before) = (1.0, 0.0);
                for degree in 0..count {
                    let n = degree as f64;
                    let next = ((2.0 * n + 1.0) * x * here - n * before) / (n + 1.0);
                    (before, here) = (here, next);
                }
                slope = count as f64 * (x * here - before) / (x * x - 1.0);
                x -= here / slope;
            }
            [0.5 * (1.0 - x), 1.0 / ((1.0 - x * x) * slope * slope)]
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn points(
        count: impl Into<prop::collection::SizeRange>,
    ) -> impl Strategy<Value = Vec<[f64; 2]>> {
        prop::collection::vec(prop::array::uniform2(-1e3f64..1e3), count)
    }

    fn apart(a: &[f64; 2], b: &[f64; 2]) -> f64 {
        (a[0] - b[0]).hypot(a[1] - b[1])
    }

    proptest! {
        #[test]
        fn an_elevated_curve_is_the_same_curve(
            control_points in points(1..=24),
            by in 0usize..=8,
            rho in 0.0f64..=1.0,
        ) {
            let elevated = elevate_degree(&control_points, by);
            prop_assert_eq!(elevated.len(), control_points.len() + by);
            let (before, after) = (Curve::bezier(&control_points), Curve::bezier(&elevated));
            prop_assert!(apart(&before.unwrap().point(rho), &after.unwrap().point(rho)) < 1e-10);
        }

        #[test]
        fn an_elevated_curve_reduced_is_what_it_was(
            control_points in points(2..=9),
            by in 1usize..=6,
            keep_ends in any::<bool>(),
        ) {
            let order = control_points.len() - 1;
            let elevated = elevate_degree(&control_points, by);
            let reduced = reduce_degree(&elevated, order, keep_ends).unwrap();
            prop_assert!(reduced.largest_distance < 1e-9);
            for (a, b) in reduced.control_points.iter().zip(&control_points) {
                // At order 8, the matrix's condition number is a few hundred.
                prop_assert!(apart(a, b) < 1e-8, "{a:?} {b:?}");
            }
        }

        #[test]
        fn no_point_of_a_reduced_curve_is_farther_than_it_says(
            control_points in points(3..=32),
            less in 1usize..=30,
            keep_ends in any::<bool>(),
        ) {
            let order = (control_points.len() - 1).saturating_sub(less);
            let reduced = reduce_degree(&control_points, order, keep_ends).unwrap();
            let before = Curve::bezier(&control_points).unwrap();
            let after = Curve::bezier(&reduced.control_points).unwrap();
            // Denser towards the ends, where polynomials change fastest.
            let seen = (0..=2000)
                .map(|i| 0.5 - 0.5 * (std::f64::consts::PI * f64::from(i) / 2000.0).cos())
                .map(|rho| apart(&before.point(rho), &after.point(rho)))
                .fold(0.0, f64::max);
            prop_assert!(seen <= reduced.largest_distance + 1e-5);
            // With ρ = (1 − cos φ)/2, the distance changes at most as fast as cos 31 φ. The steps
            // of φ are π/2000.
            prop_assert!(seen >= 0.999 * reduced.largest_distance - 1e-5);
            if keep_ends && order > 0 {
                prop_assert_eq!(after.point(0.0), before.point(0.0));
                prop_assert_eq!(after.point(1.0), before.point(1.0));
            }
        }

        #[test]
        fn reduction_knows_neither_place_nor_direction(
            control_points in points(4..=12),
            keep_ends in any::<bool>(),
            map in prop::array::uniform6(-2.0f64..2.0),
        ) {
            let order = control_points.len() - 3;
            let there = |p: &[f64; 2]| [
                map[0] * p[0] + map[1] * p[1] + 1e3 * map[2],
                map[3] * p[0] + map[4] * p[1] + 1e3 * map[5],
            ];
            let moved: Vec<_> = control_points.iter().map(there).collect();
            let found = reduce_degree(&moved, order, keep_ends).unwrap().control_points;
            let backwards: Vec<_> = control_points.iter().rev().copied().collect();
            let mut reversed = reduce_degree(&backwards, order, keep_ends).unwrap().control_points;
            reversed.reverse();
            let plain = reduce_degree(&control_points, order, keep_ends).unwrap().control_points;
            for (j, p) in plain.iter().enumerate() {
                // At order 9, the matrix's condition number is a few hundred.
                prop_assert!(apart(&found[j], &there(p)) < 1e-8);
                prop_assert!(apart(&reversed[j], p) < 1e-8);
            }
        }

        /// The nearest curve of an order is nearer than any other, tested with moved control
        /// points.
        #[test]
        fn no_change_of_a_control_point_brings_a_reduced_curve_nearer(
            control_points in points(4..=12),
            keep_ends in any::<bool>(),
            move_by in -1.0f64..1.0,
            which in 0usize..12,
        ) {
            let order = control_points.len() - 2;
            let best = reduce_degree(&control_points, order, keep_ends).unwrap().control_points;
            let curve = Curve::bezier(&control_points).unwrap();
            let squares = |candidate: &[[f64; 2]]| {
                let other = Curve::bezier(candidate).unwrap();
                let nodes = gauss_legendre(40);
                let square = |&[rho, weight]: &[f64; 2]| {
                    weight * apart(&curve.point(rho), &other.point(rho)).powi(2)
                };
                nodes.iter().map(square).sum::<f64>()
            };
            let mut moved = best.clone();
            moved[1 + which % (order - 1)][0] += move_by;
            prop_assert!(squares(&moved) >= squares(&best) * (1.0 - 1e-9) - 1e-9);
        }
    }

    #[test]
    fn the_nodes_integrate_polynomials_exactly() {
        for count in 1..=33 {
            let nodes = gauss_legendre(count);
            for power in 0..2 * count as i32 {
                let sum: f64 = nodes.iter().map(|[x, w]| w * x.powi(power)).sum();
                assert!((sum - 1.0 / f64::from(power + 1)).abs() < 1e-14);
            }
        }
    }

    /// A parabola's nearest straight line has the same integral, so the mean difference is 0.
    #[test]
    fn a_parabola_has_a_line_as_the_textbook_says() {
        let parabola = [[0.0, 0.0], [0.5, 0.0], [1.0, 1.0]];
        let line = reduce_degree(&parabola, 1, false).unwrap();
        // x² on [0, 1] is nearest to x − 1/6.
        assert!((line.control_points[0][1] + 1.0 / 6.0).abs() < 1e-14);
        assert!((line.control_points[1][1] - 5.0 / 6.0).abs() < 1e-14);
        assert!((line.largest_distance - 1.0 / 6.0).abs() < 1e-12);
    }
}
