//! `sensor_msgs/PointCloud2`: the points of the centerlines, with the rope and status of each.

use lariat_record::{Cdr, Encoder};
use lariat_wire::{Descriptors, Descriptors3, Place, Status as Seen};

use super::{Header, Scale, Shapes};

/// Value of a point's field.
#[derive(Clone, Copy)]
enum Value {
    Byte(u8),
    Word(u32),
    Number(f64),
}

impl Value {
    /// Type, as in `sensor_msgs/PointField`, and size in bytes.
    fn kind(self) -> (u8, u32) {
        match self {
            Self::Byte(_) => (2, 1),
            Self::Word(_) => (6, 4),
            Self::Number(_) => (7, 4),
        }
    }

    fn put(self, to: &mut Encoder) {
        match self {
            Self::Byte(byte) => to.raw(&[byte]),
            Self::Word(word) => to.raw(&word.to_le_bytes()),
            Self::Number(number) => to.raw(&(number as f32).to_le_bytes()),
        }
    }
}

/// A point of a rope.
#[derive(Default)]
struct Point {
    at: [f64; 3],
    rope: u32,
    rho: f64,
    width: f64,
    status: u32,
}

impl Point {
    /// The fields in order, without gaps. `more` is the field that differs between image and space.
    fn fields(&self, more: (&'static str, Value)) -> [(&'static str, Value); 8] {
        let [x, y, z] = self.at.map(Value::Number);
        [
            ("x", x),
            ("y", y),
            ("z", z),
            ("rope", Value::Word(self.rope)),
            ("rho", Value::Number(self.rho)),
            ("width", Value::Number(self.width)),
            more,
            ("status", Value::Byte(self.status as u8)),
        ]
    }
}

fn hidden(is_hidden: bool) -> (&'static str, Value) {
    ("hidden", Value::Byte(is_hidden.into()))
}

fn sigma(sigma: f64) -> (&'static str, Value) {
    ("sigma", Value::Number(sigma))
}

/// Writes the points of all visible ropes, one rope after the other, each from its first end to its
/// last. `rope` is the track and `rho` the normalized arc length. `hidden` is 1 for a covered
/// point, and `sigma` is the standard deviation along the camera's line of sight. `status` is that
/// of the descriptor; 4 is a possible rope.
pub(crate) fn points(shapes: Shapes, header: &Header, into: &mut Vec<u8>) {
    match shapes {
        Shapes::Flat(message) => flat(message, header, into),
        Shapes::InSpace(message) => in_space(message, header, into),
    }
}

fn flat(message: &Descriptors, header: &Header, into: &mut Vec<u8>) {
    let scale = Scale::of(message);
    // The points of a lost rope are not from this image.
    let seen = || {
        let both = message.curves().iter().zip(message.centerlines());
        both.filter(|(rope, _)| is_seen(rope.status()))
    };
    let count = seen().map(|(_, line)| line.points().len()).sum();
    let to = &mut Encoder::new(into);
    let mut cloud = Cloud::begin(to, header, hidden(false), count);
    for (rope, line) in seen() {
        let steps = line
            .points()
            .len()
            .saturating_sub(usize::from(line.closed == 0));
        for (i, (point, width)) in line.points().iter().zip(line.widths()).enumerate() {
            let point = Point {
                at: scale.point(point.map(f64::from)),
                rope: rope.track,
                rho: i as f64 / steps.max(1) as f64,
                width: scale.length(f64::from(*width)),
                status: rope.status,
            };
            cloud.put(&point, hidden(line.is_hidden(i)));
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
    let mut cloud = Cloud::begin(to, header, sigma(0.0), count);
    for rope in seen() {
        let steps = rope
            .points()
            .len()
            .saturating_sub(usize::from(rope.closed == 0));
        for (i, (point, doubt)) in rope.points().iter().zip(rope.sigmas()).enumerate() {
            let point = Point {
                at: scale.point3(point.map(f64::from)),
                rope: rope.track,
                rho: i as f64 / steps.max(1) as f64,
                width: scale.length(rope.width),
                status: rope.status,
            };
            cloud.put(&point, sigma(scale.length(f64::from(*doubt))));
        }
    }
    cloud.end();
}

fn is_seen(status: Option<Seen>) -> bool {
    status.is_some_and(|status| status != Seen::Lost)
}

/// A point cloud that is being written. Each point has the bytes of its fields, padded to a
/// multiple of 4.
struct Cloud<'e, 'b> {
    to: &'e mut Encoder<'b>,
    room: usize,
}

impl<'e, 'b> Cloud<'e, 'b> {
    /// Begins a cloud. `more` is the additional field with any value.
    fn begin(
        to: &'e mut Encoder<'b>,
        header: &Header,
        more: (&'static str, Value),
        count: usize,
    ) -> Self {
        header.put(to);
        1_u32.put(to);
        (count as u32).put(to);
        let fields = Point::default().fields(more);
        to.byte_count(fields.len());
        let mut offset = 0_u32;
        for (name, value) in fields {
            let (kind, bytes) = value.kind();
            to.string(name);
            offset.put(to);
            kind.put(to);
            1_u32.put(to);
            offset += bytes;
        }
        let step = offset.next_multiple_of(4);
        0_u8.put(to);
        step.put(to);
        (step * count as u32).put(to);
        to.byte_count(step as usize * count);
        Self {
            to,
            room: (step - offset) as usize,
        }
    }

    fn put(&mut self, point: &Point, more: (&'static str, Value)) {
        for (_, value) in point.fields(more) {
            value.put(self.to);
        }
        self.to.raw(&[0; 3][..self.room]);
    }

    /// Ends the cloud; all its numbers are valid.
    fn end(self) {
        1_u8.put(self.to);
    }
}

#[cfg(test)]
mod tests {
    use lariat_record::Decoder;

    use super::*;

    /// The name, offset and type of each field as a subscriber reads them, and the size of a point
    /// in bytes.
    fn read(more: (&'static str, Value)) -> (Vec<(String, u32, u8)>, usize) {
        let (mut buffer, point) = (Vec::new(), Point::default());
        let header = Header {
            stamp_ns: 1,
            frame_id: "camera",
        };
        let mut to = Encoder::new(&mut buffer);
        let mut cloud = Cloud::begin(&mut to, &header, more, 3);
        (0..3).for_each(|_| cloud.put(&point, more));
        cloud.end();
        let mut from = Decoder::new(&buffer).expect("CDR");
        let word = |from: &mut Decoder| from.value::<u32>().expect("a word");
        word(&mut from);
        word(&mut from);
        assert_eq!(from.string(), Ok("camera"));
        assert_eq!([word(&mut from), word(&mut from)], [1, 3]);
        let fields = (0..word(&mut from)).map(|_| {
            let name = from.string().expect("a name").to_owned();
            let field = (name, word(&mut from), from.value().expect("a type"));
            assert_eq!(word(&mut from), 1);
            field
        });
        let fields = fields.collect();
        assert_eq!(from.value(), Ok(0_u8), "little endian");
        let (step, row) = (word(&mut from), word(&mut from));
        assert_eq!((row, word(&mut from)), (3 * step, 3 * step));
        // One more byte follows the points.
        let head = buffer.len() - 1 - 3 * step as usize;
        assert!(buffer[head..buffer.len() - 1].iter().all(|byte| *byte == 0));
        (fields, step as usize)
    }

    #[test]
    fn fields_stand_where_their_list_says() {
        let common = [
            ("x", 0, 7),
            ("y", 4, 7),
            ("z", 8, 7),
            ("rope", 12, 6),
            ("rho", 16, 7),
            ("width", 20, 7),
        ];
        let of = |more: [(&str, u32, u8); 2]| {
            let fields = common.into_iter().chain(more);
            let fields = fields.map(|(name, offset, kind)| (name.to_owned(), offset, kind));
            fields.collect::<Vec<_>>()
        };
        let flat = of([("hidden", 24, 2), ("status", 25, 2)]);
        assert_eq!(read(hidden(false)), (flat, 28));
        let in_space = of([("sigma", 24, 7), ("status", 28, 2)]);
        assert_eq!(read(sigma(0.0)), (in_space, 32));
    }
}
