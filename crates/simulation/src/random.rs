//! A small random generator, for what a seed varies.

/// SplitMix64 (Steele, Lea, Flood 2014): a hash of a counter.
pub(crate) struct SplitMix64(u64);

impl SplitMix64 {
    /// The generator of a seed and of a stream: generators of different streams have nothing in common.
    pub(crate) fn new(seed: u64, stream: u64) -> Self {
        Self(Self(seed).next_u64() ^ Self(stream.wrapping_mul(0xA076_1D64_78BD_642F)).next_u64())
    }

    fn next_u64(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Uniform in [low, high).
    pub(crate) fn uniform(&mut self, low: f64, high: f64) -> f64 {
        // 53 bits: every value is a multiple of 2⁻⁵³, exact.
        let unit = (self.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
        low + (high - low) * unit
    }
}
