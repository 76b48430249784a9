//! The floor of an extraction: a pass that only reads the frame.

use pulp::{Arch, Simd, WithSimd, bytemuck};

/// Number of parallel running sums: more than the loads that a core has in flight at a time.
const SUMS: usize = 8;

/// Sums all bytes of a frame with the widest loads of the machine, eight bytes per lane. No
/// extraction that examines every pixel can be faster.
#[derive(Debug, Clone, Copy)]
pub struct ReadPass {
    arch: Arch,
}

impl Default for ReadPass {
    fn default() -> Self {
        Self { arch: Arch::new() }
    }
}

impl ReadPass {
    /// Returns the wrapping sum of the eight-byte words of `bytes` and of the unaligned bytes
    /// before and after them.
    pub fn sum(&self, bytes: &[u8]) -> u64 {
        self.arch.dispatch(Sum { bytes })
    }
}

struct Sum<'a> {
    bytes: &'a [u8],
}

impl WithSimd for Sum<'_> {
    type Output = u64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> u64 {
        let (before, words, after) = bytemuck::pod_align_to::<u8, u64>(self.bytes);
        let (vectors, rest) = S::as_simd_u64s(words);
        let (groups, single) = pulp::as_arrays::<SUMS, _>(vectors);
        let mut sums = [simd.splat_u64s(0); SUMS];
        for group in groups {
            for (sum, &vector) in sums.iter_mut().zip(group) {
                *sum = simd.add_u64s(*sum, vector);
            }
        }
        for &vector in single {
            sums[0] = simd.add_u64s(sums[0], vector);
        }
        let lanes: &[u64] = bytemuck::cast_slice(&sums);
        let edges = before.iter().chain(after).map(|&byte| u64::from(byte));
        (lanes.iter().chain(rest).copied().chain(edges)).fold(0, u64::wrapping_add)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_counts() {
        let read = ReadPass::default();
        // Length and start are unaligned.
        let mut bytes = vec![0u8; 2051];
        for i in 1..bytes.len() {
            bytes[i] = 1;
            assert_ne!(read.sum(&bytes[1..]), 0, "byte {i}");
            bytes[i] = 0;
        }
        assert_eq!(read.sum(&bytes), 0);
        assert_eq!(read.sum(&[]), 0);
    }
}
