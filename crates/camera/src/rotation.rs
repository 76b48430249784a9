//! Rotations: converts a Rodrigues vector to a matrix, and tests whether a matrix is a rotation.

use crate::projective::Matrix;

/// Maximum deviation of a rotation's columns from orthonormal. Files have six digits or more.
const ORTHONORMAL: f64 = 1e-4;

/// Returns the rotation about `r` by its length in radians (Rodrigues; OpenCV's `rvec`).
pub(crate) fn rodrigues(r: [f64; 3]) -> Matrix {
    let angle = r.iter().map(|c| c * c).sum::<f64>().sqrt();
    // The limits for small angles: sin(a)/a and (1 − cos a)/a².
    let (s, c) = if angle < 1e-8 {
        (1.0, 0.5)
    } else {
        let half = libm::sin(0.5 * angle) / angle;
        (libm::sin(angle) / angle, 2.0 * half * half)
    };
    let [x, y, z] = r;
    let cross = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]];
    let diagonal = libm::cos(angle);
    [0, 1, 2].map(|i| {
        [0, 1, 2].map(|j| {
            let unit = if i == j { diagonal } else { 0.0 };
            unit + s * cross[i][j] + c * r[i] * r[j]
        })
    })
}

/// Returns whether a matrix is a rotation.
pub(crate) fn is_rotation(m: &Matrix) -> bool {
    let dot = |a: usize, b: usize| (0..3).map(|k| m[k][a] * m[k][b]).sum::<f64>();
    let orthonormal = (0..3)
        .all(|a| (a..3).all(|b| (dot(a, b) - f64::from(u8::from(a == b))).abs() < ORTHONORMAL));
    let determinant = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1])
        - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
        + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
    orthonormal && determinant > 0.0
}
