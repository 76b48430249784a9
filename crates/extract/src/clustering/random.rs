//! Random numbers that are the same everywhere, from a seed: splitmix64 (G. Steele, D. Lea and C. Flood, Fast Splittable
//! Pseudorandom Number Generators, 2014).

/// The generator; any seed is as good as any other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Random {
    state: u64,
}

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self { state: seed }
    }

    /// All 64 bits.
    #[inline]
    pub(crate) fn next_u64(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// From 0 to below 1, in steps of 2⁻²⁴.
    #[inline]
    pub(crate) fn unit_f32(&mut self) -> f32 {
        (self.next_u64() >> 40) as f32 * (1.0 / (1u32 << 24) as f32)
    }

    /// A number below `count`; 0 when that is 0. The share of each is off by `count`/2⁶⁴ at most.
    #[inline]
    pub(crate) fn below(&mut self, count: usize) -> usize {
        ((u128::from(self.next_u64()) * count as u128) >> 64) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_numbers_are_those_of_the_reference() {
        // From S. Vigna's splitmix64.c with the state 1234567.
        let mut random = Random::new(1_234_567);
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
        let mut random = Random::new(1);
        let mut counts = [[0i32; 10]; 2];
        for _ in 0..100_000 {
            counts[0][random.below(10)] += 1;
            counts[1][(10.0 * random.unit_f32()) as usize] += 1;
        }
        // Five times the standard deviation of 95 each.
        assert!(
            counts.iter().flatten().all(|c| (c - 10_000).abs() < 475),
            "{counts:?}"
        );
        assert_eq!(random.below(0), 0);
    }
}
