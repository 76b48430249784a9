//! Encoding of the channels' messages in a recording. Only the valid entries of a list are written.

use lariat_message::fields::{self, Field, Meaning, Message, Place, Value};
use lariat_message::{Centerlines, Descriptors, Descriptors3, FrameHeader, MAX_POINTS};

use crate::cdr::{Cdr, CdrError, Decoder, Encoder};
use crate::schema::{Schema, schema};

/// A message that can be recorded.
pub trait Record {
    /// Schema of the message.
    const SCHEMA: Schema;

    /// Encodes the message into a buffer, replacing its contents.
    fn encode(&self, into: &mut Vec<u8>);

    /// Decodes the message. Entries beyond a `count` are unchanged. After an error, the contents
    /// are unspecified.
    ///
    /// # Errors
    /// Fails if the bytes are not such a message.
    fn decode(&mut self, cdr: &[u8]) -> Result<(), CdrError>;
}

macro_rules! record {
    ($type:ty, $schema:expr) => {
        impl Record for $type {
            const SCHEMA: Schema = $schema;

            fn encode(&self, into: &mut Vec<u8>) {
                self.put(&mut Encoder::new(into));
            }

            fn decode(&mut self, cdr: &[u8]) -> Result<(), CdrError> {
                self.get(&mut Decoder::new(cdr)?)
            }
        }
    };
}
pub(crate) use record;

macro_rules! cdr {
    ($($type:ty),+) => {$(
        impl Cdr for $type {
            fn put(&self, to: &mut Encoder) {
                put(self, to);
            }

            fn get(&mut self, from: &mut Decoder) -> Result<(), CdrError> {
                get(self, from)
            }
        }
    )+};
}
cdr!(FrameHeader, Centerlines, Descriptors, Descriptors3);

record!(
    FrameHeader,
    schema!(
        "lariat_msgs/msg/FrameHeader",
        "FrameHeader.msg",
        "lariat_msgs/Trace" = "Trace.msg"
    )
);
record!(
    Centerlines,
    schema!(
        "lariat_msgs/msg/Centerlines",
        "Centerlines.msg",
        "lariat_msgs/Trace" = "Trace.msg",
        "lariat_msgs/Curve" = "Curve.msg",
        "lariat_msgs/Crossing" = "Crossing.msg",
        "lariat_msgs/PointF32" = "PointF32.msg"
    )
);
record!(
    Descriptors,
    schema!(
        "lariat_msgs/msg/Descriptors",
        "Descriptors.msg",
        "lariat_msgs/Trace" = "Trace.msg",
        "lariat_msgs/Descriptor" = "Descriptor.msg",
        "lariat_msgs/CenterlinePoints" = "CenterlinePoints.msg",
        "lariat_msgs/PointF32" = "PointF32.msg",
        "lariat_msgs/PointF64" = "PointF64.msg",
        "lariat_msgs/Covariance" = "Covariance.msg"
    )
);

record!(
    Descriptors3,
    schema!(
        "lariat_msgs/msg/Descriptors3",
        "Descriptors3.msg",
        "lariat_msgs/Trace" = "Trace.msg",
        "lariat_msgs/Descriptor3" = "Descriptor3.msg",
        "lariat_msgs/Point3F32" = "Point3F32.msg",
        "lariat_msgs/Point3F64" = "Point3F64.msg",
        "lariat_msgs/Covariance3" = "Covariance3.msg"
    )
);

/// Number of parts into which fields are sorted: inner messages and positions, words, numbers,
/// times, lists, and hidden flags of lists. Within a part, fields are in the order of memory.
/// Counts are written with their lists.
const PARTS: usize = 6;

fn put(message: &dyn Message, to: &mut Encoder) {
    for part in 0..PARTS {
        message.visit(&mut |field, value| put_field(part, field, value, to));
    }
}

fn put_field(part: usize, field: &Field, value: Value, to: &mut Encoder) {
    match (part, value) {
        (_, Value::U32(_)) if matches!(field.meaning, Meaning::Count(_)) => {}
        (0, Value::Message(inner)) => put(inner, to),
        (0, Value::Point(at)) => at.put(to),
        (1, Value::U32(word)) => word.put(to),
        (2, Value::F32(number)) => number.put(to),
        (2, Value::F64(number)) => number.put(to),
        (3, Value::U64(count)) => count.put(to),
        (4, Value::F32s(numbers, columns)) => to.rows(numbers, columns),
        (4, Value::F64s(numbers, columns)) => to.rows(numbers, columns),
        (4, Value::Messages(messages)) => {
            to.byte_count(messages.count());
            messages.iter().for_each(|message| put(message, to));
        }
        (5, Value::Hidden(hidden, count)) => {
            to.byte_count(count);
            for i in 0..count {
                u8::from(fields::is_hidden(hidden, i)).put(to);
            }
        }
        _ => {}
    }
}

/// Maximum number of lists in a message.
const MOST_LISTS: usize = 8;

/// Number of entries read for each list.
#[derive(Default)]
struct Lengths {
    lists: [(&'static str, u32); MOST_LISTS],
    count: usize,
}

impl Lengths {
    fn add(&mut self, list: &'static str, entries: u32) {
        self.lists[self.count] = (list, entries);
        self.count += 1;
    }

    fn of(&self, list: &str) -> Option<u32> {
        let found = self.lists.iter().find(|(name, _)| *name == list);
        found.map(|(_, entries)| *entries)
    }
}

fn get(message: &mut dyn Message, from: &mut Decoder) -> Result<(), CdrError> {
    let mut lengths = Lengths::default();
    let mut result = Ok(());
    for part in 0..PARTS {
        message.visit_mut(&mut |field, place| {
            if result.is_ok() {
                result = get_field(part, field, place, from, &mut lengths);
            }
        });
    }
    result?;
    message.visit_mut(&mut |field, place| {
        if let (Meaning::Count(list), Place::U32(count)) = (&field.meaning, place) {
            *count = lengths.of(list).unwrap_or(0);
        }
    });
    // Checks that lists that belong together have the same length, and that there are as many knots
    // as the curve needs.
    let mut is_even = true;
    message.visit(&mut |field, value| {
        let meant = match value {
            Value::F32s(numbers, columns) => numbers.len() / columns,
            Value::F64s(numbers, columns) => numbers.len() / columns,
            Value::Messages(messages) => messages.count(),
            Value::Hidden(_, count) => count,
            _ => return,
        };
        is_even &= lengths.of(field.name) == Some(meant as u32);
    });
    is_even.then_some(()).ok_or(CdrError::Uneven)
}

fn get_field(
    part: usize,
    field: &'static Field,
    place: Place,
    from: &mut Decoder,
    lengths: &mut Lengths,
) -> Result<(), CdrError> {
    match (part, place) {
        (_, Place::U32(_)) if matches!(field.meaning, Meaning::Count(_)) => {}
        (0, Place::Message(inner)) => get(inner, from)?,
        (0, Place::Point(at)) => at.get(from)?,
        (1, Place::U32(word)) => word.get(from)?,
        (2, Place::F32(number)) => number.get(from)?,
        (2, Place::F64(number)) => number.get(from)?,
        (3, Place::U64(count)) => count.get(from)?,
        (4, Place::F32s(room, columns)) => {
            lengths.add(field.name, from.rows(room, columns)?);
        }
        (4, Place::F64s(room, columns)) => {
            lengths.add(field.name, from.rows(room, columns)?);
        }
        (4, Place::Messages(room)) => {
            let count = from.length(room.size())?;
            for i in 0..count {
                get(room.at_mut(i), from)?;
            }
            lengths.add(field.name, count as u32);
        }
        (5, Place::Hidden(hidden)) => {
            let mut bytes = [0_u8; MAX_POINTS];
            let count = from.rows(&mut bytes, 1)?;
            *hidden = fields::hidden(bytes.iter().take(count as usize).map(|byte| *byte != 0));
            lengths.add(field.name, count);
        }
        _ => {}
    }
    Ok(())
}

#[cfg(test)]
mod tests;
