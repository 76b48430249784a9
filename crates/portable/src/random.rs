//! Random numbers from a seed.

/// SplitMix64: a hash of a counter, for which all seeds are equally good (G. Steele, D. Lea and C.
/// Flood, Fast Splittable Pseudorandom Number Generators, 2014).
#[derive(Clone, Copy, Debug)]
pub struct SplitMix64(u64);

impl SplitMix64 {
    /// Creates the generator of a seed.
    pub const fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Creates the generator of a seed and a stream. Generators of different streams are
    /// independent.
    pub fn of_stream(seed: u64, stream: u64) -> Self {
        Self(Self(seed).next_u64() ^ Self(stream.wrapping_mul(0xA076_1D64_78BD_642F)).next_u64())
    }

    /// Returns all 64 bits.
    #[inline]
    pub fn next_u64(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Returns a number from 0 to below 1, in steps of 2⁻⁵³, which are exact.
    #[inline]
    pub fn unit(&mut self) -> f64 {
        (self.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Returns a number from 0 to below 1, in steps of 2⁻²⁴.
    #[inline]
    pub fn unit_f32(&mut self) -> f32 {
        (self.next_u64() >> 40) as f32 / (1u32 << 24) as f32
    }

    /// Returns a number from `low` to below `high`.
    #[inline]
    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Returns a number from `low` to below `high`.
    #[inline]
    pub fn uniform_f32(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit_f32()
    }

    /// Returns a number below `count`, or 0 if `count` is 0. The probability of each is off by at
    /// most `count`/2⁶⁴.
    #[inline]
    pub fn below(&mut self, count: usize) -> usize {
        ((u128::from(self.next_u64()) * count as u128) >> 64) as usize
    }

    /// Returns −1 or 1.
    #[inline]
    pub fn sign(&mut self) -> f64 {
        if self.next_u64() & 1 == 0 { -1.0 } else { 1.0 }
    }

    /// Returns a normal number of mean 0 and variance 1 (G. E. P. Box and M. E. Muller, A Note on
    /// the Generation of Random Normal Deviates, 1958).
    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * libm::log(1.0 - self.unit())).sqrt();
        radius * libm::cos(std::f64::consts::TAU * self.unit())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_numbers_are_those_of_the_reference() {
        // From S. Vigna's splitmix64.c with the state 1234567.
        let mut random = SplitMix64::new(1_234_567);
        let expected = [
            6_457_827_717_110_365_317,
            3_203_168_211_198_807_973,
            9_817_491_932_198_370_423,
        ];
        for number in expected {
            assert_eq!(random.next_u64(), number);
        }
    }

    #[test]
    fn all_parts_of_a_range_are_met_equally_often() {
        let mut random = SplitMix64::new(1);
        let mut counts = [[0i32; 10]; 3];
        for _ in 0..100_000 {
            counts[0][random.below(10)] += 1;
            counts[1][(10.0 * random.unit_f32()) as usize] += 1;
            counts[2][random.uniform(0.0, 10.0) as usize] += 1;
        }
        // Five times the standard deviation of each count, which is 95.
        assert!(
            counts.iter().flatten().all(|c| (c - 10_000).abs() < 475),
            "{counts:?}"
        );
        assert_eq!(random.below(0), 0);
    }

    #[test]
    fn normal_numbers_have_mean_zero_and_variance_one() {
        let mut random = SplitMix64::new(3);
        let drawn: Vec<f64> = (0..20_000).map(|_| random.normal()).collect();
        let mean = drawn.iter().sum::<f64>() / 2e4;
        let variance = drawn.iter().map(|x| x * x).sum::<f64>() / 2e4;
        // Four standard deviations of each estimate.
        assert!(mean.abs() < 4.0 / 2e4f64.sqrt(), "{mean}");
        assert!(
            (variance - 1.0).abs() < 4.0 * (2.0 / 2e4f64).sqrt(),
            "{variance}"
        );
    }

    #[test]
    fn streams_of_one_seed_differ() {
        let first = |stream| SplitMix64::of_stream(1, stream).next_u64();
        assert_ne!(first(0), first(1));
        assert_eq!(first(1), first(1));
    }
}
