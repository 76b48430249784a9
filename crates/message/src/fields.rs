//! Descriptions of the messages' fields. A message's text, its bytes in recordings, its tables in
//! the documentation and its layouts in other languages follow from them.

pub use crate::codes::{Code, Codes};
pub use crate::message::hidden::{Hidden, hidden, is_hidden};

/// A message that can list its fields in memory order. Reserved fields are not listed.
pub trait Message {
    /// The fields and their offsets.
    fn layout(&self) -> &'static Layout;

    /// Passes every field to `see`; lists are limited to their valid entries.
    fn visit<'a>(&'a self, see: &mut dyn FnMut(&'static Field, Value<'a>));

    /// Passes every field to `see` for writing; lists are passed whole. Sets reserved fields to 0.
    fn visit_mut(&mut self, see: &mut dyn FnMut(&'static Field, Place<'_>));

    /// Collects the fields that [`visit`](Self::visit) passes to its closure.
    fn fields(&self) -> Vec<(&'static Field, Value<'_>)> {
        let mut fields = Vec::new();
        self.visit(&mut |field, value| fields.push((field, value)));
        fields
    }
}

/// Memory layout of a message.
#[derive(Debug)]
#[non_exhaustive]
pub struct Layout {
    /// Name of the type in Rust.
    pub name: &'static str,
    /// Name in the transport, with its version.
    pub type_name: &'static str,
    /// Size in bytes.
    pub size: usize,
    /// Every field, including reserved ones, in order and without gaps.
    pub fields: &'static [Field],
}

/// A field of a message.
#[derive(Debug)]
#[non_exhaustive]
pub struct Field {
    /// Name of the field.
    pub name: &'static str,
    /// Description, from its documentation.
    pub about: &'static str,
    /// Offset in bytes from the start of its message.
    pub offset: usize,
    /// Type of the value.
    pub of: Type,
    /// Interpretation of the value.
    pub meaning: Meaning,
}

/// Type of a field.
#[derive(Debug)]
pub enum Type {
    /// `u32`.
    U32,
    /// `u64`.
    U64,
    /// `f32`.
    F32,
    /// `f64`.
    F64,
    /// A message.
    Message(&'static Layout),
    /// An array of this type and length.
    Array(&'static Type, usize),
}

impl Type {
    /// Size in bytes.
    pub const fn size(&self) -> usize {
        match self {
            Self::U32 | Self::F32 => 4,
            Self::U64 | Self::F64 => 8,
            Self::Message(layout) => layout.size,
            Self::Array(of, count) => of.size() * *count,
        }
    }

    /// The innermost element type of an array, and the lengths from the outermost to the innermost.
    /// The list of lengths is empty for other types.
    pub fn element(&self) -> (&Self, Vec<usize>) {
        match self {
            Self::Array(of, count) => {
                let (element, mut shape) = of.element();
                shape.insert(0, *count);
                (element, shape)
            }
            single => (single, Vec::new()),
        }
    }
}

/// Interpretation of a field's value.
#[derive(Debug)]
pub enum Meaning {
    /// A plain number.
    Number,
    /// A bool: 0 is false, anything else true.
    Flag,
    /// Ends of the rope: bit 0 is the first, bit 1 the last.
    Ends,
    /// One of these values.
    Code(&'static Codes),
    /// Number of valid entries of the list with this name.
    Count(&'static str),
    /// One bit per point: set if the point is covered.
    Hidden,
    /// Positions, limited to the valid ones.
    Points,
    /// Other numbers, limited to the valid ones.
    List,
    /// A nested message.
    Message,
    /// Nested messages, limited to the valid ones.
    Messages,
    /// Always 0.
    Reserved,
}

/// Value of a field, limited to its valid entries.
#[derive(Clone, Copy)]
pub enum Value<'a> {
    /// A number, a code, a flag or a count.
    U32(u32),
    /// A count, or nanoseconds.
    U64(u64),
    /// A number.
    F32(f32),
    /// A number.
    F64(f64),
    /// One position.
    Point([f32; 2]),
    /// Rows of this many numbers.
    F32s(&'a [f32], usize),
    /// Rows of this many numbers.
    F64s(&'a [f64], usize),
    /// Mask of covered points, for this many points.
    Hidden(&'a Hidden, usize),
    /// A nested message.
    Message(&'a dyn Message),
    /// Nested messages.
    Messages(Messages<'a>),
}

/// Mutable reference to the value of a field.
pub enum Place<'a> {
    /// A number, a code, a flag or a count.
    U32(&'a mut u32),
    /// A count, or nanoseconds.
    U64(&'a mut u64),
    /// A number.
    F32(&'a mut f32),
    /// A number.
    F64(&'a mut f64),
    /// One position.
    Point(&'a mut [f32; 2]),
    /// Space for rows of this many numbers.
    F32s(&'a mut [f32], usize),
    /// Space for rows of this many numbers.
    F64s(&'a mut [f64], usize),
    /// Mask of covered points.
    Hidden(&'a mut Hidden),
    /// A nested message.
    Message(&'a mut dyn Message),
    /// Space for nested messages.
    Messages(&'a mut dyn Room),
}

/// The valid messages of a list.
#[derive(Clone, Copy)]
pub struct Messages<'a> {
    room: &'a dyn Room,
    count: usize,
}

impl<'a> Messages<'a> {
    pub(crate) fn of(room: &'a dyn Room, count: usize) -> Self {
        Self { room, count }
    }

    /// Number of messages.
    pub fn count(self) -> usize {
        self.count
    }

    /// Iterates over the messages.
    pub fn iter(self) -> impl Iterator<Item = &'a dyn Message> {
        (0..self.count).map(move |i| self.room.at(i))
    }
}

/// A fixed number of messages of one type.
pub trait Room {
    /// Number of messages.
    fn size(&self) -> usize;
    /// Returns message `i`.
    fn at(&self, i: usize) -> &dyn Message;
    /// Returns message `i` for writing.
    fn at_mut(&mut self, i: usize) -> &mut dyn Message;
}

impl<T: Message, const N: usize> Room for [T; N] {
    fn size(&self) -> usize {
        N
    }

    fn at(&self, i: usize) -> &dyn Message {
        &self[i]
    }

    fn at_mut(&mut self, i: usize) -> &mut dyn Message {
        &mut self[i]
    }
}

/// A type that a field may have.
pub(crate) trait Typed {
    const TYPE: Type;
}

impl<T: Typed, const N: usize> Typed for [T; N] {
    const TYPE: Type = Type::Array(&T::TYPE, N);
}

macro_rules! types {
    ($($type:ident $of:ty),+) => {$(
        impl Typed for $of {
            const TYPE: Type = Type::$type;
        }
    )+};
}
types!(U32 u32, U64 u64, F32 f32, F64 f64);

macro_rules! singles {
    ($($variant:ident $of:ty),+) => {$(
        impl From<$of> for Value<'_> {
            fn from(value: $of) -> Self {
                Self::$variant(value)
            }
        }
        impl<'a> From<&'a mut $of> for Place<'a> {
            fn from(place: &'a mut $of) -> Self {
                Self::$variant(place)
            }
        }
    )+};
}
singles!(U32 u32, U64 u64, F32 f32, F64 f64, Point [f32; 2]);

macro_rules! lists {
    ($($variant:ident $of:ty),+) => {$(
        impl<'a> From<&'a [$of]> for Value<'a> {
            fn from(values: &'a [$of]) -> Self {
                Self::$variant(values, 1)
            }
        }
        impl<'a> From<&'a mut [$of]> for Place<'a> {
            fn from(room: &'a mut [$of]) -> Self {
                Self::$variant(room, 1)
            }
        }
        impl<'a, const N: usize> From<&'a [[$of; N]]> for Value<'a> {
            fn from(rows: &'a [[$of; N]]) -> Self {
                Self::$variant(rows.as_flattened(), N)
            }
        }
        impl<'a, const N: usize> From<&'a mut [[$of; N]]> for Place<'a> {
            fn from(room: &'a mut [[$of; N]]) -> Self {
                Self::$variant(room.as_flattened_mut(), N)
            }
        }
    )+};
}
lists!(F32s f32, F64s f64);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{CenterlinePoints, Centerlines, Command, Descriptors, Descriptors3, FrameHeader};

    /// Returns a layout and all nested layouts, innermost first.
    fn all(layout: &'static Layout) -> Vec<&'static Layout> {
        let inner = layout
            .fields
            .iter()
            .filter_map(|field| match field.of.element().0 {
                Type::Message(inner) => Some(*inner),
                _ => None,
            });
        inner.flat_map(all).chain([layout]).collect()
    }

    #[test]
    fn fields_follow_each_other_without_gaps() {
        let messages = [
            &FrameHeader::LAYOUT,
            &Centerlines::LAYOUT,
            &Descriptors::LAYOUT,
            &Descriptors3::LAYOUT,
            &Command::LAYOUT,
        ];
        for layout in messages.into_iter().flat_map(all) {
            let mut end = 0;
            for field in layout.fields {
                assert_eq!(field.offset, end, "{}.{}", layout.name, field.name);
                end += field.of.size();
            }
            assert_eq!(end, layout.size, "{}", layout.name);
        }
    }

    #[test]
    fn a_list_is_shown_as_far_as_it_is_meant_and_lent_whole() {
        let mut points = CenterlinePoints {
            count: 3,
            ..CenterlinePoints::EMPTY
        };
        let (mut shown, mut lent) = (Vec::new(), Vec::new());
        points.visit(&mut |field, value| {
            if let Value::F32s(values, columns) = value {
                shown.push((field.name, values.len(), columns));
            }
        });
        points.visit_mut(&mut |field, place| {
            if let Place::F32s(values, columns) = place {
                lent.push((field.name, values.len(), columns));
            }
        });
        assert_eq!(shown, [("points", 6, 2), ("widths", 3, 1)]);
        assert_eq!(lent, [("points", 512, 2), ("widths", 256, 1)]);
    }
}
