//! What a sink knows, as bytes: so that another goes on where it stopped.
//!
//! ```text
//! kind      4 bytes    "LTLY": a tally; "LCNT": its counts only
//! version   1 byte
//! body                 one part after the other, as each writes itself
//! check     4 bytes    CRC-32 of all before, little-endian
//! ```
//!
//! Whole numbers are LEB128, seven bits a byte, the lowest first; floating-point numbers eight bytes, little-endian; of a
//! histogram stand the buckets that are not empty. Bytes that are not whole are refused; what is read is held to what can be,
//! so that no bytes whatever make a sink that panics, and nothing is allocated by a number that was read.

use thiserror::Error;

/// The version of what is written. Another one is not read: a sink is followed by one of the same executable.
const VERSION: u8 = 3;

/// What no stage counts to: a thousand frames a second for eight thousand years.
pub(crate) const LARGEST_COUNT: u64 = 1 << 48;

/// What is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Tally,
    Counts,
}

impl Kind {
    fn mark(self) -> [u8; 4] {
        match self {
            Self::Tally => *b"LTLY",
            Self::Counts => *b"LCNT",
        }
    }
}

/// Why a sink cannot go on where another stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum RestoreError {
    /// It was written by something else.
    #[error("these bytes are not what a sink has saved: begin a new tally")]
    OfAnother,
    /// It was written by another release.
    #[error(
        "a sink of another release has saved this, in version {found} of the format: use the same release for all stages, or \
         begin a new tally"
    )]
    Version {
        /// The format that was found.
        found: u8,
    },
    /// It is not as it was written.
    #[error("what the sink had saved is damaged: begin a new tally")]
    Damaged,
}

/// Writes what `body` says behind what is in a buffer. Allocates only where that grows.
pub(crate) fn save(kind: Kind, into: &mut Vec<u8>, body: impl FnOnce(&mut Saving)) {
    let start = into.len();
    into.extend(kind.mark());
    into.push(VERSION);
    body(&mut Saving(into));
    let check = crc32fast::hash(&into[start..]);
    into.extend(check.to_le_bytes());
}

/// The body of what was saved.
pub(crate) fn open(kind: Kind, bytes: &[u8]) -> Result<Saved<'_>, RestoreError> {
    let Some((&version, rest)) = bytes
        .strip_prefix(&kind.mark())
        .and_then(<[u8]>::split_first)
    else {
        return Err(RestoreError::OfAnother);
    };
    if version != VERSION {
        return Err(RestoreError::Version { found: version });
    }
    let (body, check) = rest.split_last_chunk().ok_or(RestoreError::Damaged)?;
    let whole = &bytes[..bytes.len() - check.len()];
    if crc32fast::hash(whole) != u32::from_le_bytes(*check) {
        return Err(RestoreError::Damaged);
    }
    Ok(Saved(body))
}

/// A body that is being written.
pub(crate) struct Saving<'a>(&'a mut Vec<u8>);

impl Saving<'_> {
    pub(crate) fn number(&mut self, mut number: u64) {
        while number >= 0x80 {
            self.0.push(number as u8 | 0x80);
            number >>= 7;
        }
        self.0.push(number as u8);
    }

    pub(crate) fn numbers(&mut self, numbers: impl IntoIterator<Item = u64>) {
        numbers.into_iter().for_each(|number| self.number(number));
    }

    pub(crate) fn real(&mut self, number: f64) {
        self.0.extend(number.to_bits().to_le_bytes());
    }

    /// Numbers that may not be known.
    pub(crate) fn optional<const N: usize>(&mut self, numbers: Option<[u64; N]>) {
        self.number(numbers.is_some().into());
        self.numbers(numbers.into_iter().flatten());
    }
}

/// A body that is being read.
pub(crate) struct Saved<'a>(&'a [u8]);

impl Saved<'_> {
    /// Any number.
    pub(crate) fn number(&mut self) -> Result<u64, RestoreError> {
        let mut number = 0;
        for shift in (0..64).step_by(7) {
            let (&byte, rest) = self.0.split_first().ok_or(RestoreError::Damaged)?;
            self.0 = rest;
            let bits = u64::from(byte & 0x7f);
            if shift == 63 && bits > 1 {
                return Err(RestoreError::Damaged);
            }
            number |= bits << shift;
            if byte < 0x80 {
                return Ok(number);
            }
        }
        Err(RestoreError::Damaged)
    }

    pub(crate) fn numbers<const N: usize>(&mut self) -> Result<[u64; N], RestoreError> {
        let mut numbers = [0; N];
        for number in &mut numbers {
            *number = self.number()?;
        }
        Ok(numbers)
    }

    /// How many of something there were, to which more will be added.
    pub(crate) fn count(&mut self) -> Result<u64, RestoreError> {
        sound(self.number()?, |&count| count <= LARGEST_COUNT)
    }

    /// A finite number, of what is never negative.
    pub(crate) fn real(&mut self) -> Result<f64, RestoreError> {
        let (bits, rest) = self.0.split_first_chunk().ok_or(RestoreError::Damaged)?;
        self.0 = rest;
        let number = f64::from_bits(u64::from_le_bytes(*bits));
        sound(number, |number| number.is_finite() && *number >= 0.0)
    }

    pub(crate) fn flag(&mut self) -> Result<bool, RestoreError> {
        Ok(sound(self.number()?, |&flag| flag <= 1)? == 1)
    }

    pub(crate) fn optional<const N: usize>(&mut self) -> Result<Option<[u64; N]>, RestoreError> {
        self.flag()?.then(|| self.numbers()).transpose()
    }

    /// Nothing more is there.
    pub(crate) fn end(self) -> Result<(), RestoreError> {
        sound(self.0, |rest| rest.is_empty()).map(drop)
    }
}

/// What was read, if it can be.
pub(crate) fn sound<T>(value: T, can_be: impl FnOnce(&T) -> bool) -> Result<T, RestoreError> {
    if can_be(&value) {
        Ok(value)
    } else {
        Err(RestoreError::Damaged)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_number_comes_back(numbers: [u64; 5], real in 0.0f64..1e300, known: Option<[u64; 2]>) {
            let mut bytes = Vec::new();
            save(Kind::Counts, &mut bytes, |to| {
                to.numbers(numbers);
                to.real(real);
                to.optional(known);
            });
            let mut saved = open(Kind::Counts, &bytes).expect("whole");
            prop_assert_eq!(saved.numbers(), Ok(numbers));
            prop_assert_eq!(saved.real(), Ok(real));
            prop_assert_eq!(saved.optional(), Ok(known));
            prop_assert_eq!(saved.end(), Ok(()));
        }
    }

    #[test]
    fn a_number_of_more_than_64_bits_is_damage() {
        let long = [0xff; 10];
        assert_eq!(Saved(&long).number(), Err(RestoreError::Damaged));
        assert_eq!(Saved(&[0x80]).number(), Err(RestoreError::Damaged));
        let most = [[0xff; 9].as_slice(), &[1]].concat();
        assert_eq!(Saved(&most).number(), Ok(u64::MAX));
    }
}
