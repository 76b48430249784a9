//! Reads the calibration file of a second color camera.

use super::ViewPair;
use crate::calibration::{self, CalibrationError};
use crate::camera::Camera;
use crate::depth::read_range;
use crate::document;
use crate::pose::{LEAST_MM, Pose};

/// A second color camera next to the first.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct SecondCalibration {
    /// The two cameras.
    pub cameras: ViewPair,
}

impl SecondCalibration {
    /// Reads the second camera of a file, which is next to this first one. The file contains its
    /// own calibration under the usual names, `rotation` and `translation_mm` to the first camera's
    /// frame, and `range_mm` ([150, 4000]).
    ///
    /// # Errors
    /// A value is invalid or missing. The error names the key and says what to do.
    pub fn from_yaml(text: &str, first: Camera) -> Result<Self, CalibrationError> {
        let file = document::read(text)?;
        let second = calibration::camera(&file)?;
        let Some(pose) = Pose::read(&file, LEAST_MM)? else {
            return Err(CalibrationError::Missing(
                "pose relative to the first camera",
                "rotation (nine numbers, or a quaternion x, y, z, w) and translation_mm",
            ));
        };
        let range_mm = read_range(&file)?;
        let cameras = ViewPair::new(first, second, pose, range_mm)
            .or_else(|cause| calibration::wrong("second camera", cause.to_string()))?;
        Ok(Self { cameras })
    }
}
