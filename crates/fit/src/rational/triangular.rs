//! Cholesky factors and triangular solves for matrices of at most 32 rows, row by row, in place.

/// Maximum number of rows: the maximum number of control points.
const MAX_ROWS: usize = crate::MAX_ORDER + 1;

/// Replaces the lower triangle of the symmetric `matrix` (`size` × `size`, at most 32, row-major;
/// only that triangle is read) by Cholesky's `L`. Returns whether the matrix is numerically
/// positive definite.
pub(super) fn factorize(matrix: &mut [f64], size: usize) -> bool {
    // Divides once per row instead of once per number: a division takes four times as long as a
    // product.
    let mut inverse = [0.0; MAX_ROWS];
    for k in 0..size {
        let (above, rest) = matrix.split_at_mut(k * size);
        let row = &mut rest[..=k];
        for (l, other) in above.chunks_exact(size).enumerate() {
            let sum: f64 = row[..l].iter().zip(other).map(|(a, b)| a * b).sum();
            row[l] = (row[l] - sum) * inverse[l];
        }
        let pivot = row[k] - row[..k].iter().map(|a| a * a).sum::<f64>();
        // Not `<=`, so that NaN is rejected.
        if !matches!(pivot.partial_cmp(&0.0), Some(std::cmp::Ordering::Greater)) {
            return false;
        }
        row[k] = pivot.sqrt();
        inverse[k] = 1.0 / row[k];
    }
    true
}

/// Replaces `right` (`size` rows of `width` numbers) by `L⁻¹ right`.
#[inline(always)]
pub(super) fn solve_lower(l: &[f64], size: usize, right: &mut [f64], width: usize) {
    for k in 0..size {
        let (done, rest) = right.split_at_mut(k * width);
        let row = &mut rest[..width];
        for (j, other) in done.chunks_exact(width).enumerate() {
            super::kernels::add_multiple(row, -l[k * size + j], other);
        }
        let inverse = 1.0 / l[k * size + k];
        row.iter_mut().for_each(|number| *number *= inverse);
    }
}

/// Replaces `right` (`size` rows of `width` numbers) by `L⁻ᵀ right`.
#[inline(always)]
pub(super) fn solve_lower_transposed(l: &[f64], size: usize, right: &mut [f64], width: usize) {
    for k in (0..size).rev() {
        let (rest, row) = right.split_at_mut(k * width);
        let row = &mut row[..width];
        let inverse = 1.0 / l[k * size + k];
        row.iter_mut().for_each(|number| *number *= inverse);
        for (j, other) in rest.chunks_exact_mut(width).enumerate() {
            super::kernels::add_multiple(other, -l[k * size + j], row);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn what_is_solved_gives_the_right_hand_side_back(
            size in 1usize..12,
            width in 1usize..4,
            numbers in prop::collection::vec(-1.0f64..1.0, 200),
        ) {
            // M Mᵀ + 1 is positive definite, with a condition number of at most 1 + 12².
            let m = |k: usize, l: usize| numbers[k * size + l];
            let matrix: Vec<f64> = (0..size * size)
                .map(|at| {
                    let (k, l) = (at / size, at % size);
                    (0..size).map(|j| m(k, j) * m(l, j)).sum::<f64>() + f64::from(u8::from(k == l))
                })
                .collect();
            let right = &numbers[150..150 + size * width];
            let (mut l, mut solution) = (matrix.clone(), right.to_vec());
            prop_assert!(factorize(&mut l, size));
            solve_lower(&l, size, &mut solution, width);
            solve_lower_transposed(&l, size, &mut solution, width);
            for k in 0..size {
                for column in 0..width {
                    let product: f64 =
                        (0..size).map(|j| matrix[k * size + j] * solution[j * width + column]).sum();
                    prop_assert!((product - right[k * width + column]).abs() < 1e-11);
                }
            }
        }
    }

    #[test]
    fn what_is_not_positive_definite_is_said_so() {
        assert!(!factorize(&mut [1.0, 0.0, 2.0, 1.0], 2));
        assert!(!factorize(&mut [f64::NAN], 1));
        assert!(!factorize(&mut [0.0], 1));
    }
}
