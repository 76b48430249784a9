//! A camera: its matrix, its lens, and the size of the images used for calibration.

use crate::calibration::{self, CalibrationError};
use crate::jacobian::Place;
use crate::lens::Lens;
use crate::mapping::SizeError;
use thiserror::Error;

/// Why numbers do not describe a camera.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum CameraError {
    /// An invalid focal length.
    #[error("invalid focal lengths of {} and {} px: both must be positive", .0[0], .0[1])]
    Focal([f64; 2]),
    /// An invalid principal point.
    #[error("invalid principal point ({}, {}): both coordinates must be finite, in pixels", .0[0], .0[1])]
    Center([f64; 2]),
    /// An invalid image size.
    #[error("invalid image size of {}×{} pixels: both sides must be from 1 to 65535", .0[0], .0[1])]
    Size([u32; 2]),
}

/// The intrinsics of a camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    focal_px: [f64; 2],
    center_px: [f64; 2],
    lens: Lens,
    size: Option<[u32; 2]>,
    /// Width and height of the sensor region that its images show, unbinned; `None` for the whole
    /// sensor.
    region: Option<[u32; 2]>,
}

/// The part of a sensor that images show, and its binning.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Crop {
    /// First column and row of the region on the sensor.
    pub(crate) offset: [u32; 2],
    /// Width and height of the region on the sensor.
    pub(crate) region: [u32; 2],
    /// Sensor columns and rows per column and row of the image.
    pub(crate) binning: [u32; 2],
    /// True if the region is smaller than the sensor.
    pub(crate) is_part: bool,
}

impl Camera {
    /// Creates a camera with these focal lengths and this principal point, px. `size` is the width
    /// and height of the images used for calibration, if known.
    ///
    /// # Errors
    /// A number is invalid.
    pub fn new(
        focal_px: [f64; 2],
        center_px: [f64; 2],
        lens: Lens,
        size: Option<[u32; 2]>,
    ) -> Result<Self, CameraError> {
        if !focal_px.iter().all(|f| (1e-3..1e7).contains(f)) {
            return Err(CameraError::Focal(focal_px));
        }
        if !center_px.iter().all(|c| c.abs() < 1e7) {
            return Err(CameraError::Center(center_px));
        }
        if let Some(size) = size
            && !size.iter().all(|side| (1..=65_535).contains(side))
        {
            return Err(CameraError::Size(size));
        }
        Ok(Self {
            focal_px,
            center_px,
            lens,
            size,
            region: None,
        })
    }

    /// Reads the first camera of a calibration file, as written by OpenCV, ROS, Kalibr and others
    /// ([`CALIBRATIONS`](crate::CALIBRATIONS)).
    ///
    /// # Errors
    /// The file is not a calibration, or a value is invalid. The error names the key and says what
    /// to do.
    pub fn from_yaml(text: &str) -> Result<Self, CalibrationError> {
        Self::first_of(text).map(|(camera, _)| camera)
    }

    /// Same as [`from_yaml`](Self::from_yaml), but also returns a sentence that names the other
    /// cameras if the file has several.
    ///
    /// # Errors
    /// As [`from_yaml`](Self::from_yaml).
    pub fn first_of(text: &str) -> Result<(Self, Option<String>), CalibrationError> {
        calibration::read(text)
    }

    /// Returns this camera for images of a part of its sensor.
    pub(crate) fn cropped(self, crop: Crop) -> Result<Self, CameraError> {
        let binning = crop.binning.map(f64::from);
        let center = [0, 1].map(|i| {
            let on_region = self.center_px[i] - f64::from(crop.offset[i]);
            scaled(on_region, 1.0 / binning[i])
        });
        let focal = [0, 1].map(|i| self.focal_px[i] / binning[i]);
        let size = [0, 1].map(|i| (crop.region[i] / crop.binning[i]).max(1));
        Ok(Self {
            region: Some(crop.region).filter(|_| crop.is_part),
            ..Self::new(focal, center, self.lens, Some(size))?
        })
    }

    /// Focal lengths, px.
    pub fn focal_px(&self) -> [f64; 2] {
        self.focal_px
    }

    /// The principal point, px.
    pub fn center_px(&self) -> [f64; 2] {
        self.center_px
    }

    /// The lens.
    pub fn lens(&self) -> &Lens {
        &self.lens
    }

    /// Width and height of the images used for calibration, if known.
    pub fn size(&self) -> Option<[u32; 2]> {
        self.size
    }

    /// Maps a pixel to its ideal pixel. `None` where the lens model is not one-to-one.
    pub fn undistort(&self, pixel: [f64; 2]) -> Option<Place> {
        self.through(pixel, |seen| self.lens.undistort(seen))
    }

    /// Returns the ray through a pixel in the camera's frame, scaled to a depth of 1. Also returns
    /// the derivative of the ray by the pixel. `None` outside the domain of the lens model.
    #[inline]
    pub(crate) fn ray(&self, pixel: [f64; 2]) -> Option<([f64; 3], [[f64; 2]; 2])> {
        let (f, c) = (self.focal_px, self.center_px);
        if self.lens == Lens::IDEAL {
            let [by_x, by_y] = [1.0 / f[0], 1.0 / f[1]];
            let [x, y] = [(pixel[0] - c[0]) * by_x, (pixel[1] - c[1]) * by_y];
            return Some(([x, y, 1.0], [[by_x, 0.0], [0.0, by_y]]));
        }
        let ideal = self.undistort(pixel)?;
        let [x, y] = [0, 1].map(|k| (ideal.point[k] - c[k]) / f[k]);
        let by_pixel = [0, 1].map(|k| ideal.jacobian[k].map(|d| d / f[k]));
        Some(([x, y, 1.0], by_pixel))
    }

    /// Maps an ideal pixel to the pixel where it is seen. `None` where the lens model is not
    /// one-to-one.
    pub fn distort(&self, ideal: [f64; 2]) -> Option<Place> {
        self.through(ideal, |ray| self.lens.distort(ray))
    }

    /// Applies a map of rays to a pixel.
    fn through(&self, pixel: [f64; 2], map: impl Fn([f64; 2]) -> Option<Place>) -> Option<Place> {
        let (f, c) = (self.focal_px, self.center_px);
        let place = map([0, 1].map(|i| (pixel[i] - c[i]) / f[i]))?;
        Some(Place {
            point: [0, 1].map(|i| f[i] * place.point[i] + c[i]),
            jacobian: [0, 1].map(|i| [0, 1].map(|j| f[i] * place.jacobian[i][j] / f[j])),
        })
    }

    /// Returns this camera for images of another size, binned or scaled as a whole.
    ///
    /// # Errors
    /// The aspect ratio differs, so that the images are an unknown crop. For a camera of unknown
    /// size: the principal point is outside of such images. For a camera of a part of the sensor:
    /// the images are larger than that part.
    pub fn scaled_to(&self, size: [u32; 2]) -> Result<Self, SizeError> {
        if let Some(region) = self.region
            && (size[0] > region[0] || size[1] > region[1])
        {
            return Err(SizeError::Region {
                region,
                frames: size,
            });
        }
        let Some(own) = self.size else {
            let inside = (0..2).all(|i| (0.0..f64::from(size[i])).contains(&self.center_px[i]));
            return if inside {
                Ok(Self {
                    size: Some(size),
                    ..*self
                })
            } else {
                Err(SizeError::Center {
                    center_px: self.center_px,
                    frames: size,
                })
            };
        };
        let scale = scale(own, size)?;
        Ok(Self {
            focal_px: [0, 1].map(|i| self.focal_px[i] * scale[i]),
            center_px: [0, 1].map(|i| scaled(self.center_px[i], scale[i])),
            lens: self.lens,
            size: Some(size),
            region: self.region,
        })
    }
}

/// Scales a pixel coordinate as the whole image is scaled: the edge of the image stays at −½.
pub(crate) fn scaled(c: f64, scale: f64) -> f64 {
    (c + 0.5) * scale - 0.5
}

/// Returns the scale of each side. The aspect ratios must agree except for rounding to whole
/// pixels.
pub(crate) fn scale(own: [u32; 2], frames: [u32; 2]) -> Result<[f64; 2], SizeError> {
    let scale = [0, 1].map(|i| f64::from(frames[i]) / f64::from(own[i]));
    // One side, scaled like the other, is off by less than a pixel.
    let off = (scale[0] - scale[1]).abs() * f64::from(own[0].max(own[1]));
    if off < 1.0 || own == frames {
        Ok(scale)
    } else {
        Err(SizeError::Aspect { own, frames })
    }
}
