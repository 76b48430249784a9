//! Random numbers from a seed: the same seed gives the same report.

use lariat_portable::SplitMix64;

/// Returns the `stream`-th sequence of a seed. Sequences of neighboring seeds and streams are
/// unrelated.
pub(crate) fn of_stream(seed: u64, stream: u64) -> SplitMix64 {
    let start = SplitMix64::new(seed).next_u64();
    SplitMix64::new(start ^ stream.wrapping_mul(0xD6E8_FEB8_6659_FD93))
}

/// Returns an integer from 0 to `end` - 1. `end` must not be 0.
pub(crate) fn below(random: &mut SplitMix64, end: usize) -> usize {
    // The bias of a remainder is below end / 2⁶⁴.
    (random.next_u64() % end as u64) as usize
}

/// Shuffles `items`.
pub(crate) fn shuffle<T>(items: &mut [T], random: &mut SplitMix64) {
    for last in (1..items.len()).rev() {
        items.swap(last, below(random, last + 1));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shuffle_keeps_every_item() {
        let mut items: Vec<usize> = (0..50).collect();
        shuffle(&mut items, &mut of_stream(1, 2));
        assert_ne!(items, (0..50).collect::<Vec<_>>());
        items.sort_unstable();
        assert_eq!(items, (0..50).collect::<Vec<_>>());
    }
}
