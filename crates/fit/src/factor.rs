//! The factors that fits are made of, by the textbook (G. Golub, C. Van Loan, *Matrix Computations*, 4th edition), for some
//! hundred rows and at most 32 columns:
//!
//! | what | how |
//! |---|---|
//! | `A = QR` | Householder's reflections, 5.2.2 |
//! | `AᵀA = LLᵀ` | Cholesky, column by column, 4.2.3 |
//! | triangles | forward and back substitution, 3.1 |
//! | singular values | one-sided Jacobi rotations, 8.6.3 |
//!
//! None of it depends on the machine's vectors: eight partial sums, whatever holds them, and no fused multiply-adds. A library
//! that chooses its vectors at run time gives other last digits on another machine, and a recording could not be computed again.

use crate::matrix::Matrix;

/// Partial sums of a product of columns.
const SUMS: usize = 8;

/// `a · b`.
#[inline(always)]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (a, a_rest) = a.as_chunks::<SUMS>();
    let (b, b_rest) = b[..SUMS * a.len() + a_rest.len()].as_chunks::<SUMS>();
    let mut sums = [0.0; SUMS];
    for (a, b) in a.iter().zip(b) {
        for i in 0..SUMS {
            sums[i] += a[i] * b[i];
        }
    }
    for (sum, (a, b)) in sums.iter_mut().zip(a_rest.iter().zip(b_rest)) {
        *sum += a * b;
    }
    let [a, b, c, d, e, f, g, h] = sums;
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}

/// `to −= factor · from`.
#[inline(always)]
fn take(to: &mut [f64], factor: f64, from: &[f64]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to -= factor * from;
    }
}

/// Householder QR of a matrix with no fewer rows than columns.
#[derive(Debug)]
pub(crate) struct Qr {
    /// The reflections `I − τvvᵀ`: `v` from the diagonal down, 1 there.
    reflections: Matrix,
    scales: Vec<f64>,
    /// `R`, zero below the diagonal.
    r: Matrix,
}

impl Qr {
    pub(crate) fn new(a: &Matrix) -> Self {
        let (rows, columns) = (a.nrows(), a.ncols());
        let mut reflections = a.clone();
        let mut scales = vec![0.0; columns];
        let mut r = Matrix::zeros(columns, columns);
        for k in 0..columns {
            for (before, scale) in scales[..k].iter().enumerate() {
                let (done, rest) = reflections.two_columns(before, k);
                reflect(&done[before..], *scale, &mut rest[before..]);
            }
            r.column_mut(k)[..k].copy_from_slice(&reflections.column(k)[..k]);
            let v = &mut reflections.column_mut(k)[k..rows];
            let size = dot(v, v).sqrt();
            let first = v[0];
            // Away from the first number, so that nothing cancels.
            let diagonal = if first > 0.0 { -size } else { size };
            r[(k, k)] = diagonal;
            v[0] = 1.0;
            if size > 0.0 {
                scales[k] = (diagonal - first) / diagonal;
                let share = 1.0 / (first - diagonal);
                v[1..].iter_mut().for_each(|number| *number *= share);
            }
        }
        Self {
            reflections,
            scales,
            r,
        }
    }

    /// How many rows the matrix has.
    pub(crate) fn nrows(&self) -> usize {
        self.reflections.nrows()
    }

    pub(crate) fn r(&self) -> &Matrix {
        &self.r
    }

    /// Replaces a column by `Qᵀ` times it.
    #[inline(always)]
    pub(crate) fn apply_transposed(&self, column: &mut [f64]) {
        for (k, (v, &scale)) in self.reflections.columns().zip(&self.scales).enumerate() {
            reflect(&v[k..], scale, &mut column[k..]);
        }
    }

    /// The first columns of `Q`, as many as the matrix has.
    fn thin_q(&self) -> Matrix {
        let (rows, columns) = (self.reflections.nrows(), self.r.ncols());
        let mut q = Matrix::identity(rows, columns);
        for j in 0..columns {
            for k in (0..columns).rev() {
                let v = &self.reflections.column(k)[k..];
                reflect(v, self.scales[k], &mut q.column_mut(j)[k..]);
            }
        }
        q
    }

    /// `(AᵀA)⁻¹Aᵀ = R⁻¹Qᵀ`.
    ///
    /// `Y = R⁻¹` is solved from the left, row by row (`Y R = I`, as `Rᵀ Yᵀ = I`): then `Y R` is the identity
    /// up to ε cond(A). Solved column by column (`R X = Qᵀ`), `X A` would be so only up to ε cond(A)², and a
    /// product with `X` would not give a curve's own control points back at high order.
    pub(crate) fn pseudoinverse(&self) -> Matrix {
        let columns = self.r.ncols();
        let mut y_transposed = Matrix::identity(columns, columns);
        for row in 0..columns {
            let y = y_transposed.column_mut(row);
            for j in 0..columns {
                let r = self.r.column(j);
                y[j] = (y[j] - dot(&r[..j], &y[..j])) / r[j];
            }
        }
        self.thin_q().times(&y_transposed).transposed()
    }

    /// `R⁻¹`, column by column: `R R⁻¹` is the identity up to rounding.
    pub(crate) fn inverse_of_r(&self) -> Matrix {
        let columns = self.r.ncols();
        let mut inverse = Matrix::identity(columns, columns);
        for j in 0..columns {
            solve_upper(&self.r, inverse.column_mut(j));
        }
        inverse
    }

    /// The condition number in the 2-norm; infinite where a column is a sum of others, and of what is no number.
    pub(crate) fn condition(&self) -> f64 {
        // `A = QR` has the singular values of `R`.
        let values = singular_values(self.r.transposed());
        let largest = values.iter().copied().fold(0.0, f64::max);
        let smallest = values.iter().copied().fold(f64::INFINITY, f64::min);
        let condition = largest / smallest;
        if condition >= 1.0 && values.iter().all(|value| value.is_finite()) {
            condition
        } else {
            f64::INFINITY
        }
    }
}

/// Replaces a column by its mirror image, `x − τ v (v·x)`.
#[inline(always)]
fn reflect(v: &[f64], scale: f64, column: &mut [f64]) {
    let along = scale * dot(v, column);
    take(column, along, v);
}

/// Replaces the beginning of a column by what times `R` is that.
#[inline(always)]
pub(crate) fn solve_upper(r: &Matrix, column: &mut [f64]) {
    for j in (0..r.ncols()).rev() {
        let r = r.column(j);
        column[j] /= r[j];
        let known = column[j];
        take(&mut column[..j], known, r);
    }
}

/// `L` of `m = LLᵀ`, zero above its diagonal; `None` where `m` is not positive definite in this arithmetic.
pub(crate) fn cholesky(mut m: Matrix) -> Option<Matrix> {
    for j in 0..m.ncols() {
        for k in 0..j {
            let (done, column) = m.two_columns(k, j);
            let factor = done[j];
            take(&mut column[j..], factor, &done[j..]);
        }
        let column = m.column_mut(j);
        let diagonal = column[j].sqrt();
        // NaN, the root of what is negative, is not above 0 either.
        if diagonal > 0.0 && diagonal.is_finite() {
            column[..j].fill(0.0);
            column[j] = diagonal;
            column[j + 1..].iter_mut().for_each(|l| *l /= diagonal);
        } else {
            return None;
        }
    }
    Some(m)
}

/// Replaces a column by what times `LLᵀ` is that.
#[inline(always)]
pub(crate) fn solve_cholesky(l: &Matrix, column: &mut [f64]) {
    let count = l.ncols();
    for j in 0..count {
        let l = l.column(j);
        column[j] /= l[j];
        let known = column[j];
        take(&mut column[j + 1..], known, &l[j + 1..]);
    }
    for j in (0..count).rev() {
        let l = l.column(j);
        column[j] = (column[j] - dot(&l[j + 1..], &column[j + 1..])) / l[j];
    }
}

/// The singular values of `m`, in no order: pairs of columns are turned until all stand at right angles, then they are the
/// columns' lengths.
fn singular_values(mut m: Matrix) -> Vec<f64> {
    // Convergence is quadratic at last; ten sweeps do for 32 columns.
    for _ in 0..60 {
        let mut is_turned = false;
        for q in 1..m.ncols() {
            for p in 0..q {
                is_turned |= straighten(&mut m, p, q);
            }
        }
        if !is_turned {
            break;
        }
    }
    m.columns()
        .map(|column| dot(column, column).sqrt())
        .collect()
}

/// Turns columns `p < q` to a right angle; answers whether they were not at one yet.
fn straighten(m: &mut Matrix, p: usize, q: usize) -> bool {
    let (a, b) = m.two_columns(p, q);
    let (aa, bb, ab) = (dot(a, a), dot(b, b), dot(a, b));
    let is_skew = ab.abs() > f64::EPSILON * (aa * bb).sqrt();
    if is_skew {
        let slope = (bb - aa) / (2.0 * ab);
        let sign = if slope < 0.0 { -1.0 } else { 1.0 };
        let tan = sign / (slope.abs() + (1.0 + slope * slope).sqrt());
        let cos = 1.0 / (1.0 + tan * tan).sqrt();
        let sin = cos * tan;
        for (a, b) in a.iter_mut().zip(b) {
            (*a, *b) = (cos * *a - sin * *b, sin * *a + cos * *b);
        }
    }
    is_skew
}

impl Matrix {
    /// Columns `i < j`.
    fn two_columns(&mut self, i: usize, j: usize) -> (&mut [f64], &mut [f64]) {
        let rows = self.nrows();
        let (before, after) = self.split_at_column(j);
        (&mut before[i * rows..][..rows], &mut after[..rows])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;
    use proptest::prelude::*;

    /// Numbers between −1 and 1 whose columns grow apart by up to `10⁻⁶`.
    fn matrices() -> impl Strategy<Value = Matrix> {
        (1usize..=32, 0usize..=60).prop_flat_map(|(columns, more)| {
            let rows = columns + more;
            let numbers = prop::collection::vec(-1.0f64..1.0, rows * columns);
            let sizes = prop::collection::vec(0i32..=6, columns);
            (numbers, sizes).prop_map(move |(numbers, sizes)| {
                Matrix::from_fn(rows, columns, |i, j| {
                    numbers[j * rows + i] * 10f64.powi(-sizes[j])
                })
            })
        })
    }

    fn nalgebras(m: &Matrix) -> DMatrix<f64> {
        DMatrix::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)])
    }

    proptest! {
        #[test]
        fn q_r_is_the_matrix(a in matrices()) {
            let factors = Qr::new(&a);
            let (q, product) = (factors.thin_q(), factors.thin_q().times(factors.r()));
            for j in 0..a.ncols() {
                let size = dot(a.column(j), a.column(j)).sqrt();
                for i in 0..a.nrows() {
                    prop_assert!((product[(i, j)] - a[(i, j)]).abs() <= 1e-13 * size);
                }
                for k in 0..=j {
                    let expected = if j == k { 1.0 } else { 0.0 };
                    prop_assert!((dot(q.column(j), q.column(k)) - expected).abs() < 1e-13);
                }
                let mut column = a.column(j).to_vec();
                factors.apply_transposed(&mut column);
                for (i, number) in column.iter().enumerate() {
                    let expected = if i < a.ncols() { factors.r()[(i, j)] } else { 0.0 };
                    prop_assert!((number - expected).abs() <= 1e-13 * size);
                }
            }
        }

        #[test]
        fn singular_values_and_least_squares_are_nalgebras(a in matrices()) {
            let factors = Qr::new(&a);
            let values = nalgebras(&a).singular_values();
            let expected = values[0] / values[a.ncols() - 1];
            prop_assume!(expected < 1e10);
            prop_assert!((factors.condition() / expected - 1.0).abs() < 1e-15 * expected + 1e-12);
            let right: Vec<f64> = (0..a.nrows()).map(|i| (i * i % 7) as f64 - 3.0).collect();
            let mut found = right.clone();
            factors.apply_transposed(&mut found);
            solve_upper(factors.r(), &mut found[..a.ncols()]);
            let mut column = DMatrix::from_fn(a.nrows(), 1, |i, _| right[i]);
            let oracle = nalgebras(&a).qr();
            oracle.q_tr_mul(&mut column);
            let solved = oracle.r().solve_upper_triangular(&column.rows(0, a.ncols())).unwrap();
            let size = (0..a.ncols()).map(|j| solved[(j, 0)].abs()).fold(0.0, f64::max);
            let inverse = factors.pseudoinverse();
            for j in 0..a.ncols() {
                // The residual is as large as the right-hand side: the condition number counts twice.
                let off = 1e-14 * expected * expected * size.max(1.0) + 1e-12 * size;
                prop_assert!((found[j] - solved[(j, 0)]).abs() < off);
                let product: f64 = (0..a.nrows()).map(|i| inverse[(j, i)] * right[i]).sum();
                prop_assert!((product - solved[(j, 0)]).abs() < off);
            }
        }

        #[test]
        fn l_l_is_the_square(a in matrices()) {
            let mut square = a.transposed().times(&a);
            for i in 0..a.ncols() {
                square[(i, i)] += 1e-3;
            }
            let l = cholesky(square.clone()).expect("positive definite");
            let product = l.times(&l.transposed());
            let right: Vec<f64> = (0..a.ncols()).map(|i| i as f64 - 3.0).collect();
            let mut solved = right.clone();
            solve_cholesky(&l, &mut solved);
            for i in 0..a.ncols() {
                for j in 0..a.ncols() {
                    prop_assert!((product[(i, j)] - square[(i, j)]).abs() < 1e-12);
                }
                let back: f64 = (0..a.ncols()).map(|j| square[(i, j)] * solved[j]).sum();
                prop_assert!((back - right[i]).abs() < 1e-7);
            }
        }
    }

    #[test]
    fn what_is_no_square_of_anything_is_refused() {
        let indefinite = Matrix::from_fn(2, 2, |i, j| if i == j { 1.0 } else { 2.0 });
        assert_eq!(cholesky(indefinite), None);
        assert_eq!(cholesky(Matrix::zeros(3, 3)), None);
        assert_eq!(cholesky(Matrix::from_fn(1, 1, |_, _| f64::NAN)), None);
    }

    #[test]
    fn columns_that_depend_on_each_other_have_no_condition_number() {
        let alike = Matrix::from_fn(9, 2, |i, _| i as f64);
        assert!(Qr::new(&alike).condition() > 1e15);
        assert_eq!(Qr::new(&Matrix::zeros(9, 3)).condition(), f64::INFINITY);
        let none = Matrix::from_fn(9, 2, |_, _| f64::NAN);
        assert_eq!(Qr::new(&none).condition(), f64::INFINITY);
    }
}
