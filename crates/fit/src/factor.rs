//! Matrix factors by faer: QR, Cholesky, triangular inverses and singular values of matrices with
//! some hundred rows and at most 32 columns. They are computed in [`Real`], so they are the same on
//! every machine.

use crate::scalar::Real;
use faer::linalg::{triangular_inverse, triangular_solve};
use faer::{Mat, MatRef, Par, Side};

/// Householder QR of a matrix with no fewer rows than columns: `A = QR`.
#[derive(Debug)]
pub(crate) struct Qr {
    /// Orthonormal columns, as many as the matrix has.
    q: Mat<f64>,
    /// Zero below the diagonal.
    r: Mat<f64>,
}

impl Qr {
    pub(crate) fn new(a: MatRef<'_, f64>) -> Self {
        let factors = real(a).qr();
        Self {
            q: number(factors.compute_thin_Q().as_ref()),
            r: number(factors.thin_R()),
        }
    }

    pub(crate) fn q(&self) -> MatRef<'_, f64> {
        self.q.as_ref()
    }

    pub(crate) fn r(&self) -> MatRef<'_, f64> {
        self.r.as_ref()
    }

    /// `(AᵀA)⁻¹Aᵀ = R⁻¹Qᵀ`.
    ///
    /// `Y = R⁻¹` is solved from the left (`Y R = I`, as `Rᵀ Yᵀ = I`), so `Y R` is the identity up
    /// to ε cond(A). If `R X = Qᵀ` were solved instead, `X A` would be the identity only up to ε
    /// cond(A)², and a product with `X` would not recover a curve's own control points at high
    /// order.
    pub(crate) fn pseudoinverse(&self) -> Mat<f64> {
        let count = self.r.ncols();
        let mut y_transposed = Mat::identity(count, count);
        triangular_solve::solve_lower_triangular_in_place(
            real(self.r()).transpose(),
            y_transposed.as_mut(),
            Par::Seq,
        );
        let y_transposed = number(y_transposed.as_ref());
        crate::matrix::product(self.q(), y_transposed.as_ref())
            .transpose()
            .to_owned()
    }

    /// `R⁻¹`, column by column: `R R⁻¹` is the identity up to rounding.
    pub(crate) fn inverse_of_r(&self) -> Mat<f64> {
        let count = self.r.ncols();
        let mut inverse = Mat::zeros(count, count);
        triangular_inverse::invert_upper_triangular(
            inverse.as_mut(),
            real(self.r()).as_ref(),
            Par::Seq,
        );
        number(inverse.as_ref())
    }

    /// 2-norm condition number, that of `R`. It is infinite if the columns are linearly dependent,
    /// or if the matrix contains a NaN.
    pub(crate) fn condition(&self) -> f64 {
        let values = real(self.r()).singular_values().unwrap_or_default();
        let (Some(largest), Some(smallest)) = (values.first(), values.last()) else {
            return f64::INFINITY;
        };
        let condition = largest.0 / smallest.0;
        // Also rejects NaN.
        if (1.0..f64::INFINITY).contains(&condition) {
            condition
        } else {
            f64::INFINITY
        }
    }
}

/// `L` of `m = LLᵀ`, zero above its diagonal; `None` if `m` is not numerically positive definite.
pub(crate) fn cholesky(m: MatRef<'_, f64>) -> Option<Mat<f64>> {
    let factors = real(m).llt(Side::Lower).ok()?;
    Some(number(factors.L()))
}

/// The least-squares solution `X` of `A X ≈ B`, by QR with column pivoting.
pub(crate) fn least_squares(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Mat<f64> {
    use faer::linalg::solvers::SolveLstsq;
    number(real(a).col_piv_qr().solve_lstsq(real(b)).as_ref())
}

fn real(matrix: MatRef<'_, f64>) -> Mat<Real> {
    Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| Real(matrix[(i, j)]))
}

fn number(matrix: MatRef<'_, Real>) -> Mat<f64> {
    Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| matrix[(i, j)].0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::matrix::product;
    use proptest::prelude::*;

    /// Numbers between −1 and 1, with columns scaled by factors down to `10⁻⁶`.
    fn matrices() -> impl Strategy<Value = Mat<f64>> {
        (1usize..=32, 0usize..=60).prop_flat_map(|(columns, more)| {
            let rows = columns + more;
            let numbers = prop::collection::vec(-1.0f64..1.0, rows * columns);
            let sizes = prop::collection::vec(0i32..=6, columns);
            (numbers, sizes).prop_map(move |(numbers, sizes)| {
                Mat::from_fn(rows, columns, |i, j| {
                    numbers[j * rows + i] * 10f64.powi(-sizes[j])
                })
            })
        })
    }

    fn length(column: &[f64]) -> f64 {
        column.iter().map(|x| x * x).sum::<f64>().sqrt()
    }

    /// The largest difference of two corresponding numbers.
    fn apart(a: &Mat<f64>, b: &Mat<f64>) -> f64 {
        assert_eq!(a.shape(), b.shape());
        let columns = (0..a.ncols()).flat_map(|j| {
            let column = a.col_as_slice(j).iter().zip(b.col_as_slice(j));
            column.map(|(a, b)| (a - b).abs())
        });
        columns.fold(0.0, f64::max)
    }

    proptest! {
        #[test]
        fn q_r_is_the_matrix(a in matrices()) {
            let factors = Qr::new(a.as_ref());
            let again = product(factors.q(), factors.r());
            let gram = product(factors.q().transpose(), factors.q());
            for j in 0..a.ncols() {
                let size = length(a.col_as_slice(j));
                for i in 0..a.nrows() {
                    prop_assert!((again[(i, j)] - a[(i, j)]).abs() <= 1e-13 * size);
                }
                for k in 0..a.ncols() {
                    let expected = if j == k { 1.0 } else { 0.0 };
                    prop_assert!((gram[(j, k)] - expected).abs() < 1e-13);
                    prop_assert!(k <= j || factors.r()[(k, j)] == 0.0);
                }
            }
        }

        /// `U diag(s) Vᵀ` of orthonormal `U` and `V` has the singular values `s` and the
        /// pseudoinverse `V diag(1/s) Uᵀ`.
        #[test]
        fn condition_and_pseudoinverse_are_those_of_the_singular_values(
            a in matrices(), range in 0.0f64..8.0,
        ) {
            let count = a.ncols();
            let values: Vec<f64> = (0..count)
                .map(|j| 10f64.powf(-range * j as f64 / count.max(2) as f64))
                .collect();
            let u = Qr::new(a.as_ref()).q;
            let v = Qr::new(a.subrows(0, count)).q;
            let scaled = |m: &Mat<f64>, power: i32| {
                Mat::from_fn(m.nrows(), count, |i, j| m[(i, j)] * values[j].powi(power))
            };
            let made = product(scaled(&u, 1).as_ref(), v.transpose());
            let expected = values[0] / values[count - 1];
            let factors = Qr::new(made.as_ref());
            prop_assert!((factors.condition() / expected - 1.0).abs() < 1e-13 * expected);
            let inverse = factors.pseudoinverse();
            let other = product(scaled(&v, -1).as_ref(), u.transpose());
            prop_assert!(apart(&inverse, &other) < 1e-13 * expected * expected);
            let back = product(factors.r(), factors.inverse_of_r().as_ref());
            prop_assert!(apart(&back, &Mat::identity(count, count)) < 1e-13 * expected);
        }

        #[test]
        fn l_times_its_transpose_is_the_matrix(a in matrices()) {
            let mut gram = product(a.transpose(), a.as_ref());
            for j in 0..gram.ncols() {
                gram[(j, j)] += 1e-3;
            }
            let l = cholesky(gram.as_ref()).expect("the diagonal is large enough");
            let again = product(l.as_ref(), l.transpose());
            prop_assert!(apart(&again, &gram) < 1e-11);
        }
    }

    #[test]
    fn what_has_no_factor_is_refused() {
        let negative = Mat::from_fn(2, 2, |i, j| if i == j { -1.0 } else { 0.0 });
        assert!(cholesky(negative.as_ref()).is_none());
        let twice = Mat::from_fn(4, 2, |i, _| i as f64);
        assert!(Qr::new(twice.as_ref()).condition() > 1e15);
        let nan = Mat::from_fn(4, 2, |_, _| f64::NAN);
        assert!(Qr::new(nan.as_ref()).condition().is_infinite());
        assert!(cholesky(nan.transpose().subcols(0, 2)).is_none());
    }
}
