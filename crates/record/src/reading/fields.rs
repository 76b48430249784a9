//! Fields of MCAP's records: little endian, each length before its contents. No length is trusted.

/// Reads a record's fields in order. Every method returns `None` once the bytes are exhausted.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fields<'a>(pub(super) &'a [u8]);

impl<'a> Fields<'a> {
    pub(super) fn bytes(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (taken, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*taken)
    }

    pub(super) fn u8(&mut self) -> Option<u8> {
        self.array::<1>().map(|[byte]| byte)
    }

    pub(super) fn u16(&mut self) -> Option<u16> {
        self.array().map(u16::from_le_bytes)
    }

    pub(super) fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    pub(super) fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    /// Reads bytes after a four-byte length.
    pub(super) fn short_block(&mut self) -> Option<&'a [u8]> {
        let count = self.u32()?;
        self.bytes(count as usize)
    }

    /// Reads bytes after an eight-byte length.
    pub(super) fn long_block(&mut self) -> Option<&'a [u8]> {
        let count = usize::try_from(self.u64()?).ok()?;
        self.bytes(count)
    }

    pub(super) fn text(&mut self) -> Option<&'a str> {
        std::str::from_utf8(self.short_block()?).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_length_that_is_too_long_is_none() {
        let mut fields = Fields(&[2, 0, 0, 0, b'a', b'b', 9, 0, 0, 0, b'c']);
        assert_eq!(fields.text(), Some("ab"));
        assert_eq!(fields.text(), None);
        assert_eq!(Fields(&[0xff; 8]).long_block(), None);
        assert_eq!(Fields(&[1, 2, 3]).u32(), None);
        assert_eq!(Fields(&[1, 0, 0, 0, 0xff]).text(), None);
    }
}
