//! A pinhole camera at any position.

/// A camera without distortion: x right, y down, z ahead; (0, 0) is the center of the top-left
/// pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Eye {
    /// Focal lengths, px.
    pub focal_px: [f64; 2],
    /// Principal point, px.
    pub center_px: [f64; 2],
    /// Width and height of its images.
    pub size: [usize; 2],
    /// Rows of the rotation from the table's frame to the camera's.
    pub rotation: [[f64; 3]; 3],
    /// Translation after the rotation, mm.
    pub translation: [f64; 3],
}

impl Eye {
    /// Makes a camera that looks at the table's origin from `distance_mm`, tilted by `lean_deg`
    /// from the vertical and turned by `turn_deg`.
    pub fn above(
        focal_px: f64,
        size: [usize; 2],
        distance_mm: f64,
        lean_deg: f64,
        turn_deg: f64,
    ) -> Self {
        let (sin_lean, cos_lean) = libm::sincos(lean_deg.to_radians());
        let (sin_turn, cos_turn) = libm::sincos(turn_deg.to_radians());
        // x is to the viewer's right; down in the picture is toward the table's −y, and away from
        // the camera's height.
        Self {
            focal_px: [focal_px; 2],
            center_px: size.map(|side| 0.5 * (side as f64 - 1.0)),
            size,
            rotation: [
                [cos_turn, sin_turn, 0.0],
                [sin_turn * cos_lean, -cos_turn * cos_lean, -sin_lean],
                [-sin_turn * sin_lean, cos_turn * sin_lean, -cos_lean],
            ],
            translation: [0.0, 0.0, distance_mm],
        }
    }

    /// Makes a camera with the same orientation and another lens, moved by `by_mm` in this camera's
    /// frame.
    pub fn beside(&self, by_mm: [f64; 3], focal_px: f64, size: [usize; 2]) -> Self {
        Self {
            focal_px: [focal_px; 2],
            center_px: size.map(|side| 0.5 * (side as f64 - 1.0)),
            size,
            translation: [0, 1, 2].map(|k| self.translation[k] - by_mm[k]),
            ..*self
        }
    }

    /// Makes a camera like this one, moved by `by_mm` in its frame. The new camera is turned to
    /// look at the point that this camera sees in the middle of its image at a distance of
    /// `ahead_mm`.
    pub fn verging(&self, by_mm: [f64; 3], ahead_mm: f64) -> Self {
        let turn = turned_to([-by_mm[0], -by_mm[1], ahead_mm - by_mm[2]]);
        let beside = self.beside(by_mm, self.focal_px[0], self.size);
        let column = |k: usize| self.rotation.map(|row| row[k]);
        Self {
            rotation: turn.map(|row| [0, 1, 2].map(|k| dot(row, column(k)))),
            translation: turn.map(|row| dot(row, beside.translation)),
            ..*self
        }
    }

    /// Returns the rotation from this camera's frame to the other's, row by row, and this camera's
    /// position there, mm.
    pub fn pose_in(&self, other: &Self) -> ([[f64; 3]; 3], [f64; 3]) {
        let turn = [0, 1, 2].map(|i| [0, 1, 2].map(|j| dot(other.rotation[i], self.rotation[j])));
        let moved = turn.map(|row| dot(row, self.translation));
        (turn, [0, 1, 2].map(|k| other.translation[k] - moved[k]))
    }

    /// Transforms a point from the table's frame to the camera's.
    pub fn see(&self, point: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|k| dot(self.rotation[k], point) + self.translation[k])
    }

    /// Projects a point of the camera's frame into the picture. The point must be in front of the
    /// camera.
    pub fn pixel(&self, seen: [f64; 3]) -> [f64; 2] {
        [0, 1].map(|k| self.focal_px[k] * seen[k] / seen[2] + self.center_px[k])
    }

    /// Returns the ray through a pixel in the camera's frame, scaled to one millimeter of depth.
    pub(crate) fn ray(&self, pixel: [f64; 2]) -> [f64; 3] {
        let [x, y] = [0, 1].map(|k| (pixel[k] - self.center_px[k]) / self.focal_px[k]);
        [x, y, 1.0]
    }

    /// Returns the depth of the table along such a ray.
    pub(crate) fn table_depth(&self, ray: [f64; 3]) -> f64 {
        // The height above the table at `t` along the ray is n·(t ray − translation), with n the
        // table's normal.
        let normal = self.rotation.map(|row| row[2]);
        dot(normal, self.translation) / dot(normal, ray)
    }

    /// Returns the point on the table at this depth.
    pub(super) fn on_table(&self, ray: [f64; 3], depth: f64) -> [f64; 2] {
        let seen = [0, 1, 2].map(|k| depth * ray[k] - self.translation[k]);
        [0, 1].map(|axis| (0..3).map(|k| self.rotation[k][axis] * seen[k]).sum())
    }
}

/// Rotation after which this direction is straight ahead. Down remains down as far as possible.
fn turned_to(way: [f64; 3]) -> [[f64; 3]; 3] {
    let unit = |v: [f64; 3]| {
        let size = dot(v, v).sqrt();
        v.map(|c| c / size)
    };
    let ahead = unit(way);
    let right = unit([ahead[2], 0.0, -ahead[0]]);
    let down = [
        ahead[1] * right[2] - ahead[2] * right[1],
        ahead[2] * right[0] - ahead[0] * right[2],
        ahead[0] * right[1] - ahead[1] * right[0],
    ];
    [right, down, ahead]
}

pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
