//! Jacobians of maps of the plane.

/// `J[i][j]`: derivative of the image's coordinate `i` by the point's coordinate `j`.
pub type Jacobian = [[f64; 2]; 2];

/// A mapped point, and the derivative of the map there.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Place {
    /// The mapped point, in the unit of the map's result.
    pub point: [f64; 2],
    /// Its derivative by the original point.
    pub jacobian: Jacobian,
}

impl Place {
    /// The image of a point under the identity.
    pub(crate) const fn itself(point: [f64; 2]) -> Self {
        Self {
            point,
            jacobian: IDENTITY,
        }
    }
}

pub(crate) const IDENTITY: Jacobian = [[1.0, 0.0], [0.0, 1.0]];

pub(crate) fn determinant(j: &Jacobian) -> f64 {
    j[0][0] * j[1][1] - j[0][1] * j[1][0]
}

/// The product `a b`, which applies `b` first, then `a`.
pub(crate) fn product(a: &Jacobian, b: &Jacobian) -> Jacobian {
    [0, 1].map(|i| [0, 1].map(|j| a[i][0] * b[0][j] + a[i][1] * b[1][j]))
}

/// The derivative of the inverse map; not finite if `j` is singular.
pub(crate) fn inverse(j: &Jacobian) -> Jacobian {
    let d = determinant(j);
    [[j[1][1] / d, -j[0][1] / d], [-j[1][0] / d, j[0][0] / d]]
}

/// The product `a x`.
pub(crate) fn times(a: &Jacobian, x: [f64; 2]) -> [f64; 2] {
    a.map(|row| row[0] * x[0] + row[1] * x[1])
}

/// Returns whether the symmetric part is positive definite.
pub(crate) fn is_monotone(j: &Jacobian) -> bool {
    let off = 0.5 * (j[0][1] + j[1][0]);
    // Written with `>`, so that NaN is not monotone either.
    j[0][0] > 0.0 && j[0][0] * j[1][1] - off * off > 0.0
}
