//! Kannala and Brandt's fisheye (*A generic camera model*, PAMI 2006) as in OpenCV's `fisheye` and
//! ROS's `equidistant`: a ray at the angle θ to the axis is seen at a distance of θ(1 + k₁θ² + k₂θ⁴
//! + k₃θ⁶ + k₄θ⁸) from the center.

use crate::jacobian::{IDENTITY, Place};

/// Distance from the center below which the map is exactly the identity in floating point.
const MIDDLE: f64 = 1e-9;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Fisheye(pub(crate) [f64; 4]);

impl Fisheye {
    /// Distance from the center at which a ray at this angle is seen, and its derivative by the
    /// angle.
    fn radius(&self, theta: f64) -> [f64; 2] {
        let [k1, k2, k3, k4] = self.0;
        let t = theta * theta;
        [
            theta * (1.0 + t * (k1 + t * (k2 + t * (k3 + t * k4)))),
            1.0 + t * (3.0 * k1 + t * (5.0 * k2 + t * (7.0 * k3 + t * 9.0 * k4))),
        ]
    }

    /// Maps an ideal point to the place where it is seen.
    pub(crate) fn bend(&self, [x, y]: [f64; 2]) -> Place {
        let r = libm::hypot(x, y);
        if r < MIDDLE {
            return Place::itself([x, y]);
        }
        let theta = libm::atan(r);
        let [radius, slope] = self.radius(theta);
        let across = radius / r;
        let along = slope / (1.0 + r * r);
        let n = [x / r, y / r];
        Place {
            point: [x * across, y * across],
            jacobian: [0, 1].map(|i| {
                [0, 1].map(|j| across * (IDENTITY[i][j] - n[i] * n[j]) + along * n[i] * n[j])
            }),
        }
    }

    /// Maps a place back to the ideal point that is seen there. `None` if that point is farther
    /// than `most` from the center, where the model may not be one-to-one.
    pub(crate) fn straighten(&self, [x, y]: [f64; 2], most: f64) -> Option<[f64; 2]> {
        let seen = libm::hypot(x, y);
        if seen < MIDDLE {
            return Some([x, y]);
        }
        let (mut low, mut high) = (0.0, libm::atan(most));
        let inside = seen <= self.radius(high)[0];
        inside.then_some(())?;
        // Newton's method, kept within the bounds by bisection. The radius increases with the angle
        // throughout.
        let mut theta = seen.min(high);
        for _ in 0..64 {
            let [radius, slope] = self.radius(theta);
            if radius < seen {
                low = theta;
            } else {
                high = theta;
            }
            let step = theta - (radius - seen) / slope;
            let next = if step > low && step < high {
                step
            } else {
                0.5 * (low + high)
            };
            let moved = (next - theta).abs();
            theta = next;
            if moved <= 4.0 * f64::EPSILON * theta {
                break;
            }
        }
        let stretch = libm::tan(theta) / seen;
        Some([x * stretch, y * stretch])
    }
}
