//! Dense matrices computed before any frame: faer's, with the few products that must be the same on
//! every machine.

use faer::{Mat, MatRef};

/// Product of two matrices. Unlike in faer's own product, sums are in the order of the inner index,
/// so they do not depend on the machine's vectors.
pub(crate) fn product(left: MatRef<'_, f64>, right: MatRef<'_, f64>) -> Mat<f64> {
    let mut product = Mat::zeros(left.nrows(), right.ncols());
    for j in 0..right.ncols() {
        let sums = product.col_as_slice_mut(j);
        for k in 0..left.ncols() {
            let factor = right[(k, j)];
            for (i, sum) in sums.iter_mut().enumerate() {
                *sum += factor * left[(i, k)];
            }
        }
    }
    product
}

/// The numbers of a matrix, row by row.
pub(crate) fn row_by_row(matrix: MatRef<'_, f64>) -> Vec<f64> {
    let places = (0..matrix.nrows()).flat_map(|i| (0..matrix.ncols()).map(move |j| (i, j)));
    places.map(|at| matrix[at]).collect()
}
