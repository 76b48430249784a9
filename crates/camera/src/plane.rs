//! The plane on which the rope lies, as a camera without distortion sees it.

use crate::camera::{self, Camera};
use crate::homography::{self, HomographyError, Pair};
use crate::mapping::SizeError;
use crate::projective::{self, Matrix};
use crate::rotation::{is_rotation, rodrigues};
use thiserror::Error;

/// Why numbers do not describe a plane.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum PlaneError {
    /// A homography without an inverse.
    #[error(
        "the homography maps the picture onto a line or a point: give the 3×3 matrix that takes pixels to millimetres, \
         its rows in their order"
    )]
    Singular,
    /// A number that is not finite.
    #[error("a number of the plane is not finite: write all of them out")]
    NotFinite,
    /// An invalid rotation.
    #[error(
        "invalid rotation: its columns must have length 1 and stand at right angles, right-handed, as those of \
         cv2.Rodrigues do"
    )]
    Rotation,
    /// The camera is in the plane.
    #[error(
        "the camera would lie in the plane and see it edge-on: look at the translation, which is from the camera to the \
         plane's origin in mm"
    )]
    EdgeOn,
}

/// A plane, which maps ideal pixels to positions on it, in mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    to_mm: Matrix,
    size: Option<[u32; 2]>,
    /// Intrinsics (focal lengths, principal point) of the camera whose distortion was removed from
    /// the pixels.
    undistorted_by: Option<[f64; 4]>,
}

impl Plane {
    /// Creates a plane from the matrix that maps ideal pixels (x, y, 1) to millimeters. Its third
    /// coordinate must be positive on the visible side of the plane's horizon.
    ///
    /// # Errors
    /// The matrix is not invertible.
    pub fn from_homography(matrix: [[f64; 3]; 3]) -> Result<Self, PlaneError> {
        if !matrix.as_flattened().iter().all(|x| x.is_finite()) {
            return Err(PlaneError::NotFinite);
        }
        projective::inverse(&matrix).ok_or(PlaneError::Singular)?;
        Ok(Self {
            to_mm: matrix,
            size: None,
            undistorted_by: None,
        })
    }

    /// Creates a plane from points in the image, in ideal pixels, and their positions on the plane.
    ///
    /// # Errors
    /// The points do not determine a plane.
    pub fn from_pairs(pairs: &[Pair]) -> Result<Self, HomographyError> {
        Ok(Self {
            to_mm: homography::of_pairs(pairs)?,
            size: None,
            undistorted_by: None,
        })
    }

    /// Creates a plane from its pose in front of the camera. A point (X, Y) on it is at `R (X, Y,
    /// 0) + t` in the camera's frame (x right, y down, z ahead). `R` is given by the Rodrigues
    /// vector `rotation`, in radians, and `t` is in mm. `cv2.solvePnP` returns both for points of a
    /// board that lies in the plane.
    ///
    /// # Errors
    /// The camera sees the plane edge-on.
    pub fn from_pose(
        rotation: [f64; 3],
        translation_mm: [f64; 3],
        camera: &Camera,
    ) -> Result<Self, PlaneError> {
        if !rotation.iter().all(|x| x.abs() < 1e6) {
            return Err(PlaneError::NotFinite);
        }
        Self::from_rotation(rodrigues(rotation), translation_mm, camera)
    }

    /// Same as [`from_pose`](Self::from_pose), with the rotation as a matrix.
    ///
    /// # Errors
    /// The matrix is not a rotation, or the camera sees the plane edge-on.
    pub fn from_rotation(
        r: [[f64; 3]; 3],
        t: [f64; 3],
        camera: &Camera,
    ) -> Result<Self, PlaneError> {
        if !r.as_flattened().iter().chain(&t).all(|x| x.is_finite()) {
            return Err(PlaneError::NotFinite);
        }
        if !is_rotation(&r) {
            return Err(PlaneError::Rotation);
        }
        let size = t.iter().map(|c| c * c).sum::<f64>().sqrt();
        let distance: f64 = (0..3).map(|i| r[i][2] * t[i]).sum();
        // An angle of less than a hundredth of a degree.
        let seen = distance.abs() > 1.7e-4 * size;
        if !seen {
            return Err(PlaneError::EdgeOn);
        }
        let ([fx, fy], [cx, cy]) = (camera.focal_px(), camera.center_px());
        let rows = [0, 1, 2].map(|i| [r[i][0], r[i][1], t[i]]);
        let to_pixels =
            projective::product(&[[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]], &rows);
        Ok(Self {
            to_mm: projective::inverse(&to_pixels).ok_or(PlaneError::EdgeOn)?,
            size: camera.size(),
            undistorted_by: Some([fx, fy, cx, cy]),
        })
    }

    /// Declares that the plane was measured in images of this size.
    pub fn in_images_of(self, size: [u32; 2]) -> Self {
        Self {
            size: Some(size),
            ..self
        }
    }

    /// Declares that this camera's distortion was removed from the pixels in which the plane was
    /// measured.
    pub fn undistorted_by(self, intrinsics: [f64; 4]) -> Self {
        Self {
            undistorted_by: Some(intrinsics),
            ..self
        }
    }

    /// The matrix from ideal pixels to mm.
    pub fn homography(&self) -> [[f64; 3]; 3] {
        self.to_mm
    }

    /// Returns whether the plane fits this camera: the distortion removed from its pixels was this
    /// camera's, or none was removed.
    pub(crate) fn is_of(&self, camera: Option<&Camera>) -> bool {
        match (self.undistorted_by, camera) {
            (None, _) => true,
            (Some(_), None) => false,
            (Some(own), Some(camera)) => {
                let ([fx, fy], [cx, cy]) = (camera.focal_px(), camera.center_px());
                // Files contain slightly fewer digits than floats have.
                (own.iter().zip([fx, fy, cx, cy]))
                    .all(|(a, b)| (a - b).abs() <= 1e-6 * (1.0 + b.abs()))
            }
        }
    }

    /// The matrix and its inverse, for images of this size.
    pub(crate) fn maps(&self, frames: [u32; 2]) -> Result<[Matrix; 2], SizeError> {
        let mut to_mm = self.to_mm;
        if let Some(own) = self.size {
            let [sx, sy] = camera::scale(own, frames)?.map(|s| 1.0 / s);
            let unscale = [
                [sx, 0.0, camera::scaled(0.0, sx)],
                [0.0, sy, camera::scaled(0.0, sy)],
                [0.0, 0.0, 1.0],
            ];
            to_mm = projective::product(&to_mm, &unscale);
        }
        let back = projective::inverse(&to_mm).ok_or(SizeError::Singular)?;
        Ok([to_mm, back])
    }
}
