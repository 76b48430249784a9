//! A covariance as RViz draws it: axes and orientation of an ellipse or an ellipsoid.

use super::{Scale, turn_about_z};

/// Half axes of the region that contains nine of ten points, in standard deviations, for two and
/// three dimensions: √(−2 ln 0.1), and the same quantile of χ with three degrees of freedom.
const DEVIATIONS: [f64; 2] = [2.145_966, 2.500_278];
/// Maximum number of rotations. Each rotation removes the largest off-diagonal entry, and a matrix
/// of three rows is diagonal long before this limit.
const MOST_TURNS: usize = 24;

/// The ellipsoid that contains nine of ten points. The third axis of a flat one is 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ellipsoid {
    /// Full lengths.
    pub(crate) axes: [f64; 3],
    /// Orientation as a quaternion x, y, z, w.
    pub(crate) turn: [f64; 4],
}

impl Ellipsoid {
    /// Ellipse of a covariance `[xx, xy, yy]`; the longer axis is the first.
    pub(crate) fn flat([xx, xy, yy]: [f64; 3]) -> Self {
        let middle = 0.5 * (xx + yy);
        let half = (0.5 * (xx - yy)).hypot(xy);
        let [long, short] = [middle + half, middle - half].map(|v| axis(v, DEVIATIONS[0]));
        Self {
            axes: [long, short, 0.0],
            turn: turn_about_z(0.5 * (2.0 * xy).atan2(xx - yy)),
        }
    }

    /// Ellipsoid of a covariance `[xx, xy, xz, yy, yz, zz]`, by Jacobi rotations that are combined
    /// into a quaternion.
    pub(crate) fn in_space([xx, xy, xz, yy, yz, zz]: [f64; 6]) -> Self {
        let mut a = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
        let mut turn = [0.0, 0.0, 0.0, 1.0];
        for _ in 0..MOST_TURNS {
            let largest = (0..3).max_by(|&k, &l| beside(&a, k).total_cmp(&beside(&a, l)));
            let axis = largest.unwrap_or(0);
            let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
            if a[i][j].abs() <= f64::EPSILON * (a[i][i].abs() + a[j][j].abs()) {
                break;
            }
            let angle = 0.5 * (2.0 * a[i][j]).atan2(a[i][i] - a[j][j]);
            let (sine, cosine) = angle.sin_cos();
            let rotate = |p: &mut f64, q: &mut f64| {
                (*p, *q) = (cosine * *p + sine * *q, cosine * *q - sine * *p);
            };
            for row in &mut a {
                let [p, q] = row.get_disjoint_mut([i, j]).expect("two of three");
                rotate(p, q);
            }
            let [p, q] = a.get_disjoint_mut([i, j]).expect("two of three");
            p.iter_mut().zip(q).for_each(|(p, q)| rotate(p, q));
            let (sine, cosine) = (0.5 * angle).sin_cos();
            let mut by = [0.0, 0.0, 0.0, cosine];
            by[axis] = sine;
            turn = product(turn, by);
        }
        Self {
            axes: [0, 1, 2].map(|k| axis(a[k][k], DEVIATIONS[1])),
            turn,
        }
    }

    pub(crate) fn scaled(self, scale: Scale) -> Self {
        Self {
            axes: self.axes.map(|axis| scale.length(axis)),
            ..self
        }
    }
}

/// Full length of an axis.
fn axis(variance: f64, deviations: f64) -> f64 {
    2.0 * deviations * variance.max(0.0).sqrt()
}

/// The off-diagonal entry that a rotation about this axis changes.
fn beside(a: &[[f64; 3]; 3], axis: usize) -> f64 {
    a[(axis + 1) % 3][(axis + 2) % 3].abs()
}

/// Product of two rotations; the second is about the axes rotated by the first.
fn product([ax, ay, az, aw]: [f64; 4], [bx, by, bz, bw]: [f64; 4]) -> [f64; 4] {
    [
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_ellipse_has_the_axes_of_its_covariance() {
        // Deviations 3 along (1, 1)/√2 and 1 across.
        let found = Ellipsoid::flat([5.0, 4.0, 5.0]);
        let [long, short, none] = found.axes.map(|axis| axis / (2.0 * DEVIATIONS[0]));
        assert!((long - 3.0).abs() < 1e-12 && (short - 1.0).abs() < 1e-12 && none == 0.0);
        assert_eq!(found.turn, turn_about_z(std::f64::consts::FRAC_PI_4));
    }

    /// Rotates a vector by a quaternion.
    fn turned(by: [f64; 4], [x, y, z]: [f64; 3]) -> [f64; 3] {
        let [a, b, c, w] = by;
        let [i, j, k, _] = product(product(by, [x, y, z, 0.0]), [-a, -b, -c, w]);
        [i, j, k]
    }

    #[test]
    fn an_ellipsoid_put_together_again_is_its_covariance() {
        let drawn = [
            [4.0, 0.0, 0.0, 9.0, 0.0, 1.0],
            [5.0, 4.0, 0.0, 5.0, 0.0, 2.0],
            [2.0, -1.0, 0.5, 3.0, 0.75, 40.0],
            [1.0, 1e-9, 0.0, 1.0, 0.0, 1.0],
            [1e-6, 2e-7, -3e-7, 4e-6, 1e-7, 9e-4],
            [0.0; 6],
        ];
        for covariance in drawn {
            let found = Ellipsoid::in_space(covariance);
            let variances = found.axes.map(|axis| (0.5 * axis / DEVIATIONS[1]).powi(2));
            let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
                .map(|axis| turned(found.turn, axis));
            let of = |i: usize, j: usize| -> f64 {
                (0..3).map(|k| variances[k] * axes[k][i] * axes[k][j]).sum()
            };
            let again = [of(0, 0), of(0, 1), of(0, 2), of(1, 1), of(1, 2), of(2, 2)];
            let most = covariance
                .iter()
                .fold(0.0, |most: f64, c| most.max(c.abs()));
            for (a, b) in again.iter().zip(covariance) {
                assert!((a - b).abs() <= 1e-12 * most, "{again:?} {covariance:?}");
            }
        }
    }
}
