//! A small dense matrix, column by column. Its sums run in the order of their indices, so that they are the same on every
//! machine; there is no faster way for sizes like these that matters, since none of it is done for each frame.

use std::ops::{Index, IndexMut};

/// A matrix of `rows` × `columns` numbers, a column after the other.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Matrix {
    rows: usize,
    columns: usize,
    numbers: Vec<f64>,
}

impl Matrix {
    pub(crate) fn from_fn(
        rows: usize,
        columns: usize,
        mut number: impl FnMut(usize, usize) -> f64,
    ) -> Self {
        let mut numbers = Vec::with_capacity(rows * columns);
        for j in 0..columns {
            numbers.extend((0..rows).map(|i| number(i, j)));
        }
        Self {
            rows,
            columns,
            numbers,
        }
    }

    pub(crate) fn zeros(rows: usize, columns: usize) -> Self {
        Self::from_fn(rows, columns, |_, _| 0.0)
    }

    /// Ones on the diagonal, zeros elsewhere.
    pub(crate) fn identity(rows: usize, columns: usize) -> Self {
        Self::from_fn(rows, columns, |i, j| if i == j { 1.0 } else { 0.0 })
    }

    pub(crate) fn nrows(&self) -> usize {
        self.rows
    }

    pub(crate) fn ncols(&self) -> usize {
        self.columns
    }

    pub(crate) fn column(&self, j: usize) -> &[f64] {
        &self.numbers[j * self.rows..][..self.rows]
    }

    pub(crate) fn column_mut(&mut self, j: usize) -> &mut [f64] {
        &mut self.numbers[j * self.rows..][..self.rows]
    }

    /// Makes every number this one.
    pub(crate) fn fill(&mut self, number: f64) {
        self.numbers.fill(number);
    }

    /// The columns before `j`, one after the other, and those from it on.
    pub(crate) fn split_at_column(&mut self, j: usize) -> (&mut [f64], &mut [f64]) {
        self.numbers.split_at_mut(j * self.rows)
    }

    /// The columns, one after the other.
    pub(crate) fn columns(&self) -> impl ExactSizeIterator<Item = &[f64]> {
        (0..self.columns).map(|j| self.column(j))
    }

    pub(crate) fn transposed(&self) -> Self {
        Self::from_fn(self.columns, self.rows, |i, j| self[(j, i)])
    }

    /// These rows and these columns of it.
    pub(crate) fn part(
        &self,
        rows: std::ops::Range<usize>,
        columns: std::ops::Range<usize>,
    ) -> Self {
        Self::from_fn(rows.len(), columns.len(), |i, j| {
            self[(rows.start + i, columns.start + j)]
        })
    }

    /// The product with another; its numbers are sums in the order of the inner index.
    pub(crate) fn times(&self, other: &Self) -> Self {
        let mut product = Self::zeros(self.rows, other.columns);
        for j in 0..other.columns {
            for (k, &factor) in other.column(j).iter().enumerate() {
                let sums = product.column_mut(j).iter_mut();
                for (sum, number) in sums.zip(self.column(k)) {
                    *sum += factor * number;
                }
            }
        }
        product
    }

    /// Row by row, one after the other.
    pub(crate) fn row_by_row(&self) -> Vec<f64> {
        let places = (0..self.rows).flat_map(|i| (0..self.columns).map(move |j| (i, j)));
        places.map(|at| self[at]).collect()
    }
}

impl Index<(usize, usize)> for Matrix {
    type Output = f64;

    fn index(&self, (i, j): (usize, usize)) -> &f64 {
        &self.numbers[j * self.rows + i]
    }
}

impl IndexMut<(usize, usize)> for Matrix {
    fn index_mut(&mut self, (i, j): (usize, usize)) -> &mut f64 {
        &mut self.numbers[j * self.rows + i]
    }
}
