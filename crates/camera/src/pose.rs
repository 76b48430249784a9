//! Where one frame of coordinates stands in another.

use crate::calibration::{self, CalibrationError};
use crate::rotation::is_rotation;
use crate::yaml::{self, Node};
use thiserror::Error;

/// Why numbers make no pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
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

/// A turn and a shift: of points of one frame to another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    rotation: [[f64; 3]; 3],
    translation: [f64; 3],
}

impl Pose {
    /// The two frames are one.
    pub const SAME: Self = Self {
        rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        translation: [0.0; 3],
    };

    /// A point `p` goes to `rotation p + translation_mm`, the rotation's rows one by one.
    ///
    /// # Errors
    /// The first is no rotation, or the second not below 100 m.
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

    /// Reads `rotation`, nine numbers row by row or a quaternion x, y, z, w, and `translation_mm`, three numbers, of YAML.
    ///
    /// # Errors
    /// It has no such keys, or they say what cannot be.
    pub fn from_yaml(text: &str) -> Result<Self, CalibrationError> {
        let file = yaml::read(text)?;
        Self::read(&file)?.ok_or(CalibrationError::Missing(
            "pose",
            "rotation (nine numbers, or a quaternion x, y, z, w) and translation_mm",
        ))
    }

    /// What a file says of it; `None` if nothing.
    pub(crate) fn read(file: &Node) -> Result<Option<Self>, CalibrationError> {
        let rotation = calibration::find(file, &["rotation"]);
        let translation = calibration::find(file, &["translationmm"]);
        let (Some((key, turn)), Some((beside, shift))) = (rotation, translation) else {
            return match (rotation, translation) {
                (None, None) => Ok(None),
                (Some((key, _)), _) | (_, Some((key, _))) => {
                    calibration::wrong(key, "give both rotation and translation_mm, or neither")
                }
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
        match Self::new(rotation, [x, y, z]) {
            Ok(pose) => Ok(Some(pose)),
            Err(cause @ PoseError::Rotation) => calibration::wrong(key, cause.to_string()),
            Err(cause) => calibration::wrong(beside, cause.to_string()),
        }
    }

    /// The way back.
    pub fn inverse(&self) -> Self {
        let back = [0, 1, 2].map(|i| [0, 1, 2].map(|j| self.rotation[j][i]));
        Self {
            rotation: back,
            translation: back.map(|row| -dot(row, self.translation)),
        }
    }

    /// Where a point is in the other frame, mm.
    pub fn point(&self, point: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|k| dot(self.rotation[k], point) + self.translation[k])
    }

    /// A direction, or a velocity, in the other frame.
    pub fn way(&self, way: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = self.rotation;
        [dot(x, way), dot(y, way), dot(z, way)]
    }

    /// Its shift, mm.
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
