//! What a message says of its fields: from it follow its text, its bytes in recordings, its tables in documents and its
//! layouts in other languages.

pub use crate::codes::{Code, Codes};
pub use crate::message::hidden::{Hidden, hidden, is_hidden};

/// A message that says its fields, one after the other as they lie in memory. Reserved ones are not said.
pub trait Message {
    /// Its fields, and where they lie.
    fn layout(&self) -> &'static Layout;

    /// Shows every field, lists as far as they are meant.
    fn visit<'a>(&'a self, see: &mut dyn FnMut(&'static Field, Value<'a>));

    /// Lends every field, lists whole. Reserved ones are made 0.
    fn visit_mut(&mut self, see: &mut dyn FnMut(&'static Field, Place<'_>));

    /// What [`visit`](Self::visit) shows.
    fn fields(&self) -> Vec<(&'static Field, Value<'_>)> {
        let mut fields = Vec::new();
        self.visit(&mut |field, value| fields.push((field, value)));
        fields
    }
}

/// How a message lies in memory.
#[derive(Debug)]
#[non_exhaustive]
pub struct Layout {
    /// What it is called here.
    pub name: &'static str,
    /// What the transport calls it, with its version.
    pub type_name: &'static str,
    /// Bytes.
    pub size: usize,
    /// Every field, reserved ones too, in order and without gaps.
    pub fields: &'static [Field],
}

/// A field of a message.
#[derive(Debug)]
#[non_exhaustive]
pub struct Field {
    /// Its name.
    pub name: &'static str,
    /// What it says, as its documentation has it.
    pub about: &'static str,
    /// Where it begins, in bytes from the message's own beginning.
    pub offset: usize,
    /// What it is made of.
    pub of: Type,
    /// How its value is to be read.
    pub meaning: Meaning,
}

/// What a field is made of.
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
    /// So many of these.
    Array(&'static Type, usize),
}

impl Type {
    /// Bytes.
    pub const fn size(&self) -> usize {
        match self {
            Self::U32 | Self::F32 => 4,
            Self::U64 | Self::F64 => 8,
            Self::Message(layout) => layout.size,
            Self::Array(of, count) => of.size() * *count,
        }
    }

    /// What an array is made of in the end, and its lengths from the outermost to the innermost; none for what is no array.
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

/// How the value of a field is to be read.
#[derive(Debug)]
pub enum Meaning {
    /// As it is.
    Number,
    /// 0: no, else yes.
    Flag,
    /// Of which ends of the rope it is true: bit 0 the first, bit 1 the last.
    Ends,
    /// As one of these.
    Code(&'static Codes),
    /// How many entries of the list of this name are meant.
    Count(&'static str),
    /// A bit a point: whether something covers it.
    Hidden,
    /// Positions, as far as they are meant.
    Points,
    /// Other numbers, likewise.
    List,
    /// A message within.
    Message,
    /// Several, as far as they are meant.
    Messages,
    /// 0.
    Reserved,
}

/// The value of a field, as far as it is meant.
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
    /// Rows of so many numbers.
    F32s(&'a [f32], usize),
    /// Rows of so many numbers.
    F64s(&'a [f64], usize),
    /// Which of so many points are covered.
    Hidden(&'a Hidden, usize),
    /// A message within.
    Message(&'a dyn Message),
    /// Several.
    Messages(Messages<'a>),
}

/// Where the value of a field is to be written.
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
    /// Room for rows of so many numbers.
    F32s(&'a mut [f32], usize),
    /// Room for rows of so many numbers.
    F64s(&'a mut [f64], usize),
    /// Which points are covered.
    Hidden(&'a mut Hidden),
    /// A message within.
    Message(&'a mut dyn Message),
    /// Room for several.
    Messages(&'a mut dyn Room),
}

/// The messages of a list that are meant.
#[derive(Clone, Copy)]
pub struct Messages<'a> {
    room: &'a dyn Room,
    count: usize,
}

impl<'a> Messages<'a> {
    pub(crate) fn of(room: &'a dyn Room, count: usize) -> Self {
        Self { room, count }
    }

    /// How many there are.
    pub fn count(self) -> usize {
        self.count
    }

    /// One after the other.
    pub fn iter(self) -> impl Iterator<Item = &'a dyn Message> {
        (0..self.count).map(move |i| self.room.at(i))
    }
}

/// A fixed number of messages of one kind.
pub trait Room {
    /// How many.
    fn size(&self) -> usize;
    /// One of them.
    fn at(&self, i: usize) -> &dyn Message;
    /// One of them, to be written.
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

/// What a field may be made of.
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

    /// A layout and those within.
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
