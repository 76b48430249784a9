//! A message as a JSON object: fields by name, enumerations as words, arrays only as far as they
//! are used. Numbers read back exactly.

use lariat_wire::fields::{Field, Meaning, Message, Value, is_hidden};
use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};

/// A message without the named fields.
pub(crate) struct Object<'a>(pub(crate) &'a dyn Message, pub(crate) &'a [&'a str]);

impl Serialize for Object<'_> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut map = to.serialize_map(None)?;
        write_fields(self.0, self.1, &mut map)?;
        map.end()
    }
}

/// Writes the fields of a message, except those named in `but`.
pub(crate) fn write_fields<M: SerializeMap>(
    message: &dyn Message,
    but: &[&str],
    map: &mut M,
) -> Result<(), M::Error> {
    for (field, value) in message.fields() {
        // A list shows its own length.
        if !matches!(field.meaning, Meaning::Count(_)) && !but.contains(&field.name) {
            map.serialize_entry(field.name, &Json(field, value))?;
        }
    }
    Ok(())
}

/// Value of a field.
struct Json<'a>(&'a Field, Value<'a>);

impl Serialize for Json<'_> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        match (&self.0.meaning, self.1) {
            (Meaning::Code(codes), Value::U32(code)) => codes.word(code).serialize(to),
            (Meaning::Flag, Value::U32(flag)) => (flag != 0).serialize(to),
            (Meaning::Ends, Value::U32(ends)) => [ends & 1 != 0, ends & 2 != 0].serialize(to),
            (_, Value::U32(number)) => number.serialize(to),
            (_, Value::U64(number)) => number.serialize(to),
            (_, Value::F32(number)) => number.serialize(to),
            (_, Value::F64(number)) => number.serialize(to),
            (_, Value::Point(at)) => at.serialize(to),
            (_, Value::F32s(numbers, 1)) => numbers.serialize(to),
            (_, Value::F64s(numbers, 1)) => numbers.serialize(to),
            (_, Value::F32s(numbers, columns)) => to.collect_seq(numbers.chunks_exact(columns)),
            (_, Value::F64s(numbers, columns)) => to.collect_seq(numbers.chunks_exact(columns)),
            // Indices of the hidden points, from 0.
            (_, Value::Hidden(hidden, count)) => {
                to.collect_seq((0..count).filter(|&i| is_hidden(hidden, i)))
            }
            (_, Value::Message(message)) => Object(message, &[]).serialize(to),
            (_, Value::Messages(messages)) => {
                to.collect_seq(messages.iter().map(|message| Object(message, &[])))
            }
        }
    }
}
