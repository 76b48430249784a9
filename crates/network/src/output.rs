//! Converts signed bytes to activations, by adding a skip, and to probabilities.

use lariat_portable::Arch;

/// The probability for each signed byte, a logit in sixteenths. 255 is certain.
pub(crate) fn probabilities() -> [u8; 256] {
    std::array::from_fn(|k| {
        let logit = f64::from((k as u8).cast_signed()) / 16.0;
        (255.0 / (1.0 + libm::exp(-logit))).round() as u8
    })
}

/// Adds each pixel of `signed`, of `CHANNELS` bytes, to two pixels of `row`, and clamps the sums to
/// 0 to 127.
pub(crate) fn add_twice<const CHANNELS: usize>(signed: &[u8], row: &mut [u8]) {
    Arch::new().dispatch(
        #[inline(always)]
        || {
            let pixels = signed.as_chunks::<CHANNELS>().0.iter();
            let pairs = row.as_chunks_mut::<CHANNELS>().0.as_chunks_mut::<2>().0;
            for (pixel, pair) in pixels.zip(pairs) {
                for skips in pair {
                    for (skip, add) in skips.iter_mut().zip(pixel) {
                        // An activation is at most 127, so it fits in a signed byte.
                        let sum = skip.cast_signed().saturating_add(add.cast_signed());
                        *skip = sum.max(0).cast_unsigned();
                    }
                }
            }
        },
    );
}

/// Copies one row of a map out of 4×4 blocks: bytes `at` to `at + 3` of each 32.
pub(crate) fn spread(values: &[u8], at: usize, row: &mut [u8]) {
    let mut fours = values.chunks_exact(32).map(|pixel| &pixel[at..][..4]);
    let (whole, rest) = row.as_chunks_mut::<4>();
    for (out, four) in whole.iter_mut().zip(fours.by_ref()) {
        out.copy_from_slice(four);
    }
    if let Some(four) = fours.next() {
        rest.copy_from_slice(&four[..rest.len()]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_logit_of_0_is_one_half_and_probabilities_rise() {
        let table = probabilities();
        let in_order =
            Vec::from_iter((-128..=127i8).map(|v| table[usize::from(v.cast_unsigned())]));
        assert!(in_order.is_sorted());
        assert_eq!((in_order[0], in_order[128], in_order[255]), (0, 128, 255));
        // e^(-1) in the denominator: 255 / 1.3679 = 186.4.
        assert_eq!(table[16], 186);
    }

    #[test]
    fn a_sum_is_no_less_than_0_and_no_more_than_127() {
        let signed = [-128i8, -5, 0, 127].map(i8::cast_unsigned);
        let mut row = [127, 3, 9, 127, 0, 100, 127, 1];
        add_twice::<4>(&signed, &mut row);
        assert_eq!(row, [0, 0, 9, 127, 0, 95, 127, 127]);
    }

    #[test]
    fn a_row_of_a_map_ends_with_the_picture() {
        let values = Vec::from_iter(0..96);
        let mut row = [255; 10];
        spread(&values, 4, &mut row);
        assert_eq!(row, [4, 5, 6, 7, 36, 37, 38, 39, 68, 69]);
    }
}
