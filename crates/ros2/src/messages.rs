//! What a message of lariat is in ROS's own types, as CDR. Pure: no I/O, no clock.
//!
//! Lengths are metres where the rig has a plane (`mm`); else pixels, of the image or, with a lens only, of an ideal one: then a
//! number in a message of ROS is a pixel, which [`Scale`] says. z is 0: ropes lie on the plane.

mod camera_info;
mod diagnostics;
mod markers;
mod path;
mod points;

pub(crate) use camera_info::camera_info;
pub(crate) use diagnostics::{Level, Status, diagnostics};
pub(crate) use markers::markers;
pub(crate) use path::{endpoints, path};
pub(crate) use points::points;

use lariat_record::{Cdr, Encoder};
use lariat_wire::{
    CenterlinePoints, Descriptor, Descriptors, FitQuality, Shape, Status as Seen, Unit,
};

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
    /// Metres of millimetres; pixels stay.
    pub(crate) fn of(message: &Descriptors) -> Self {
        Self(match message.unit() {
            Some(Unit::Millimeter) => 1e-3,
            _ => 1.0,
        })
    }

    fn length(self, length: f64) -> f64 {
        self.0 * length
    }

    fn point(self, [x, y]: [f64; 2]) -> [f64; 3] {
        [self.0 * x, self.0 * y, 0.0]
    }
}

/// The ropes of a message with the points that were seen of them, but those that are lost: their points are not of this image.
fn seen(message: &Descriptors) -> impl Iterator<Item = (&Descriptor, &CenterlinePoints)> {
    let both = message.curves().iter().zip(message.centerlines());
    both.filter(|(rope, _)| matches!(rope.status(), Some(status) if status != Seen::Lost))
}

/// The curve of a rope that may be steered by: not of one that is lost or doubtful, nor one that misses the rope.
fn sure(rope: &Descriptor) -> Option<Shape<'_>> {
    let is_rope = matches!(rope.status(), Some(Seen::Ok | Seen::Partial));
    let lies_on_it = rope.fit() != Some(FitQuality::Coarse);
    Shape::of(rope).ok().filter(|_| is_rope && lies_on_it)
}

/// `geometry_msgs/Pose` in the plane, its x axis along `direction`.
fn put_pose(to: &mut Encoder, at: [f64; 3], direction: [f64; 2]) {
    at.put(to);
    let [x, y] = direction;
    put_turn(to, y.atan2(x));
}

/// `geometry_msgs/Quaternion` about z.
fn put_turn(to: &mut Encoder, yaw: f64) {
    let (sine, cosine) = (0.5 * yaw).sin_cos();
    [0.0, 0.0, sine, cosine].put(to);
}
