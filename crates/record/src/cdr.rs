//! CDR as ROS 2 uses it: values in order, each aligned to its own size, little endian, after a head of four bytes.

use std::str;

/// The start of every message: plain CDR, little endian, and options that this encoding does not use.
const HEAD: [u8; 4] = [0, 1, 0, 0];

/// What is wrong with the bytes of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum CdrError {
    /// It is not CDR, or not in this byte order.
    #[error("it does not begin as a little-endian CDR message does")]
    Head,
    /// It ends too early.
    #[error("it is cut off")]
    Short,
    /// It is not a protocol buffer.
    #[error("it is not a protocol buffer of Foxglove's schema")]
    Protobuf,
    /// It is not JSON.
    #[error("it is not JSON of Foxglove's schema")]
    Json,
    /// Its bytes are not in base64.
    #[error("its data is not base64")]
    Base64,
    /// A list has more entries than the message has room for.
    #[error("it holds a list of {count} entries where at most {most} are known")]
    TooMany {
        /// How many it says it has.
        count: u32,
        /// How many there may be.
        most: u32,
    },
    /// Lists that belong together have different lengths.
    #[error("it holds lists of different lengths that belong together")]
    Uneven,
    /// A text is not valid UTF-8.
    #[error("it holds a text that is not UTF-8")]
    Text,
}

/// A value that can be written and read.
pub trait Cdr {
    /// Writes it behind what was written.
    fn put(&self, to: &mut Encoder);
    /// Reads it from where the last one ended.
    ///
    /// # Errors
    /// The message ends before it does, or holds what cannot be.
    fn get(&mut self, from: &mut Decoder) -> Result<(), CdrError>;
}

/// Writes a message into a buffer, which it empties first.
pub struct Encoder<'a>(&'a mut Vec<u8>);

impl<'a> Encoder<'a> {
    /// Begins a message in a buffer, which it empties.
    pub fn new(buffer: &'a mut Vec<u8>) -> Self {
        buffer.clear();
        buffer.extend(HEAD);
        Self(buffer)
    }

    /// Goes on with a message whose first part another one wrote.
    pub fn after(buffer: &'a mut Vec<u8>) -> Self {
        debug_assert!(buffer.starts_with(&HEAD));
        Self(buffer)
    }

    /// Leaves room up to the next multiple of `size`, a power of two, counted from behind the head.
    fn align(&mut self, size: usize) {
        let used = self.0.len() - HEAD.len();
        let padding = used.wrapping_neg() & (size - 1);
        self.0.extend_from_slice(&[0; 8][..padding]);
    }

    /// Writes a text.
    pub fn string(&mut self, text: &str) {
        (text.len() as u32 + 1).put(self);
        self.0.extend_from_slice(text.as_bytes());
        self.0.push(0);
    }

    /// As many bytes, or entries of another list, as will be [added](Self::raw).
    pub fn byte_count(&mut self, count: usize) {
        (count as u32).put(self);
    }

    /// Bytes as they are.
    pub fn raw(&mut self, bytes: &[u8]) {
        self.0.extend_from_slice(bytes);
    }

    /// A list of rows of so many items.
    pub fn rows<T: Cdr>(&mut self, items: &[T], columns: usize) {
        self.byte_count(items.len() / columns);
        items.iter().for_each(|item| item.put(self));
    }
}

/// Reads a message.
pub struct Decoder<'a> {
    /// What is behind the head.
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Decoder<'a> {
    /// Begins with a message.
    ///
    /// # Errors
    /// It is not little-endian CDR.
    pub fn new(message: &'a [u8]) -> Result<Self, CdrError> {
        // Some writers put the count of padding bytes at the end into the options.
        match message {
            [0, 1, _, _, bytes @ ..] => Ok(Self { bytes, at: 0 }),
            _ => Err(CdrError::Head),
        }
    }

    pub(crate) fn raw(&mut self, count: usize) -> Result<&'a [u8], CdrError> {
        let rest = self.bytes.get(self.at..).ok_or(CdrError::Short)?;
        let taken = rest.get(..count).ok_or(CdrError::Short)?;
        self.at += count;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], CdrError> {
        self.at = self.at.next_multiple_of(N);
        let mut array = [0; N];
        array.copy_from_slice(self.raw(N)?);
        Ok(array)
    }

    /// Reads a value.
    ///
    /// # Errors
    /// As [`Cdr::get`].
    pub fn value<T: Cdr + Default>(&mut self) -> Result<T, CdrError> {
        let mut value = T::default();
        value.get(self)?;
        Ok(value)
    }

    /// Reads a text.
    ///
    /// # Errors
    /// It is cut off, or not UTF-8.
    pub fn string(&mut self) -> Result<&'a str, CdrError> {
        let count: u32 = self.value()?;
        let text = self.raw(count as usize)?;
        // Some writers leave the zero of an empty text out.
        let text = text.strip_suffix(&[0]).unwrap_or(text);
        str::from_utf8(text).map_err(|_| CdrError::Text)
    }

    /// Reads a list of bytes.
    ///
    /// # Errors
    /// It is cut off.
    pub fn bytes(&mut self) -> Result<&'a [u8], CdrError> {
        let count: u32 = self.value()?;
        self.raw(count as usize)
    }

    /// Reads how long a list is, of which there may be so many entries.
    pub(crate) fn length(&mut self, most: usize) -> Result<usize, CdrError> {
        let count: u32 = self.value()?;
        let most = most as u32;
        if count > most {
            return Err(CdrError::TooMany { count, most });
        }
        Ok(count as usize)
    }

    /// Reads a list of rows of so many items into the beginning of `items`; says how many rows came.
    pub(crate) fn rows<T: Cdr>(
        &mut self,
        items: &mut [T],
        columns: usize,
    ) -> Result<u32, CdrError> {
        let count = self.length(items.len() / columns)?;
        for item in &mut items[..count * columns] {
            item.get(self)?;
        }
        Ok(count as u32)
    }
}

macro_rules! number {
    ($($type:ty),*) => {$(
        impl Cdr for $type {
            fn put(&self, to: &mut Encoder) {
                to.align(size_of::<Self>());
                to.raw(&self.to_le_bytes());
            }

            fn get(&mut self, from: &mut Decoder) -> Result<(), CdrError> {
                *self = Self::from_le_bytes(from.array()?);
                Ok(())
            }
        }
    )*};
}
number!(u8, i32, u32, u64, f32, f64);

/// A fixed number of values, or the fields of a small message of one type.
impl<T: Cdr, const N: usize> Cdr for [T; N] {
    fn put(&self, to: &mut Encoder) {
        self.iter().for_each(|value| value.put(to));
    }

    fn get(&mut self, from: &mut Decoder) -> Result<(), CdrError> {
        self.iter_mut().try_for_each(|value| value.get(from))
    }
}

/// A message that is no more than its fields, in this order.
macro_rules! fields {
    ($type:ty { $($field:ident),* $(,)? }) => {
        impl Cdr for $type {
            fn put(&self, to: &mut Encoder) {
                $(self.$field.put(to);)*
            }

            fn get(&mut self, from: &mut Decoder) -> Result<(), CdrError> {
                $(self.$field.get(from)?;)*
                Ok(())
            }
        }
    };
}
pub(crate) use fields;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_aligned_to_their_size_from_behind_the_head() {
        let mut bytes = vec![9; 3];
        let mut to = Encoder::new(&mut bytes);
        1_u8.put(&mut to);
        2.0_f64.put(&mut to);
        3_u32.put(&mut to);
        to.string("ab");
        to.rows(&[7_u64], 1);
        let mut expected = vec![0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0];
        expected.extend(2.0_f64.to_le_bytes());
        expected.extend([3, 0, 0, 0, 3, 0, 0, 0, b'a', b'b', 0, 0, 1, 0, 0, 0]);
        expected.extend(7_u64.to_le_bytes());
        assert_eq!(bytes, expected);

        let mut from = Decoder::new(&bytes).unwrap();
        assert_eq!(from.value::<u8>(), Ok(1));
        assert_eq!(from.value::<f64>(), Ok(2.0));
        assert_eq!(from.value::<u32>(), Ok(3));
        assert_eq!(from.string(), Ok("ab"));
        let mut items = [0_u64; 2];
        assert_eq!(from.rows(&mut items, 1), Ok(1));
        assert_eq!(items, [7, 0]);
        assert_eq!(from.value::<u8>(), Err(CdrError::Short));
    }

    #[test]
    fn lengths_that_cannot_be_are_refused() {
        assert_eq!(Decoder::new(&[0, 0, 0, 0]).err(), Some(CdrError::Head));
        assert_eq!(Decoder::new(&[0, 1]).err(), Some(CdrError::Head));
        let huge = [0, 1, 0, 0, 0xff, 0xff, 0xff, 0xff, 1];
        let bytes = Decoder::new(&huge).unwrap().bytes();
        assert_eq!(bytes, Err(CdrError::Short));
        let text = Decoder::new(&huge).unwrap().string();
        assert_eq!(text, Err(CdrError::Short));
        let list = Decoder::new(&huge).unwrap().rows(&mut [0_u8; 3], 1);
        let count = u32::MAX;
        assert_eq!(list, Err(CdrError::TooMany { count, most: 3 }));
    }
}
