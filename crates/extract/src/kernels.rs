//! The loops over all pixels that a compiler does not make fast by itself: written for AVX-512 and AVX2, chosen when the
//! program runs, and as the plain loops that define what they do.

#[cfg(target_arch = "x86_64")]
mod x86;
#[cfg(target_arch = "x86_64")]
pub(crate) use x86::orders;

/// The kernels for this machine.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kernels {
    /// `difference` of three interleaved channels: a row, the table along it (as long or longer), and a byte a pixel.
    pub(crate) three_channels: fn(&[u8], &[u8], &mut [u8]),
    /// One bit a byte, whether it is `≥ cut`, 64 to a word; returns the sum of the bytes.
    pub(crate) at_least: fn(&[u8], u8, &mut [u64]) -> u64,
}

impl Kernels {
    /// The fastest that this machine can run.
    pub(crate) fn detect() -> Self {
        #[cfg(target_arch = "x86_64")]
        if let Some(kernels) = x86::detect() {
            return kernels;
        }
        Self {
            three_channels: |row, table, out| {
                pulp::Arch::new().dispatch(|| three_channels(row, table, out));
            },
            at_least: |row, cut, words| pulp::Arch::new().dispatch(|| at_least(row, cut, words)),
        }
    }
}

impl Default for Kernels {
    fn default() -> Self {
        Self::detect()
    }
}

#[inline(always)]
fn three_channels(row: &[u8], table: &[u8], out: &mut [u8]) {
    for ((d, p), t) in out
        .iter_mut()
        .zip(row.chunks_exact(3))
        .zip(table.chunks_exact(3))
    {
        *d = p[0]
            .abs_diff(t[0])
            .max(p[1].abs_diff(t[1]))
            .max(p[2].abs_diff(t[2]));
    }
}

/// Eight comparisons at a time become eight bits by one multiplication.
#[inline(always)]
fn at_least(row: &[u8], cut: u8, words: &mut [u64]) -> u64 {
    let mut sum = 0;
    for (word, pixels) in words.iter_mut().zip(row.chunks(64)) {
        let mut ones = [0u8; 64];
        for (one, &pixel) in ones.iter_mut().zip(pixels) {
            *one = u8::from(pixel >= cut);
        }
        sum += pixels.iter().map(|&p| u64::from(p)).sum::<u64>();
        *word = 0;
        for (i, eight) in ones.chunks_exact(8).enumerate() {
            let mut bytes = [0; 8];
            bytes.copy_from_slice(eight);
            let bits = u64::from_le_bytes(bytes).wrapping_mul(0x0102_0408_1020_4080) >> 56;
            *word |= bits << (8 * i);
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// All that this machine can run.
    fn all() -> Vec<Kernels> {
        let mut all = vec![Kernels::detect()];
        #[cfg(target_arch = "x86_64")]
        all.extend(x86::all());
        all
    }

    fn bytes() -> impl Strategy<Value = Vec<u8>> {
        prop_oneof![
            prop::collection::vec(any::<u8>(), 0..700),
            (0..700usize, any::<u8>()).prop_map(|(length, byte)| vec![byte; length]),
        ]
    }

    proptest! {
        #[test]
        fn a_row_of_three_channels_differs_as_the_plain_loop_says(row in bytes(), table in bytes()) {
            let pixels = row.len().min(table.len()) / 3;
            let mut expected = vec![0; pixels];
            three_channels(&row, &table, &mut expected);
            for kernels in all() {
                let mut found = vec![0; pixels];
                (kernels.three_channels)(&row, &table, &mut found);
                prop_assert_eq!(&found, &expected);
            }
        }

        #[test]
        fn bytes_are_cut_and_summed_as_the_plain_loop_says(row in bytes(), cut: u8) {
            let mut expected = vec![7; row.len().div_ceil(64)];
            let sum = at_least(&row, cut, &mut expected);
            for kernels in all() {
                let mut found = vec![9; expected.len()];
                prop_assert_eq!((kernels.at_least)(&row, cut, &mut found), sum);
                prop_assert_eq!(&found, &expected);
            }
        }
    }
}
