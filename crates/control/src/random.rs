//! Random numbers for the tests.

use lariat_portable::SplitMix64;

use crate::{Coordinates, Features, MAX_FEATURES};

pub(crate) fn coordinates(random: &mut SplitMix64) -> Coordinates {
    std::array::from_fn(|_| random.uniform(-1.0, 1.0))
}

/// The first `size` entries are from −1 to 1.
pub(crate) fn features(random: &mut SplitMix64, size: usize) -> Features {
    let mut features = [0.0; MAX_FEATURES];
    features[..size].fill_with(|| random.uniform(-1.0, 1.0));
    features
}
