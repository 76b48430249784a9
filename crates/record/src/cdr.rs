//! CDR as ROS 2 uses it: values in order, each aligned to its own size, little endian, after a head
//! of four bytes.

use std::str;

/// First bytes of every message: plain CDR, little endian, and options that this encoding does not
/// use.
const HEAD: [u8; 4] = [0, 1, 0, 0];

/// Error in the bytes of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum CdrError {
    /// The bytes are not CDR, or not in this byte order.
    #[error("it does not begin as a little-endian CDR message does")]
    Head,
    /// The message is cut off.
    #[error("it is cut off")]
    Short,
    /// The bytes are not a protocol buffer.
    #[error("it is not a protocol buffer of Foxglove's schema")]
    Protobuf,
    /// The bytes are not JSON.
    #[error("it is not JSON of Foxglove's schema")]
    Json,
    /// The data is not base64.
    #[error("its data is not base64")]
    Base64,
    /// A list has more entries than the message can contain.
    #[error("it holds a list of {count} entries where at most {most} are known")]
    TooMany {
        /// The number of entries that the list claims to have.
        count: u32,
        /// The maximum number of entries.
        most: u32,
    },
    /// Lists that belong together have different lengths.
    #[error("it holds lists of different lengths that belong together")]
    Uneven,
    /// A text is not valid UTF-8.
    #[error("it holds a text that is not UTF-8")]
    Text,
}

/// A value that can be encoded and decoded.
pub trait Cdr {
    /// Appends the value.
    fn put(&self, to: &mut Encoder);
    /// Reads the next value.
    ///
    /// # Errors
    /// Fails if the message is cut off or contains an invalid value.
    fn get(&mut self, from: &mut Decoder) -> Result<(), CdrError>;
}

/// Writes a message into a buffer.
pub struct Encoder<'a>(&'a mut Vec<u8>);

impl<'a> Encoder<'a> {
    /// Starts a message in a buffer, replacing its contents.
    pub fn new(buffer: &'a mut Vec<u8>) -> Self {
        buffer.clear();
        buffer.extend(HEAD);
        Self(buffer)
    }

    /// Continues a message whose first part is already in the buffer.
    pub fn after(buffer: &'a mut Vec<u8>) -> Self {
        debug_assert!(buffer.starts_with(&HEAD));
        Self(buffer)
    }

    /// Pads to the next multiple of `size`, a power of two, counted from the end of the head.
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

    /// Writes the length of a list whose entries or bytes will be [added](Self::raw).
    pub fn byte_count(&mut self, count: usize) {
        (count as u32).put(self);
    }

    /// Appends bytes as they are.
    pub fn raw(&mut self, bytes: &[u8]) {
        self.0.extend_from_slice(bytes);
    }

    /// Writes a list of rows with `columns` items each.
    pub fn rows<T: Cdr>(&mut self, items: &[T], columns: usize) {
        self.byte_count(items.len() / columns);
        items.iter().for_each(|item| item.put(self));
    }
}

/// Reads a message.
pub struct Decoder<'a> {
    /// The bytes after the head.
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Decoder<'a> {
    /// Starts to read a message.
    ///
    /// # Errors
    /// Fails if it is not little-endian CDR.
    pub fn new(message: &'a [u8]) -> Result<Self, CdrError> {
        // Some writers store the number of padding bytes at the end in the options.
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
    /// Fails as [`Cdr::get`] does.
    pub fn value<T: Cdr + Default>(&mut self) -> Result<T, CdrError> {
        let mut value = T::default();
        value.get(self)?;
        Ok(value)
    }

    /// Reads a text.
    ///
    /// # Errors
    /// Fails if the text is cut off or not UTF-8.
    pub fn string(&mut self) -> Result<&'a str, CdrError> {
        let count: u32 = self.value()?;
        let text = self.raw(count as usize)?;
        // Some writers omit the terminating zero of an empty text.
        let text = text.strip_suffix(&[0]).unwrap_or(text);
        str::from_utf8(text).map_err(|_| CdrError::Text)
    }

    /// Reads a list of bytes.
    ///
    /// # Errors
    /// Fails if the list is cut off.
    pub fn bytes(&mut self) -> Result<&'a [u8], CdrError> {
        let count: u32 = self.value()?;
        self.raw(count as usize)
    }

    /// Reads the length of a list with at most `most` entries.
    pub(crate) fn length(&mut self, most: usize) -> Result<usize, CdrError> {
        let count: u32 = self.value()?;
        let most = most as u32;
        if count > most {
            return Err(CdrError::TooMany { count, most });
        }
        Ok(count as usize)
    }

    /// Reads a list of rows of `columns` items into the beginning of `items`. Returns the number of
    /// rows.
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

/// Implements [`Cdr`] for a message that consists of these fields in this order.
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
