//! Saves the state of a sink as bytes, so that another sink can continue.
//!
//! ```text
//! kind      4 bytes    "LTLY": a tally; "LCNT": its counts only
//! version   1 byte
//! body                 one part after the other, in each part's own encoding
//! check     4 bytes    CRC-32 of all preceding bytes, little-endian
//! ```
//!
//! Integers are LEB128: seven bits per byte, lowest first. Floating-point numbers are eight bytes,
//! little-endian. A histogram is stored as its nonempty buckets. Incomplete bytes are refused. All
//! values are checked against their valid ranges, so no input makes a sink panic. No number from
//! the input determines the size of an allocation.

use thiserror::Error;

/// Version of the format. Other versions are not read, because a sink's successor comes from the
/// same executable.
const VERSION: u8 = 3;

/// Limit that no stage's counter reaches: a thousand frames per second for eight thousand years.
pub(crate) const LARGEST_COUNT: u64 = 1 << 48;

/// Kind of the saved data.
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

/// Reason why a sink cannot continue where another stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum RestoreError {
    /// The bytes were not saved by a sink.
    #[error("these bytes are not what a sink has saved: begin a new tally")]
    OfAnother,
    /// The bytes were saved by another release.
    #[error(
        "a sink of another release has saved this, in version {found} of the format: use the same release for all stages, or \
         begin a new tally"
    )]
    Version {
        /// Version of the format that was found.
        found: u8,
    },
    /// The bytes are damaged.
    #[error("what the sink had saved is damaged: begin a new tally")]
    Damaged,
}

/// Appends the output of `body` to a buffer. Allocates only if the buffer grows.
pub(crate) fn save(kind: Kind, into: &mut Vec<u8>, body: impl FnOnce(&mut Saving)) {
    let start = into.len();
    into.extend(kind.mark());
    into.push(VERSION);
    body(&mut Saving(into));
    let check = crc32fast::hash(&into[start..]);
    into.extend(check.to_le_bytes());
}

/// Returns the body of the saved bytes.
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

    /// Writes numbers that may be unknown.
    pub(crate) fn optional<const N: usize>(&mut self, numbers: Option<[u64; N]>) {
        self.number(numbers.is_some().into());
        self.numbers(numbers.into_iter().flatten());
    }
}

/// A body that is being read.
pub(crate) struct Saved<'a>(&'a [u8]);

impl Saved<'_> {
    /// Reads any number.
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

    /// Reads a count that will increase further.
    pub(crate) fn count(&mut self) -> Result<u64, RestoreError> {
        sound(self.number()?, |&count| count <= LARGEST_COUNT)
    }

    /// Reads a finite number that is not negative.
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

    /// Checks that all bytes have been read.
    pub(crate) fn end(self) -> Result<(), RestoreError> {
        sound(self.0, |rest| rest.is_empty()).map(drop)
    }
}

/// Returns a value that was read, if it is valid.
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
