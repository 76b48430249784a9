//! Mask of covered points, one bit each.

use crate::MAX_POINTS;

/// One bit per point: bit i % 32 of word i / 32 is point i.
pub type Hidden = [u32; MAX_POINTS / 32];

/// Returns whether point `i` is covered.
pub const fn is_hidden(mask: &Hidden, i: usize) -> bool {
    i < MAX_POINTS && mask[i / 32] >> (i % 32) & 1 == 1
}

/// Packs one bool per point, in order, into a mask.
pub fn hidden(points: impl IntoIterator<Item = bool>) -> Hidden {
    let mut mask = [0; MAX_POINTS / 32];
    for (i, is_set) in points.into_iter().take(MAX_POINTS).enumerate() {
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
