//! A pair of color cameras.

use crate::camera::Camera;
use crate::pose::Pose;
use crate::space::dot;
use thiserror::Error;

/// Minimum distance between the cameras, mm. Closer cameras see the same image.
const LEAST_BASELINE_MM: f64 = 1.0;

/// Why numbers do not describe a pair of cameras.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum ViewPairError {
    /// The cameras are at the same place.
    #[error(
        "the two cameras stand {0} mm apart, and it takes 1 mm or more: translation_mm says where the second one stands"
    )]
    Baseline(f64),
    /// An invalid range.
    #[error("invalid range of depths from {} to {} mm: the first must be positive, and the less", .0[0], .0[1])]
    Range([f64; 2]),
}

/// Two color cameras, and their relative pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ViewPair {
    pub(super) first: Camera,
    pub(super) second: Camera,
    /// Pose from the first camera's frame to the second's.
    pose: Pose,
    /// Distance between the cameras, mm.
    pub(super) baseline_mm: f64,
    pub(super) range_mm: [f64; 2],
}

/// Epipolar geometry of a point in the first view. At depth `1 / w` along its ray, it is seen in
/// the second view at `way + w shift`, divided by the third coordinate of this vector.
#[derive(Debug, Clone, Copy)]
pub(super) struct Epipolar {
    /// The ray in the second camera's frame.
    pub way: [f64; 3],
    /// The first camera's position in that frame.
    pub shift: [f64; 3],
}

/// A place in the second view, and its derivative by the inverse depth.
#[derive(Debug, Clone, Copy)]
pub(super) struct Projection {
    pub at: [f64; 2],
    pub by_inverse: [f64; 2],
    /// Distance ahead of the second camera per millimeter ahead of the first.
    pub ahead: f64,
}

impl ViewPair {
    /// Creates a pair of cameras. `pose` maps points of the second camera's frame to the first's.
    /// Ropes are looked for within `range_mm` of the first camera.
    ///
    /// # Errors
    /// A value is invalid.
    pub fn new(
        first: Camera,
        second: Camera,
        pose: Pose,
        range_mm: [f64; 2],
    ) -> Result<Self, ViewPairError> {
        if !(range_mm[0] >= 1.0 && range_mm[0] < range_mm[1] && range_mm[1] < 1e6) {
            return Err(ViewPairError::Range(range_mm));
        }
        let pose = pose.inverse();
        let shift = pose.translation_mm();
        let baseline_mm = dot(shift, shift).sqrt();
        if baseline_mm < LEAST_BASELINE_MM {
            return Err(ViewPairError::Baseline(baseline_mm));
        }
        Ok(Self {
            first,
            second,
            pose,
            baseline_mm,
            range_mm,
        })
    }

    /// Width and height of each camera's images, if its calibration contains them.
    pub fn sizes(&self) -> [Option<[u32; 2]>; 2] {
        [self.first.size(), self.second.size()]
    }

    /// The first camera's focal length, px: the geometric mean of its two.
    pub fn focal_px(&self) -> f64 {
        mean_focal(&self.first)
    }

    /// The second camera's focal length, px: the geometric mean of its two.
    pub(super) fn second_focal_px(&self) -> f64 {
        mean_focal(&self.second)
    }

    /// Rotates a direction from the first camera's frame to the second's.
    pub(super) fn turned(&self, way: [f64; 3]) -> [f64; 3] {
        self.pose.way(way)
    }

    pub(super) fn epipolar(&self, ray: [f64; 3]) -> Epipolar {
        Epipolar {
            way: self.pose.way(ray),
            shift: self.pose.translation_mm(),
        }
    }
}

impl Epipolar {
    /// Returns where the point at this inverse depth is seen, in tangents; `None` behind the second
    /// camera.
    pub(super) fn at(&self, inverse: f64) -> Option<Projection> {
        let [x, y, ahead] = [0, 1, 2].map(|k| self.way[k] + inverse * self.shift[k]);
        (ahead > 1e-3).then(|| {
            let at = [x / ahead, y / ahead];
            Projection {
                at,
                by_inverse: [0, 1].map(|k| (self.shift[k] - at[k] * self.shift[2]) / ahead),
                ahead,
            }
        })
    }

    /// The line on which the point is seen at any depth, as `a x + b y + c = 0` with `a² + b² = 1`.
    /// `None` if it is a single point.
    pub(super) fn line(&self) -> Option<[f64; 3]> {
        let line = crate::space::cross(self.shift, self.way);
        let size = crate::space::length(line[0], line[1]);
        (size > 1e-9).then(|| line.map(|c| c / size))
    }

    /// Inverse depth of the point that is seen at a place on that line, or nearest to it.
    pub(super) fn inverse(&self, at: [f64; 2]) -> f64 {
        let to = [0, 1].map(|k| self.shift[k] - at[k] * self.shift[2]);
        let from = [0, 1].map(|k| at[k] * self.way[2] - self.way[k]);
        (from[0] * to[0] + from[1] * to[1]) / (to[0] * to[0] + to[1] * to[1])
    }
}

fn mean_focal(camera: &Camera) -> f64 {
    let [x, y] = camera.focal_px();
    (x * y).sqrt()
}
