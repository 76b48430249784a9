//! A bit a point: whether something covers it.

use crate::MAX_POINTS;

/// Bit `i` of a mask of points.
pub(super) const fn bit(mask: &[u32; MAX_POINTS / 32], i: usize) -> bool {
    i < MAX_POINTS && mask[i / 32] >> (i % 32) & 1 == 1
}

/// A mask of points with these bits, in order.
pub(super) fn mask(bits: impl IntoIterator<Item = bool>) -> [u32; MAX_POINTS / 32] {
    let mut mask = [0; MAX_POINTS / 32];
    for (i, is_set) in bits.into_iter().take(MAX_POINTS).enumerate() {
        mask[i / 32] |= u32::from(is_set) << (i % 32);
    }
    mask
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Curve;

    #[test]
    fn every_point_has_a_bit_of_its_own_that_says_whether_it_is_hidden() {
        let mut curve = Curve::EMPTY;
        curve.hidden = [u32::MAX; 8];
        curve.set_hidden((0..MAX_POINTS).map(|i| i % 37 == 5));
        assert!((0..MAX_POINTS).all(|i| curve.is_hidden(i) == (i % 37 == 5)));
        assert!(!curve.is_hidden(MAX_POINTS));
    }
}
