//! Arithmetic whose every bit is the same on every machine: a sine made of IEEE basic operations (the platform's own
//! may differ in its last bit) and a small random generator.

/// Sine of an angle in turns, |turns| < 2⁵¹, to 2·10⁻⁹.
pub(crate) fn sin_turns(turns: f64) -> f64 {
    // To [−½, ½], then folded about ±¼ to the half wave around zero.
    let rest = turns - (turns + if turns < 0.0 { -0.5 } else { 0.5 }) as i64 as f64;
    let x = if rest > 0.25 {
        0.5 - rest
    } else if rest < -0.25 {
        -0.5 - rest
    } else {
        rest
    };
    // Taylor about 0 at |angle| ≤ π/2: the first term left out is (π/2)¹⁵ / 15! < 7·10⁻¹⁰.
    let angle = x * std::f64::consts::TAU;
    let square = angle * angle;
    let mut sum = 0.0;
    for denominator in [156.0, 110.0, 72.0, 42.0, 20.0, 6.0] {
        sum = (1.0 + sum) * (-square / denominator);
    }
    angle * (1.0 + sum)
}

/// Cosine of an angle in turns, likewise.
pub(crate) fn cos_turns(turns: f64) -> f64 {
    sin_turns(turns + 0.25)
}

/// The step 0 → 1 over x in [0, 1] with level ends: 3x² − 2x³.
pub(crate) fn smoothstep(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// SplitMix64 (Steele, Lea, Flood 2014): one multiply-xorshift hash of a counter.
#[derive(Debug, Clone)]
pub(crate) struct SplitMix64(u64);

impl SplitMix64 {
    /// The generator of a seed and of a stream: generators of different streams have nothing in common.
    pub(crate) fn new(seed: u64, stream: u64) -> Self {
        Self(Self(seed).next_u64() ^ Self(stream.wrapping_mul(0xA076_1D64_78BD_642F)).next_u64())
    }

    pub(crate) fn next_u64(&mut self) -> u64 {
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

    /// −1 or 1.
    pub(crate) fn sign(&mut self) -> f64 {
        if self.next_u64() & 1 == 0 { -1.0 } else { 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sine_is_a_sine() {
        for i in -4000..4000 {
            let turns = f64::from(i) / 1000.0 + 1e-4;
            let angle = turns * std::f64::consts::TAU;
            assert!((sin_turns(turns) - angle.sin()).abs() < 2e-9, "{turns}");
            assert!((cos_turns(turns) - angle.cos()).abs() < 2e-9, "{turns}");
        }
    }

    #[test]
    fn the_generator_gives_its_published_numbers() {
        // Seed 1234567, from the reference implementation's test vectors.
        let mut random = SplitMix64(1_234_567);
        assert_eq!(random.next_u64(), 6_457_827_717_110_365_317);
        assert_eq!(random.next_u64(), 3_203_168_211_198_807_973);
    }
}
