//! How often values occur, and the middle one of them.

/// Counts are kept this many times, so that equal neighbors do not wait for each other's.
const PARTS: usize = 4;

/// How often each of `N` values occurs.
pub(super) struct Counts<const N: usize>([[u16; N]; PARTS]);

impl<const N: usize> Default for Counts<N> {
    fn default() -> Self {
        Self([[0; N]; PARTS])
    }
}

impl<const N: usize> Counts<N> {
    /// Counts the `i`-th value.
    #[inline(always)]
    pub(super) fn add(&mut self, i: usize, value: usize) {
        self.0[i % PARTS][value % N] += 1;
    }

    /// The middle value (of an even number the upper one).
    pub(super) fn middle(&self) -> usize {
        let count = |value: usize| {
            self.0
                .iter()
                .map(|part| u32::from(part[value]))
                .sum::<u32>()
        };
        let all: u32 = self.0.as_flattened().iter().map(|&n| u32::from(n)).sum();
        let mut below = 0;
        let passes = |&value: &usize| {
            below += count(value);
            below > all / 2
        };
        (0..N).find(passes).unwrap_or(0)
    }
}
