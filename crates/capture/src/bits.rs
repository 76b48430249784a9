//! Samples of fewer than 16 bits, stored in 16-bit words.
//!
//! Cameras with 10 or 12 bits store each sample in the low bits of a 16-bit word. No file format
//! records that. The number of bits is inferred from the largest sample of the first picture, and
//! reported.

/// Number of bits in a source's samples.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Bits {
    /// 0 until a nonzero sample has been seen.
    count: u32,
}

/// Recognized numbers of low bits. 14 is missing, because the samples of an underexposed picture in
/// full range may all fit into 14 bits.
const NARROW: [u32; 3] = [8, 10, 12];
const ALL: u32 = 16;

impl Bits {
    /// Takes note of the largest sample of a picture. Returns a sentence if that changes the number
    /// of bits.
    pub(crate) fn see(&mut self, largest: u16) -> Option<String> {
        let fits = |bits: &u32| u32::from(largest) < 1 << bits;
        let count = NARROW.into_iter().find(fits).unwrap_or(ALL);
        if largest == 0 || count <= self.count {
            return None;
        }
        let before = std::mem::replace(&mut self.count, count);
        match (before, count) {
            (0, ALL) => None,
            (_, ALL) => Some(format!(
                "the largest of the 16-bit samples is {largest} now: from here on they count as 16 bits"
            )),
            _ => Some(format!(
                "the largest of the 16-bit samples is {largest}: they count as {count} bits, so that {} is white",
                (1 << count) - 1
            )),
        }
    }

    /// Scales a sample to 16 bits, where white is 65535.
    pub(crate) fn widen(self, sample: u16) -> u16 {
        let count = if self.count == 0 { ALL } else { self.count };
        let white = (1u32 << count) - 1;
        // No overflow: both factors are less than 2¹⁶.
        ((u32::from(sample).min(white) * 65535 + white / 2) / white) as u16
    }

    /// Widens native-endian 16-bit samples in place.
    pub(crate) fn widen_all(self, bytes: &mut [u8]) {
        if matches!(self.count, 0 | ALL) {
            return;
        }
        for pair in bytes.as_chunks_mut::<2>().0 {
            *pair = self.widen(u16::from_ne_bytes(*pair)).to_ne_bytes();
        }
    }
}

/// Returns the largest of native-endian 16-bit samples.
pub(crate) fn largest(bytes: &[u8]) -> u16 {
    let samples = bytes.as_chunks::<2>().0.iter();
    samples
        .map(|&pair| u16::from_ne_bytes(pair))
        .max()
        .unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_sample_tells_the_bits() {
        for (largest, bits) in [
            (255, 8),
            (256, 10),
            (1020, 10),
            (1024, 12),
            (4080, 12),
            (4096, 16),
            (65535, 16),
        ] {
            let mut seen = Bits::default();
            let said = seen.see(largest);
            assert_eq!(seen.count, bits, "{largest}");
            assert_eq!(said.is_some(), bits < 16, "{largest}");
            assert_eq!(seen.widen(0), 0);
            assert_eq!(seen.widen(((1u32 << bits) - 1) as u16), 65535);
        }
    }

    #[test]
    fn a_black_picture_tells_nothing_and_a_brighter_one_is_believed() {
        let mut seen = Bits::default();
        assert_eq!(seen.see(0), None);
        assert!(seen.see(1000).is_some());
        assert_eq!(seen.see(30), None);
        assert_eq!(seen.count, 10);
        assert!(
            seen.see(60_000)
                .is_some_and(|said| said.contains("16 bits"))
        );
        assert_eq!(seen.widen(60_000), 60_000);
    }
}
