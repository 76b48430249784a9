//! Medians and quantiles, for estimates that outliers must not distort.

use lariat_portable::Simd;

use crate::image::ray::{LANES, Lanes};

/// The middle value; the upper of the two for an even count, 0 for an empty slice.
pub(crate) fn median(values: &mut [f32]) -> f32 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f32::total_cmp).1
}

/// The value with the share `q` of all values below it; 0 for an empty slice.
pub(crate) fn quantile(values: &mut [f32], q: f32) -> f32 {
    if values.is_empty() {
        return 0.0;
    }
    let index = ((values.len() - 1) as f32 * q) as usize;
    *values.select_nth_unstable_by(index, f32::total_cmp).1
}

/// Like [`quantile`], for positive numbers: their bits have the same order and compare faster.
pub(crate) fn quantile_of_positive(values: &mut [f32], q: f32) -> f32 {
    let index = (values.len().saturating_sub(1) as f32 * q) as usize;
    of_positive(values, index)
}

/// Like [`median`], for positive numbers.
pub(crate) fn median_of_positive(values: &mut [f32]) -> f32 {
    of_positive(values, values.len() / 2)
}

fn of_positive(values: &mut [f32], index: usize) -> f32 {
    if values.is_empty() {
        return 0.0;
    }
    *values.select_nth_unstable_by_key(index, |v| v.to_bits()).1
}

/// Median of each lane's `counts` smallest numbers, the upper of the two middle ones.
#[inline(always)]
pub(crate) fn medians<S: Simd>(simd: S, rows: &mut [Lanes], counts: &[u32; LANES]) -> Lanes {
    let half = rows.len() / 2;
    // Sorts the smaller half, one row per pass.
    for k in 0..=half {
        let (sorted, rest) = rows.split_at_mut(k + 1);
        let least = S::as_mut_simd_f32s(&mut sorted[k]).0;
        for row in rest {
            let row = S::as_mut_simd_f32s(row).0;
            for (a, b) in least.iter_mut().zip(row) {
                (*a, *b) = (simd.min_f32s(*a, *b), simd.max_f32s(*a, *b));
            }
        }
    }
    std::array::from_fn(|l| rows[counts[l] as usize / 2][l])
}

/// Position of a value between `from` (0) and `to` (1), clamped to that range.
pub(crate) fn grade(value: f32, from: f32, to: f32) -> f32 {
    ((value - from) / (to - from)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    struct Finding<'a>(&'a mut [Lanes], &'a [u32; LANES]);

    impl lariat_portable::WithSimd for Finding<'_> {
        type Output = Lanes;

        fn with_simd<S: Simd>(self, simd: S) -> Lanes {
            medians(simd, self.0, self.1)
        }
    }

    proptest! {
        #[test]
        fn a_median_is_that_of_the_sorted_numbers(lanes in proptest::collection::vec(proptest::collection::vec(0u8..9, 0..=13), LANES)) {
            let (mut rows, mut counts) = ([[f32::INFINITY; LANES]; 13], [0; LANES]);
            for (l, lane) in lanes.iter().enumerate() {
                counts[l] = lane.len() as u32;
                for (k, &value) in lane.iter().enumerate() {
                    rows[(5 * k + l) % 13][l] = f32::from(value);
                }
            }
            let found = lariat_portable::Arch::new().dispatch(Finding(&mut rows, &counts));
            for (mut lane, found) in lanes.into_iter().zip(found).filter(|(lane, _)| !lane.is_empty()) {
                lane.sort_unstable();
                prop_assert_eq!(found, f32::from(lane[lane.len() / 2]));
            }
        }
    }
}
