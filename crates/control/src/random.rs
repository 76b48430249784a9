//! Numbers by chance for the tests, the same on every machine: splitmix64.

use crate::{Coordinates, Features, MAX_FEATURES};

pub(crate) struct Random(pub(crate) u64);

impl Random {
    /// From 0 to 1.
    pub(crate) fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// From −1 to 1.
    pub(crate) fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    /// Normal, of variance 1, near enough: the sum of twelve.
    pub(crate) fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.unit()).sum::<f64>() - 6.0
    }

    pub(crate) fn coordinates(&mut self) -> Coordinates {
        std::array::from_fn(|_| self.signed())
    }

    /// The first `size` from −1 to 1.
    pub(crate) fn features(&mut self, size: usize) -> Features {
        let mut features = [0.0; MAX_FEATURES];
        features[..size].iter_mut().for_each(|f| *f = self.signed());
        features
    }
}
