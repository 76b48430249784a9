//! FNV-1a (G. Fowler, L. C. Noll, K.-P. Vo) over the bits of numbers.

pub(crate) struct Hash(u64);

impl Hash {
    pub(crate) fn new() -> Self {
        Self(0xCBF2_9CE4_8422_2325)
    }

    pub(crate) fn bytes(mut self, bytes: &[u8]) -> Self {
        for &byte in bytes {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01B3);
        }
        self
    }

    pub(crate) fn floats<'a>(self, floats: impl IntoIterator<Item = &'a f32>) -> Self {
        let of = |hash: Self, x: &f32| hash.bytes(&x.to_bits().to_le_bytes());
        floats.into_iter().fold(self, of)
    }

    pub(crate) fn doubles<'a>(self, doubles: impl IntoIterator<Item = &'a f64>) -> Self {
        let of = |hash: Self, x: &f64| hash.bytes(&x.to_bits().to_le_bytes());
        doubles.into_iter().fold(self, of)
    }

    /// Both halves combined.
    pub(crate) fn value(&self) -> u32 {
        (self.0 ^ (self.0 >> 32)) as u32
    }
}
