//! Median of many small numbers.

use lariat_portable::{Simd, WithSimd};

/// Median of the `values` that are at most `most`. For an even number of values, it is the upper of
/// the middle two.
///
/// This is a bisection of the range of values: each pass counts the values up to the middle of the
/// range. There is one pass per bit, and it takes as many values at a time as the registers hold.
pub(super) struct Middle<'a> {
    pub(super) values: &'a [u16],
    pub(super) most: u16,
}

impl WithSimd for Middle<'_> {
    type Output = u16;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> u16 {
        let half = up_to(self.values, self.most) / 2;
        let (mut least, mut most) = (0, self.most);
        while least < most {
            let middle = least + (most - least) / 2;
            if up_to(self.values, middle) > half {
                most = middle;
            } else {
                least = middle + 1;
            }
        }
        least
    }
}

/// Counts the values that are at most `most`. There must be fewer than 2¹⁶ values.
#[inline(always)]
fn up_to(values: &[u16], most: u16) -> u16 {
    values.iter().map(|&value| u16::from(value <= most)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_middle_is_where_sorting_puts_it(mut values in prop::collection::vec(0u16..1024, 1..500)) {
            let found = lariat_portable::Arch::new().dispatch(Middle { values: &values, most: 1023 });
            values.sort_unstable();
            prop_assert_eq!(found, values[values.len() / 2]);
        }
    }
}
