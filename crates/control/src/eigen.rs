//! Eigenvalues and eigenvectors of a small symmetric matrix by Jacobi rotations (G. Golub, C. Van
//! Loan, *Matrix Computations*, 4th edition, 8.5). Small eigenvalues, which show how near a
//! Jacobian is to singular, are also accurate to rounding.

/// Number of sweeps. Convergence is quadratic from about the fourth, so this is more than enough.
const SWEEPS: usize = 12;

/// Unordered eigenvalues, and their eigenvectors as rows.
pub(crate) struct Eigen<const N: usize> {
    pub(crate) values: [f64; N],
    pub(crate) vectors: [[f64; N]; N],
}

pub(crate) fn eigen<const N: usize>(mut a: [[f64; N]; N]) -> Eigen<N> {
    let mut vectors = [[0.0; N]; N];
    for (i, vector) in vectors.iter_mut().enumerate() {
        vector[i] = 1.0;
    }
    for _ in 0..SWEEPS {
        for i in 0..N {
            for j in i + 1..N {
                rotate(&mut a, &mut vectors, i, j);
            }
        }
    }
    Eigen {
        values: std::array::from_fn(|i| a[i][i]),
        vectors,
    }
}

/// Makes entry (i, j) zero, with the smaller of the two possible angles.
fn rotate<const N: usize>(a: &mut [[f64; N]; N], vectors: &mut [[f64; N]; N], i: usize, j: usize) {
    if a[i][j] == 0.0 {
        return;
    }
    let tau = (a[j][j] - a[i][i]) / (2.0 * a[i][j]);
    let sign = if tau < 0.0 { -1.0 } else { 1.0 };
    let tangent = sign / (tau.abs() + (1.0 + tau * tau).sqrt());
    let cosine = 1.0 / (1.0 + tangent * tangent).sqrt();
    let sine = tangent * cosine;
    let turn = |p: &mut f64, q: &mut f64| {
        (*p, *q) = (cosine * *p - sine * *q, sine * *p + cosine * *q);
    };
    for row in a.iter_mut() {
        let [p, q] = row.get_disjoint_mut([i, j]).expect("i < j < N");
        turn(p, q);
    }
    for rows in [a, vectors] {
        let [p, q] = rows.get_disjoint_mut([i, j]).expect("i < j < N");
        p.iter_mut().zip(q).for_each(|(p, q)| turn(p, q));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::coordinates;
    use crate::{Coordinates, INPUTS};
    use lariat_portable::SplitMix64;

    #[test]
    fn vectors_and_values_make_the_matrix_again() {
        let mut random = SplitMix64::new(1);
        for _ in 0..50 {
            let half: [Coordinates; INPUTS] = std::array::from_fn(|_| coordinates(&mut random));
            let matrix: [Coordinates; INPUTS] = std::array::from_fn(|i| {
                std::array::from_fn(|j| (0..INPUTS).map(|k| half[i][k] * half[j][k]).sum())
            });
            let Eigen { values, vectors } = eigen(matrix);
            for i in 0..INPUTS {
                for j in 0..INPUTS {
                    let again: f64 = (0..INPUTS)
                        .map(|k| values[k] * vectors[k][i] * vectors[k][j])
                        .sum();
                    assert!((again - matrix[i][j]).abs() < 1e-12, "{again}");
                    let unit: f64 = (0..INPUTS).map(|k| vectors[i][k] * vectors[j][k]).sum();
                    assert!((unit - f64::from(u8::from(i == j))).abs() < 1e-13, "{unit}");
                }
            }
        }
    }
}
