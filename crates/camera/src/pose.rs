//! The pose of one coordinate frame in another.

use crate::calibration::{self, CalibrationError};
use crate::document::{self, Node};
use crate::rotation::is_rotation;
use thiserror::Error;

/// Why numbers are not a pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum PoseError {
    /// An invalid rotation.
    #[error(
        "invalid rotation: its columns must have length 1 and stand at right angles, right-handed"
    )]
    Rotation,
    /// An invalid translation.
    #[error("invalid translation: three lengths in mm, below 100 m")]
    Translation,
}

/// Minimum distance of a camera from the frame of a robot or a table, mm. This is the shortest
/// working distance of a lens. Lengths of up to 10 m that are given in meters by mistake are below
/// this minimum.
pub const LEAST_MM: f64 = 10.0;
/// Minimum distance between a depth camera and its color camera, mm, unless they coincide. A
/// housing is shorter than 1 m, so a distance given in meters by mistake is below this.
pub(crate) const LEAST_BESIDE_MM: f64 = 1.0;
/// Shifts up to this are negligible for every rope, mm: a micrometer.
const NONE_MM: f64 = 1e-3;

/// Checks that a shift can be in millimeters.
///
/// # Errors
/// It is too short, and more likely in meters.
fn in_plausible_mm(
    key: &str,
    shift: [f64; 3],
    least_mm: f64,
) -> Result<[f64; 3], CalibrationError> {
    let size = dot(shift, shift).sqrt();
    if (NONE_MM..least_mm).contains(&size) {
        return calibration::wrong(
            key,
            format!(
                "a shift of {size:.3} mm is too short for cameras: if the numbers are metres, name them translation_m; if they are \
                 millimetres, name their thousandths so"
            ),
        );
    }
    Ok(shift)
}

/// A rotation and a translation of points from one frame to another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    rotation: [[f64; 3]; 3],
    translation: [f64; 3],
}

impl Pose {
    /// The pose of two frames that coincide.
    pub const SAME: Self = Self {
        rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        translation: [0.0; 3],
    };

    /// Creates the pose that maps a point `p` to `rotation p + translation_mm`. The rotation is
    /// given by rows.
    ///
    /// # Errors
    /// `rotation` is not a rotation, or the translation is not below 100 m.
    pub fn new(rotation: [[f64; 3]; 3], translation_mm: [f64; 3]) -> Result<Self, PoseError> {
        if !is_rotation(&rotation) {
            return Err(PoseError::Rotation);
        }
        if !translation_mm.iter().all(|c| c.abs() < 1e5) {
            return Err(PoseError::Translation);
        }
        Ok(Self {
            rotation,
            translation: translation_mm,
        })
    }

    /// Reads the pose of a camera relative to the robot from YAML. The keys are `rotation`, nine
    /// numbers row by row or a quaternion x, y, z, w, and `translation_mm`, three numbers, or
    /// `translation_m`.
    ///
    /// # Errors
    /// The keys are missing, or their values are invalid.
    pub fn from_yaml(text: &str) -> Result<Self, CalibrationError> {
        let file = document::read(text)?;
        Self::read(&file, LEAST_MM)?.ok_or(CalibrationError::Missing(
            "pose",
            "rotation (nine numbers, or a quaternion x, y, z, w) and translation_mm",
        ))
    }

    /// Reads the pose of a file, if there is one. A `translation_mm` shorter than `least_mm` is
    /// refused, because it is probably in meters.
    pub(crate) fn read(file: &Node, least_mm: f64) -> Result<Option<Self>, CalibrationError> {
        let rotation = calibration::find(file, &["rotation"]);
        let in_mm = calibration::find(file, &["translationmm"]);
        let in_m = calibration::find(file, &["translationm"]);
        if let (Some(_), Some((key, _))) = (in_mm, in_m) {
            return calibration::wrong(key, "give translation_mm or translation_m, not both");
        }
        let translation = in_mm.or(in_m);
        let (Some((key, turn)), Some((beside, shift))) = (rotation, translation) else {
            return match (rotation, translation) {
                (None, None) => Ok(None),
                (Some((key, _)), _) | (_, Some((key, _))) => calibration::wrong(
                    key,
                    "give both rotation and translation_mm (or translation_m), or neither",
                ),
            };
        };
        let rotation = match calibration::numbers(key, turn)?[..] {
            [x, y, z, w] => turned_by([x, y, z, w]),
            [a, b, c, d, e, f, g, h, i] => Some([[a, b, c], [d, e, f], [g, h, i]]),
            _ => None,
        };
        let Some(rotation) = rotation else {
            return calibration::wrong(
                key,
                "a rotation is nine numbers, row by row, or a quaternion x, y, z, w of length 1",
            );
        };
        let [x, y, z] = calibration::numbers(beside, shift)?[..] else {
            return calibration::wrong(beside, "a translation is three numbers, in mm");
        };
        let shift_mm = match in_m {
            Some(_) => [x, y, z].map(|c| 1000.0 * c),
            None => in_plausible_mm(beside, [x, y, z], least_mm)?,
        };
        match Self::new(rotation, shift_mm) {
            Ok(pose) => Ok(Some(pose)),
            Err(cause @ PoseError::Rotation) => calibration::wrong(key, cause.to_string()),
            Err(cause) => calibration::wrong(beside, cause.to_string()),
        }
    }

    /// Returns the inverse pose.
    pub fn inverse(&self) -> Self {
        let back = [0, 1, 2].map(|i| [0, 1, 2].map(|j| self.rotation[j][i]));
        Self {
            rotation: back,
            translation: back.map(|row| -dot(row, self.translation)),
        }
    }

    /// Transforms a point to the other frame, mm.
    pub fn point(&self, point: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|k| dot(self.rotation[k], point) + self.translation[k])
    }

    /// Rotates a direction, or a velocity, to the other frame.
    pub fn way(&self, way: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = self.rotation;
        [dot(x, way), dot(y, way), dot(z, way)]
    }

    /// The translation, mm.
    pub(crate) fn translation_mm(&self) -> [f64; 3] {
        self.translation
    }
}

fn turned_by(quaternion: [f64; 4]) -> Option<[[f64; 3]; 3]> {
    let size = quaternion.iter().map(|c| c * c).sum::<f64>();
    let [x, y, z, w] = quaternion;
    ((size - 1.0).abs() < 1e-3).then(|| {
        let twice = 2.0 / size;
        [
            [
                1.0 - twice * (y * y + z * z),
                twice * (x * y - z * w),
                twice * (x * z + y * w),
            ],
            [
                twice * (x * y + z * w),
                1.0 - twice * (x * x + z * z),
                twice * (y * z - x * w),
            ],
            [
                twice * (x * z - y * w),
                twice * (y * z + x * w),
                1.0 - twice * (x * x + y * y),
            ],
        ]
    })
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
