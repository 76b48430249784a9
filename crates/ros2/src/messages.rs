//! What a message of lariat is in ROS's own types, as CDR. Pure: no I/O, no clock.
//!
//! Lengths are metres in space, and where the rig has a plane (`mm`); else pixels, of the image or, with a lens only, of an ideal one:
//! then a number in a message of ROS is a pixel, which [`Scale`] says. On the plane z is 0.

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

/// Where and when a message's numbers hold.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Header<'a> {
    /// Nanoseconds of Unix time: when the image was taken.
    pub(crate) stamp_ns: u64,
    pub(crate) frame_id: &'a str,
}

impl Header<'_> {
    fn put(&self, to: &mut Encoder) {
        lariat_record::put_header(to, self.stamp_ns, self.frame_id);
    }
}

/// What the rig's lengths are multiplied by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Scale(f64);

impl Scale {
    pub(crate) const MILLIMETERS: Self = Self(1e-3);

    /// Metres of millimetres; pixels stay.
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

/// `geometry_msgs/Pose`, its x axis along `direction`, of length 1, and its y axis level: without a turn about the direction.
fn put_pose(to: &mut Encoder, at: [f64; 3], direction: [f64; 3]) {
    at.put(to);
    let [x, y, z] = direction;
    let [(sin_yaw, cos_yaw), (sin_rise, cos_rise)] =
        [y.atan2(x), z.atan2(x.hypot(y))].map(|angle| (0.5 * angle).sin_cos());
    // To rise is to turn about y backwards.
    [
        sin_yaw * sin_rise,
        -cos_yaw * sin_rise,
        sin_yaw * cos_rise,
        cos_yaw * cos_rise,
    ]
    .put(to);
}

/// The quaternion x, y, z, w of a turn about z.
fn turn_about_z(yaw: f64) -> [f64; 4] {
    let (sine, cosine) = (0.5 * yaw).sin_cos();
    [0.0, 0.0, sine, cosine]
}
