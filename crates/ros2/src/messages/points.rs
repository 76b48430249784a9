//! `sensor_msgs/PointCloud2`: the centerlines' points, with which rope they are of and what is known of each.

use lariat_record::{Cdr, Encoder};
use lariat_wire::Descriptors;

use super::{Header, Scale, seen};

/// As in `sensor_msgs/PointField`.
const UINT8: u8 = 2;
const UINT32: u8 = 6;
const FLOAT32: u8 = 7;

/// Name, offset in bytes, type.
const FIELDS: [(&str, u32, u8); 8] = [
    ("x", 0, FLOAT32),
    ("y", 4, FLOAT32),
    ("z", 8, FLOAT32),
    ("rope", 12, UINT32),
    ("rho", 16, FLOAT32),
    ("width", 20, FLOAT32),
    ("hidden", 24, UINT8),
    ("status", 25, UINT8),
];
/// Bytes of a point: the fields, and room up to a whole word.
const STEP: usize = 28;

/// Writes the points of all ropes that are seen, one rope after the other, each from its first end to its last. `rope` is the
/// track, `rho` the normalized arc length, `hidden` 1 where something covers the rope, `status` the descriptor's: 4 is a
/// rope that may be none.
pub(crate) fn points(message: &Descriptors, header: &Header, into: &mut Vec<u8>) {
    let scale = Scale::of(message);
    let count: usize = seen(message).map(|(_, line)| line.points().len()).sum();
    let to = &mut Encoder::new(into);
    header.put(to);
    1_u32.put(to);
    (count as u32).put(to);
    to.byte_count(FIELDS.len());
    for (name, offset, kind) in FIELDS {
        to.string(name);
        offset.put(to);
        kind.put(to);
        1_u32.put(to);
    }
    0_u8.put(to);
    (STEP as u32).put(to);
    ((STEP * count) as u32).put(to);
    to.byte_count(STEP * count);
    for (rope, line) in seen(message) {
        let steps = line.points().len() - usize::from(line.closed == 0);
        for (i, (point, width)) in line.points().iter().zip(line.widths()).enumerate() {
            let mut bytes = [0; STEP];
            let [x, y, z] = scale.point(point.map(f64::from));
            let rho = i as f64 / steps.max(1) as f64;
            let width = scale.length(f64::from(*width));
            for (place, number) in [(0, x), (4, y), (8, z), (16, rho), (20, width)] {
                bytes[place..place + 4].copy_from_slice(&(number as f32).to_le_bytes());
            }
            bytes[12..16].copy_from_slice(&rope.track.to_le_bytes());
            bytes[24] = line.is_hidden(i).into();
            bytes[25] = rope.status as u8;
            to.raw(&bytes);
        }
    }
    1_u8.put(to);
}
