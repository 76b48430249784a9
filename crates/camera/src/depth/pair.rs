//! A depth camera and the color camera next to it.

use crate::camera::Camera;
use crate::lens::Lens;
use crate::pose::Pose;
use thiserror::Error;

/// Why numbers do not describe a pair of cameras.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum DepthCameraError {
    /// An invalid noise.
    #[error("invalid depth noise of {0} at 1 m: a standard deviation in mm, 0 or more")]
    Noise(f64),
    /// An invalid range.
    #[error("invalid range of depths from {} to {} mm: the first must be positive, and the less", .0[0], .0[1])]
    Range([f64; 2]),
}

/// A depth camera and the color camera next to it, their relative pose, and the depth camera's
/// noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthCamera {
    pub(super) color: Camera,
    pub(super) depth: Camera,
    /// Pose from the color camera's frame to the depth camera's.
    pose: Pose,
    pub(super) translation: [f64; 3],
    /// Standard deviation of a depth z, divided by z², 1/mm.
    pub(super) noise: f64,
    pub(super) range_mm: [f64; 2],
    /// True if the depth camera's lens does not distort.
    is_straight: bool,
}

impl DepthCamera {
    /// Creates a pair of cameras. `pose` maps points of the depth camera's frame to the color
    /// camera's, as in librealsense and ROS. The standard deviation of a depth is `noise_mm` at one
    /// meter and grows with the square of the depth. For a stereo camera whose disparities are off
    /// by s pixels, it is z² s / (f B). Depths are looked for within `range_mm`.
    ///
    /// # Errors
    /// A value is invalid.
    pub fn new(
        color: Camera,
        depth: Camera,
        pose: Pose,
        noise_mm: f64,
        range_mm: [f64; 2],
    ) -> Result<Self, DepthCameraError> {
        if !(0.0..1e4).contains(&noise_mm) {
            return Err(DepthCameraError::Noise(noise_mm));
        }
        if !(range_mm[0] >= 1.0 && range_mm[0] < range_mm[1] && range_mm[1] < 1e6) {
            return Err(DepthCameraError::Range(range_mm));
        }
        let pose = pose.inverse();
        Ok(Self {
            color,
            depth,
            pose,
            translation: pose.translation_mm(),
            noise: noise_mm / 1e6,
            range_mm,
            is_straight: *depth.lens() == Lens::IDEAL,
        })
    }

    /// Width and height of the color camera's images, if its calibration contains them.
    pub fn color_size(&self) -> Option<[u32; 2]> {
        self.color.size()
    }

    /// The color camera's focal length, px: the geometric mean of its two.
    pub fn color_focal_px(&self) -> f64 {
        let [x, y] = self.color.focal_px();
        (x * y).sqrt()
    }

    /// Rotates a direction from the color camera's frame to the depth camera's.
    pub(super) fn turned(&self, way: [f64; 3]) -> [f64; 3] {
        self.pose.way(way)
    }

    /// Projects a point of the depth camera's frame to its image. `None` if the point is behind the
    /// camera or beyond the lens model.
    pub(super) fn pixel(&self, point: [f64; 3]) -> Option<[f64; 2]> {
        if point[2] < 1.0 {
            return None;
        }
        let (focal, center) = (self.depth.focal_px(), self.depth.center_px());
        let [x, y, ahead] = point;
        let per_depth = 1.0 / ahead;
        let ideal = [
            focal[0] * x * per_depth + center[0],
            focal[1] * y * per_depth + center[1],
        ];
        match self.is_straight {
            true => Some(ideal),
            false => Some(self.depth.distort(ideal)?.point),
        }
    }

    /// Distorts ideal pixels of the depth camera. Beyond the lens model, the result is far outside
    /// of the image.
    #[inline]
    pub(super) fn distort(&self, columns: &mut [f32], rows: &mut [f32]) {
        if self.is_straight {
            return;
        }
        for (column, row) in columns.iter_mut().zip(rows) {
            let place = self.depth.distort([*column, *row].map(f64::from));
            [*column, *row] = place.map_or([-1e6; 2], |place| place.point.map(|c| c as f32));
        }
    }

    /// Standard deviation of a depth, mm.
    pub(super) fn sigma_mm(&self, depth: f64) -> f64 {
        self.noise * depth * depth
    }
}
