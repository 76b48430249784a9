//! Converts lariat's messages to ROS's own types, as CDR. Pure: no I/O, no clock.
//!
//! Lengths are meters in space, and on the plane if the rig has one (`mm`). Otherwise they are
//! pixels of the image, or of an ideal image if there is only a lens. A length of 1 in a ROS
//! message is then one pixel, as [`Scale`] defines. On the plane z is 0.

mod camera_info;
mod diagnostics;
mod ellipsoid;
mod markers;
mod path;
mod points;
mod rope;

pub(crate) use camera_info::camera_info;
pub(crate) use diagnostics::{Level, Status, diagnostics};
pub(crate) use markers::markers;
pub(crate) use path::{endpoints, path};
pub(crate) use points::points;
pub(crate) use rope::{Rope, Shapes};

use lariat_record::{Cdr, Encoder};
use lariat_wire::{Descriptors, Unit};

/// Time and coordinate frame of a message.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Header<'a> {
    /// Exposure time of the image in nanoseconds of Unix time.
    pub(crate) stamp_ns: u64,
    pub(crate) frame_id: &'a str,
}

impl Header<'_> {
    fn put(&self, to: &mut Encoder) {
        lariat_record::put_header(to, self.stamp_ns, self.frame_id);
    }
}

/// Factor applied to the rig's lengths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Scale(f64);

impl Scale {
    pub(crate) const MILLIMETERS: Self = Self(1e-3);

    /// Converts millimeters to meters; pixels stay.
    pub(crate) fn of(message: &Descriptors) -> Self {
        match message.unit() {
            Some(Unit::Millimeter) => Self::MILLIMETERS,
            _ => Self(1.0),
        }
    }

    fn length(self, length: f64) -> f64 {
        self.0 * length
    }

    fn point(self, [x, y]: [f64; 2]) -> [f64; 3] {
        [self.0 * x, self.0 * y, 0.0]
    }

    fn point3(self, point: [f64; 3]) -> [f64; 3] {
        point.map(|c| self.0 * c)
    }
}

/// Writes a `geometry_msgs/Pose` whose x axis points along the unit vector `direction`. Its y axis
/// is level, without rotation about the direction.
fn put_pose(to: &mut Encoder, at: [f64; 3], direction: [f64; 3]) {
    at.put(to);
    let [x, y, z] = direction;
    let [(sin_yaw, cos_yaw), (sin_rise, cos_rise)] =
        [y.atan2(x), z.atan2(x.hypot(y))].map(|angle| (0.5 * angle).sin_cos());
    // An upward tilt is a negative rotation about y.
    [
        sin_yaw * sin_rise,
        -cos_yaw * sin_rise,
        sin_yaw * cos_rise,
        cos_yaw * cos_rise,
    ]
    .put(to);
}

/// The quaternion x, y, z, w of a rotation about z.
fn turn_about_z(yaw: f64) -> [f64; 4] {
    let (sine, cosine) = (0.5 * yaw).sin_cos();
    [0.0, 0.0, sine, cosine]
}
