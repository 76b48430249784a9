//! `sensor_msgs/PointCloud2`: the centerlines' points, with which rope they are of and what is known of each.

use lariat_record::{Cdr, Encoder};
use lariat_wire::{Descriptors, Descriptors3, Place, Status as Seen};

use super::{Header, Scale, Shapes};

/// As in `sensor_msgs/PointField`.
const UINT8: u8 = 2;
const UINT32: u8 = 6;
const FLOAT32: u8 = 7;

/// Name, offset in bytes, type.
type Field = (&'static str, u32, u8);
/// What every point has; behind it `hidden`, or in space `sigma`, and `status`.
const FIELDS: [Field; 6] = [
    ("x", 0, FLOAT32),
    ("y", 4, FLOAT32),
    ("z", 8, FLOAT32),
    ("rope", 12, UINT32),
    ("rho", 16, FLOAT32),
    ("width", 20, FLOAT32),
];
const FLAT: [Field; 2] = [("hidden", 24, UINT8), ("status", 25, UINT8)];
const IN_SPACE: [Field; 2] = [("sigma", 24, FLOAT32), ("status", 28, UINT8)];
/// Bytes of a point: the fields, and room up to a whole word.
const FLAT_STEP: usize = 28;
const IN_SPACE_STEP: usize = 32;

/// Writes the points of all ropes that are seen, one rope after the other, each from its first end to its last. `rope` is the
/// track, `rho` the normalized arc length, `hidden` 1 where something covers the rope, `sigma` the standard deviation along the line to the camera,
/// `status` the descriptor's: 4 is a rope that may be none.
pub(crate) fn points(shapes: Shapes, header: &Header, into: &mut Vec<u8>) {
    match shapes {
        Shapes::Flat(message) => flat(message, header, into),
        Shapes::InSpace(message) => in_space(message, header, into),
    }
}

fn flat(message: &Descriptors, header: &Header, into: &mut Vec<u8>) {
    let scale = Scale::of(message);
    // The points of one that is lost are not of this image.
    let seen = || {
        let both = message.curves().iter().zip(message.centerlines());
        both.filter(|(rope, _)| is_seen(rope.status()))
    };
    let count = seen().map(|(_, line)| line.points().len()).sum();
    let to = &mut Encoder::new(into);
    let mut cloud = Cloud::<FLAT_STEP>::begin(to, header, FLAT, count);
    for (rope, line) in seen() {
        let steps = line
            .points()
            .len()
            .saturating_sub(usize::from(line.closed == 0));
        for (i, (point, width)) in line.points().iter().zip(line.widths()).enumerate() {
            let width = scale.length(f64::from(*width));
            let at = scale.point(point.map(f64::from));
            cloud.put(
                at,
                rope.track,
                i as f64 / steps.max(1) as f64,
                width,
                |bytes| {
                    bytes[24] = line.is_hidden(i).into();
                    bytes[25] = rope.status as u8;
                },
            );
        }
    }
    cloud.end();
}

fn in_space(message: &Descriptors3, header: &Header, into: &mut Vec<u8>) {
    let scale = Scale::MILLIMETERS;
    let seen = || {
        let ropes = message.curves().iter();
        ropes.filter(|rope| is_seen(rope.status()) && rope.place() == Some(Place::Known))
    };
    let count = seen().map(|rope| rope.points().len()).sum();
    let to = &mut Encoder::new(into);
    let mut cloud = Cloud::<IN_SPACE_STEP>::begin(to, header, IN_SPACE, count);
    for rope in seen() {
        let steps = rope
            .points()
            .len()
            .saturating_sub(usize::from(rope.closed == 0));
        let width = scale.length(rope.width);
        for (i, (point, sigma)) in rope.points().iter().zip(rope.sigmas()).enumerate() {
            let at = scale.point3(point.map(f64::from));
            cloud.put(
                at,
                rope.track,
                i as f64 / steps.max(1) as f64,
                width,
                |bytes| {
                    let sigma = scale.length(f64::from(*sigma)) as f32;
                    bytes[24..28].copy_from_slice(&sigma.to_le_bytes());
                    bytes[28] = rope.status as u8;
                },
            );
        }
    }
    cloud.end();
}

fn is_seen(status: Option<Seen>) -> bool {
    status.is_some_and(|status| status != Seen::Lost)
}

/// A cloud of points of `STEP` bytes each, while it is written.
struct Cloud<'e, 'b, const STEP: usize>(&'e mut Encoder<'b>);

impl<'e, 'b, const STEP: usize> Cloud<'e, 'b, STEP> {
    fn begin(to: &'e mut Encoder<'b>, header: &Header, more: [Field; 2], count: usize) -> Self {
        header.put(to);
        1_u32.put(to);
        (count as u32).put(to);
        to.byte_count(FIELDS.len() + more.len());
        for (name, offset, kind) in FIELDS.into_iter().chain(more) {
            to.string(name);
            offset.put(to);
            kind.put(to);
            1_u32.put(to);
        }
        0_u8.put(to);
        (STEP as u32).put(to);
        ((STEP * count) as u32).put(to);
        to.byte_count(STEP * count);
        Self(to)
    }

    fn put(
        &mut self,
        [x, y, z]: [f64; 3],
        track: u32,
        rho: f64,
        width: f64,
        more: impl FnOnce(&mut [u8; STEP]),
    ) {
        let mut bytes = [0; STEP];
        for (place, number) in [(0, x), (4, y), (8, z), (16, rho), (20, width)] {
            bytes[place..place + 4].copy_from_slice(&(number as f32).to_le_bytes());
        }
        bytes[12..16].copy_from_slice(&track.to_le_bytes());
        more(&mut bytes);
        self.0.raw(&bytes);
    }

    /// Every number in it is one.
    fn end(self) {
        1_u8.put(self.0);
    }
}
