//! Dense matrices as in a textbook: slow, plain, and independent of the library's own.

use lariat_portable::SplitMix64;

use faer::MatRef;
use lariat_fit::bernstein;
use std::ops::{Index, IndexMut};

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Dense {
    pub(crate) rows: usize,
    pub(crate) columns: usize,
    pub(crate) numbers: Vec<f64>,
}

impl Index<(usize, usize)> for Dense {
    type Output = f64;

    fn index(&self, (i, j): (usize, usize)) -> &f64 {
        &self.numbers[i * self.columns + j]
    }
}

impl IndexMut<(usize, usize)> for Dense {
    fn index_mut(&mut self, (i, j): (usize, usize)) -> &mut f64 {
        &mut self.numbers[i * self.columns + j]
    }
}

impl Dense {
    pub(crate) fn from_fn(
        rows: usize,
        columns: usize,
        value: impl Fn(usize, usize) -> f64,
    ) -> Self {
        let numbers = (0..rows * columns)
            .map(|k| value(k / columns, k % columns))
            .collect();
        Self {
            rows,
            columns,
            numbers,
        }
    }

    pub(crate) fn identity(count: usize) -> Self {
        Self::from_fn(count, count, |i, j| if i == j { 1.0 } else { 0.0 })
    }

    /// The matrix `B` of a Bezier curve on the uniform grid.
    pub(crate) fn bezier(order: usize, points: usize) -> Self {
        let mut numbers = vec![0.0; points * (order + 1)];
        for (i, row) in numbers.chunks_exact_mut(order + 1).enumerate() {
            bernstein(order, i as f64 / (points - 1) as f64, row);
        }
        Self {
            rows: points,
            columns: order + 1,
            numbers,
        }
    }

    /// The same matrix for the library.
    pub(crate) fn matrix(&self) -> MatRef<'_, f64> {
        MatRef::from_row_major_slice(&self.numbers, self.rows, self.columns)
    }

    pub(crate) fn transposed(&self) -> Self {
        Self::from_fn(self.columns, self.rows, |i, j| self[(j, i)])
    }

    pub(crate) fn times(&self, other: &Self) -> Self {
        assert_eq!(self.columns, other.rows);
        Self::from_fn(self.rows, other.columns, |i, j| {
            (0..self.columns)
                .map(|k| self[(i, k)] * other[(k, j)])
                .sum()
        })
    }

    pub(crate) fn plus(&self, factor: f64, other: &Self) -> Self {
        Self::from_fn(self.rows, self.columns, |i, j| {
            self[(i, j)] + factor * other[(i, j)]
        })
    }

    pub(crate) fn scaled(&self, factor: f64) -> Self {
        Self::from_fn(self.rows, self.columns, |i, j| factor * self[(i, j)])
    }

    /// The block of `rows` × `columns` whose first entry is at `(i, j)`.
    pub(crate) fn block(&self, (i, j): (usize, usize), rows: usize, columns: usize) -> Self {
        Self::from_fn(rows, columns, |a, b| self[(i + a, j + b)])
    }

    /// A matrix of 2×2 blocks of one size.
    pub(crate) fn of_blocks(blocks: [[&Self; 2]; 2]) -> Self {
        let (m, n) = (blocks[0][0].rows, blocks[0][0].columns);
        Self::from_fn(2 * m, 2 * n, |i, j| blocks[i / m][j / n][(i % m, j % n)])
    }

    /// `L` with `LLᵀ` equal to this matrix; `None` if it is not positive definite.
    pub(crate) fn cholesky(&self) -> Option<Self> {
        let mut l = Self::from_fn(self.rows, self.rows, |_, _| 0.0);
        for i in 0..self.rows {
            for j in 0..=i {
                let known: f64 = (0..j).map(|k| l[(i, k)] * l[(j, k)]).sum();
                let rest = self[(i, j)] - known;
                l[(i, j)] = if i > j {
                    rest / l[(j, j)]
                } else if rest > 0.0 {
                    rest.sqrt()
                } else {
                    return None;
                };
            }
        }
        Some(l)
    }

    /// `L⁻¹` of a lower triangle.
    pub(crate) fn lower_inverse(&self) -> Self {
        let mut inverse = Self::identity(self.rows);
        for column in 0..self.rows {
            for i in 0..self.rows {
                let known: f64 = (0..i).map(|k| self[(i, k)] * inverse[(k, column)]).sum();
                inverse[(i, column)] = (inverse[(i, column)] - known) / self[(i, i)];
            }
        }
        inverse
    }

    /// The inverse of a positive definite matrix.
    pub(crate) fn inverse(&self) -> Self {
        let l = self.cholesky().expect("positive definite").lower_inverse();
        l.transposed().times(&l)
    }

    /// The singular values, the largest first, by one-sided Jacobi rotations (G. Golub, C. Van
    /// Loan, *Matrix Computations*, 8.6.3).
    pub(crate) fn singular_values(&self) -> Vec<f64> {
        let mut m = self.clone();
        let dot = |m: &Self, p: usize, q: usize| -> f64 {
            (0..m.rows).map(|i| m[(i, p)] * m[(i, q)]).sum()
        };
        // Convergence is quadratic: ten sweeps are enough for 32 columns.
        for _ in 0..60 {
            let mut is_done = true;
            for q in 1..m.columns {
                for p in 0..q {
                    let (aa, bb, ab) = (dot(&m, p, p), dot(&m, q, q), dot(&m, p, q));
                    if ab.abs() <= f64::EPSILON * (aa * bb).sqrt() {
                        continue;
                    }
                    is_done = false;
                    let slope = (bb - aa) / (2.0 * ab);
                    let tan = slope.signum() / (slope.abs() + slope.hypot(1.0));
                    let cos = 1.0 / tan.hypot(1.0);
                    for i in 0..m.rows {
                        let (a, b) = (m[(i, p)], m[(i, q)]);
                        m[(i, p)] = cos * (a - tan * b);
                        m[(i, q)] = cos * (tan * a + b);
                    }
                }
            }
            if is_done {
                break;
            }
        }
        let mut values: Vec<f64> = (0..m.columns).map(|j| dot(&m, j, j).sqrt()).collect();
        values.sort_by(|a, b| b.total_cmp(a));
        values
    }

    /// The column of one axis.
    pub(crate) fn column_of<const D: usize>(points: &[[f64; D]], axis: usize) -> Self {
        Self::from_fn(points.len(), 1, |i, _| points[i][axis])
    }

    /// The largest difference of two entries, divided by the largest entry.
    pub(crate) fn difference(&self, other: &Self) -> f64 {
        let size = |m: &Self| m.numbers.iter().fold(0.0f64, |size, n| size.max(n.abs()));
        size(&self.plus(-1.0, other)) / size(self).max(size(other)).max(1e-300)
    }
}

/// `eᵀP⁻¹e`, summed over the axes.
pub(crate) fn normalized_squared<const D: usize>(errors: &[[f64; D]], covariance: &[f64]) -> f64 {
    let count = errors.len();
    let covariance = Dense::from_fn(count, count, |i, j| covariance[i * count + j]);
    let l = covariance.cholesky().expect("a covariance");
    let whitened = l
        .lower_inverse()
        .times(&Dense::from_fn(count, D, |i, j| errors[i][j]));
    whitened.numbers.iter().map(|n| n * n).sum()
}

/// `a − b`, point by point.
pub(crate) fn errors<const D: usize>(a: &[[f64; D]], b: &[[f64; D]]) -> Vec<[f64; D]> {
    let difference = |(a, b): (&[f64; D], &[f64; D])| std::array::from_fn(|k| a[k] - b[k]);
    a.iter().zip(b).map(difference).collect()
}

/// This many independent normal numbers.
pub(crate) fn normals(random: &mut SplitMix64, count: usize) -> Vec<f64> {
    (0..count).map(|_| random.normal()).collect()
}
