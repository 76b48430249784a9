//! Maps a pixel of a frame to its place on the plane, and back.

use crate::camera::Camera;
use crate::jacobian::{self, Place, determinant};
use crate::plane::Plane;
use crate::projective::{self, Matrix};
use thiserror::Error;

/// Why a calibration does not fit the frames.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum SizeError {
    /// The aspect ratios differ.
    #[error(
        "it was measured in images of {}×{} pixels and the frames have {}×{}: the sides' ratio differs, so that they show \
         another part of the scene. Calibrate at the frames' size, or run the camera at the calibration's", .own[0], .own[1],
        .frames[0], .frames[1]
    )]
    Aspect {
        /// Width and height of the images used for calibration.
        own: [u32; 2],
        /// Width and height of the frames.
        frames: [u32; 2],
    },
    /// The frames are larger than the calibration's region.
    #[error(
        "it is for a region (roi) of {}×{} pixels of the sensor, and the frames of {}×{} pixels are larger: remove roi from the \
         calibration file if the frames show the whole sensor", .region[0], .region[1], .frames[0], .frames[1]
    )]
    Region {
        /// Width and height of the region.
        region: [u32; 2],
        /// Width and height of the frames.
        frames: [u32; 2],
    },
    /// The principal point is outside of the frames.
    #[error(
        "its principal point ({:.1}, {:.1}) lies outside of the frames of {}×{} pixels: it is for larger images. Say which by \
         image_width and image_height in the calibration file", .center_px[0], .center_px[1], .frames[0], .frames[1]
    )]
    Center {
        /// The principal point, px.
        center_px: [f64; 2],
        /// Width and height of the frames.
        frames: [u32; 2],
    },
    /// The plane was measured in pixels of another calibration.
    #[error(
        "the plane was measured in pixels that another lens calibration had been applied to: measure it again, by `lariat \
         calibrate plane` with this --calibration"
    )]
    OtherCamera,
    /// The plane was measured in undistorted pixels, and no camera is given.
    #[error(
        "the plane was measured in pixels without distortion: name the lens calibration it was made with too \
         (--calibration FILE)"
    )]
    NoCamera,
    /// Numbers too large or too small to invert.
    #[error("the plane's homography cannot be inverted at the frames' size: measure it again")]
    Singular,
}

/// Why a pixel cannot be mapped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum Outside {
    /// The lens model folds over or ends there.
    #[error(
        "a point lies where the calibration's lens model is not one-to-one any more (it folds over towards the corners): \
         calibrate with pictures that reach there, or look at the middle only (--roi)"
    )]
    Lens,
    /// The pixel shows no point of the plane.
    #[error(
        "a point lies at the horizon of the plane or beyond it, where no table is: look whether the plane's points were \
         taken rightly, or at the table only (--roi)"
    )]
    Horizon,
}

/// Maps pixels of frames of one size to the plane or, without a plane, to ideal pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mapping {
    camera: Option<Camera>,
    /// Matrices to the plane and back.
    plane: Option<[Matrix; 2]>,
    size: [u32; 2],
}

impl Mapping {
    /// Creates a mapping for frames of this width and height.
    ///
    /// # Errors
    /// The camera or the plane is for other images.
    pub fn new(
        camera: Option<&Camera>,
        plane: Option<&Plane>,
        frames: [u32; 2],
    ) -> Result<Self, SizeError> {
        if plane.is_some_and(|plane| !plane.is_of(camera)) {
            return Err(match camera {
                None => SizeError::NoCamera,
                Some(_) => SizeError::OtherCamera,
            });
        }
        Ok(Self {
            camera: camera.map(|camera| camera.scaled_to(frames)).transpose()?,
            plane: plane.map(|plane| plane.maps(frames)).transpose()?,
            size: frames,
        })
    }

    /// Width and height of the frames.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Maps a pixel to its place, with the derivative by the pixel.
    ///
    /// # Errors
    /// The pixel cannot be mapped.
    pub fn place(&self, pixel: [f64; 2]) -> Result<Place, Outside> {
        let ideal = match &self.camera {
            None => Place::itself(pixel),
            Some(camera) => camera.undistort(pixel).ok_or(Outside::Lens)?,
        };
        let Some([to_mm, _]) = &self.plane else {
            return Ok(ideal);
        };
        let place = projective::map(to_mm, ideal.point).ok_or(Outside::Horizon)?;
        Ok(Place {
            point: place.point,
            jacobian: jacobian::product(&place.jacobian, &ideal.jacobian),
        })
    }

    /// Maps a place back to its pixel; `None` if it is not visible.
    pub fn pixel(&self, point: [f64; 2]) -> Option<[f64; 2]> {
        let ideal = match &self.plane {
            None => point,
            Some([_, back]) => projective::map(back, point)?.point,
        };
        match &self.camera {
            None => Some(ideal),
            Some(camera) => camera.distort(ideal).map(|place| place.point),
        }
    }

    /// Size of a pixel at its place (mm, or ideal pixels): the square root of the area that it
    /// covers.
    ///
    /// # Errors
    /// The pixel cannot be mapped.
    pub fn unit_per_px(&self, pixel: [f64; 2]) -> Result<f64, Outside> {
        let place = self.place(pixel)?;
        Ok(determinant(&place.jacobian).abs().sqrt())
    }
}
