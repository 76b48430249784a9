//! A projective map of the plane, `(x, y, 1) → H (x, y, 1)`, for points in front of its horizon.

use crate::jacobian::Place;

/// A 3×3 matrix as three rows.
pub(crate) type Matrix = [[f64; 3]; 3];

/// Maps a point, with the derivative. `None` on or beyond the horizon of `h`, where the third
/// homogeneous coordinate is not positive.
pub(crate) fn map(h: &Matrix, [x, y]: [f64; 2]) -> Option<Place> {
    let [u, v, w] = h.map(|row| row[0] * x + row[1] * y + row[2]);
    let point = [u / w, v / w];
    let inside = w > 0.0 && point.iter().all(|c| c.is_finite());
    inside.then(|| Place {
        point,
        jacobian: [0, 1].map(|i| [0, 1].map(|j| (h[i][j] - point[i] * h[2][j]) / w)),
    })
}

pub(crate) fn product(a: &Matrix, b: &Matrix) -> Matrix {
    a.map(|row| [0, 1, 2].map(|j| (0..3).map(|k| row[k] * b[k][j]).sum()))
}

/// Inverse up to a positive factor: the adjugate, with the determinant's sign. `None` if `m` is
/// singular.
pub(crate) fn inverse(m: &Matrix) -> Option<Matrix> {
    let cofactor = |i: usize, j: usize| {
        let [a, b] = [(i + 1) % 3, (i + 2) % 3];
        let [c, d] = [(j + 1) % 3, (j + 2) % 3];
        m[a][c] * m[b][d] - m[a][d] * m[b][c]
    };
    let determinant: f64 = (0..3).map(|j| m[0][j] * cofactor(0, j)).sum();
    let known = determinant.is_finite() && determinant != 0.0;
    known.then(|| [0, 1, 2].map(|i| [0, 1, 2].map(|j| cofactor(j, i) / determinant)))
}
