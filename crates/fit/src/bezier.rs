//! Bernstein polynomials and their curves, by de Casteljau's recurrence. It consists only of sums
//! and products of nonnegative numbers, so every value is accurate to a few ulp at any order.

/// Writes the `order + 1` Bernstein polynomials of that order at `rho` (equation 4 of the paper) to
/// `values`: `values[j] = n!/(j!(n−j)!) (1−ρ)ⁿ⁻ʲ ρʲ`.
///
/// They sum to one for any `rho`, and are never negative for `rho` in `[0, 1]`.
///
/// # Panics
/// If `values` does not have exactly `order + 1` elements.
pub fn bernstein(order: usize, rho: f64, values: &mut [f64]) {
    assert_eq!(
        values.len(),
        order + 1,
        "an order has one polynomial more than its number"
    );
    let rest = 1.0 - rho;
    values[0] = 1.0;
    for degree in 1..=order {
        // B_j of this degree = (1 − ρ) B_j + ρ B_{j−1} of the degree below, from the top down in
        // place.
        values[degree] = rho * values[degree - 1];
        for j in (1..degree).rev() {
            values[j] = rest * values[j] + rho * values[j - 1];
        }
        values[0] *= rest;
    }
}

/// Returns the point at `rho` on the Bezier curve of these control points, by de Casteljau's
/// algorithm, in the control points' unit (px). Without control points it is `[NaN, NaN]`.
///
/// Curves of up to 32 control points need no allocation.
pub fn point_at(control_points: &[[f64; 2]], rho: f64) -> [f64; 2] {
    let mut on_stack = [[0.0; 2]; 32];
    let mut on_heap;
    let count = control_points.len();
    let level = if count <= on_stack.len() {
        &mut on_stack[..count]
    } else {
        on_heap = vec![[0.0; 2]; count];
        &mut on_heap[..]
    };
    level.copy_from_slice(control_points);
    for remaining in (1..count).rev() {
        for j in 0..remaining {
            level[j] = [
                (1.0 - rho) * level[j][0] + rho * level[j + 1][0],
                (1.0 - rho) * level[j][1] + rho * level[j + 1][1],
            ];
        }
    }
    level.first().copied().unwrap_or([f64::NAN; 2])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn binomial(n: usize, k: usize) -> f64 {
        (0..k).fold(1.0, |product, i| product * (n - i) as f64 / (i + 1) as f64)
    }

    proptest! {
        #[test]
        fn the_recurrence_equals_the_definition(order in 0usize..=31, rho in 0.0f64..=1.0) {
            let mut values = vec![0.0; order + 1];
            bernstein(order, rho, &mut values);
            for (j, &value) in values.iter().enumerate() {
                let defined =
                    binomial(order, j) * (1.0 - rho).powi((order - j) as i32) * rho.powi(j as i32);
                // 31 steps of two roundings each, and as many again in the definition itself.
                prop_assert!((value - defined).abs() <= 1e-13 * defined, "{j}: {value} {defined}");
            }
        }

        #[test]
        fn the_polynomials_sum_to_one(order in 0usize..=31, rho in 0.0f64..=1.0) {
            let mut values = vec![0.0; order + 1];
            bernstein(order, rho, &mut values);
            prop_assert!((values.iter().sum::<f64>() - 1.0).abs() < 1e-14);
        }

        #[test]
        fn a_point_is_the_sum_of_control_points_by_polynomials(
            control_points in prop::collection::vec(prop::array::uniform2(-1e3f64..1e3), 1..40),
            rho in 0.0f64..=1.0,
        ) {
            let mut values = vec![0.0; control_points.len()];
            bernstein(control_points.len() - 1, rho, &mut values);
            let point = point_at(&control_points, rho);
            for axis in 0..2 {
                let sum: f64 = control_points.iter().zip(&values).map(|(p, b)| p[axis] * b).sum();
                prop_assert!((point[axis] - sum).abs() < 1e-10);
            }
        }
    }

    #[test]
    fn a_curve_starts_and_ends_at_its_outer_control_points() {
        let control_points = [[3.0, 4.0], [50.0, 60.0], [7.0, 8.0]];
        assert_eq!(point_at(&control_points, 0.0), [3.0, 4.0]);
        assert_eq!(point_at(&control_points, 1.0), [7.0, 8.0]);
        assert!(point_at(&[], 0.5)[0].is_nan());
    }
}
