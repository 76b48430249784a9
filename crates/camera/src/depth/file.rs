//! Reads the calibration file of a depth camera.

use super::{DepthCamera, DepthKind};
use crate::calibration::{self, CalibrationError};
use crate::camera::Camera;
use crate::document::{self, Node};
use crate::pose::{LEAST_BESIDE_MM, LEAST_MM, Pose};

/// Noise of a stereo camera with a baseline of a few centimeters, and the range of such cameras.
const NOISE_MM: f64 = 4.0;
const RANGE_MM: [f64; 2] = [150.0, 4000.0];

/// A depth camera next to a color camera, and the format of its images.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct DepthCalibration {
    /// The two cameras.
    pub camera: DepthCamera,
    /// Format of a pixel in its images.
    pub kind: DepthKind,
    /// Width and height of its images.
    pub size: [u32; 2],
}

/// Coarsest step of depth images: a centimeter, as some simulators write them.
const COARSEST_MM: f64 = 10.0;
/// Smallest plausible noise at 1 m. Structured light for metrology has about 0.05 mm.
const FINEST_MM: f64 = 0.02;

impl DepthCalibration {
    /// Reads the depth camera of a file, which is next to this color camera. The file contains its
    /// own calibration under the usual names, and these keys:
    ///
    /// - `rotation` and `translation_mm` to the color camera's frame (default: both cameras are at
    ///   one place),
    /// - `depth_unit_mm` (1),
    /// - `noise_mm_at_1m` (4): the standard deviation at 1 m, which grows with the square of the
    ///   distance,
    /// - `range_mm` ([150, 4000]).
    ///
    /// Without a camera matrix, the depth images are aligned to the color images: both have the
    /// same camera.
    ///
    /// # Errors
    /// A value is invalid or missing. The error names the key and says what to do.
    pub fn from_yaml(text: &str, color: Camera) -> Result<Self, CalibrationError> {
        let file = document::read(text)?;
        let own = calibration::camera(&file);
        let depth = match own {
            Err(CalibrationError::Missing(what, _)) if what == calibration::MATRIX => color,
            own => own?,
        };
        let Some(size) = depth.size() else {
            return Err(CalibrationError::Missing(
                "size of the depth images",
                "image_width and image_height",
            ));
        };
        let pose = Pose::read(&file, LEAST_BESIDE_MM)?.unwrap_or(Pose::SAME);
        let number = |name: &str, default: f64| number(&file, name, default);
        let unit_mm = number("depthunitmm", 1.0)?;
        let noise_mm = number("noisemmat1m", NOISE_MM)?;
        let range_mm = read_range(&file)?;
        check_units(unit_mm, noise_mm, range_mm)?;
        let camera = DepthCamera::new(color, depth, pose, noise_mm, range_mm)
            .or_else(|cause| calibration::wrong("depth camera", cause.to_string()))?;
        Ok(Self {
            camera,
            kind: DepthKind::Whole { unit_mm },
            size,
        })
    }
}

/// Checks that the numbers can be in millimeters.
///
/// # Errors
/// A number is more likely in meters, or is a number of units per meter.
fn check_units(unit_mm: f64, noise_mm: f64, [near, _]: [f64; 2]) -> Result<(), CalibrationError> {
    if !(unit_mm > 0.0 && unit_mm <= COARSEST_MM) {
        return calibration::wrong(
            "depth_unit_mm",
            format!(
                "a unit of {unit_mm} mm is not within 0 and {COARSEST_MM}: it is the length of one step in mm, so that 1000 steps \
                 in a metre are 1"
            ),
        );
    }
    let farthest = f64::from(u16::MAX) * unit_mm;
    if farthest < near {
        return calibration::wrong(
            "depth_unit_mm",
            format!(
                "with a unit of {unit_mm} mm the largest depth is {farthest:.0} mm, and ropes are looked for from {near} mm: \
                 the unit is in millimetres, a step of 0.001 m is 1"
            ),
        );
    }
    if noise_mm > 0.0 && noise_mm < FINEST_MM {
        return calibration::wrong(
            "noise_mm_at_1m",
            format!("no depth camera has a noise of {noise_mm} mm at 1 m: it is in millimetres"),
        );
    }
    Ok(())
}

/// Reads the range of depths in which to look for ropes, in mm.
pub(crate) fn read_range(file: &Node) -> Result<[f64; 2], CalibrationError> {
    match calibration::find(file, &["rangemm"]) {
        None => Ok(RANGE_MM),
        Some((key, value)) => match calibration::numbers(key, value)?[..] {
            [near, far] if (0.0..LEAST_MM).contains(&near) && near < far && far < LEAST_MM => {
                calibration::wrong(
                    key,
                    format!(
                        "depths from {near} to {far} mm are too near for a camera: it is in millimetres"
                    ),
                )
            }
            [near, far] => Ok([near, far]),
            _ => calibration::wrong(key, "a range is two depths in mm: [ near, far ]"),
        },
    }
}

fn number(file: &Node, name: &str, default: f64) -> Result<f64, CalibrationError> {
    let Some((key, value)) = calibration::find(file, &[name]) else {
        return Ok(default);
    };
    match calibration::number(value) {
        Some(number) => Ok(number),
        None => calibration::wrong(key, "a single number is expected here"),
    }
}
