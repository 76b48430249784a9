//! Selects the two images from which a Jacobian is learned. Between consecutive images, the
//! grippers move by less than the noise. A pair must be far enough apart in `r` to be informative,
//! and close enough in time to show the response of the same rope.

use crate::estimator::Pair;
use crate::jacobian::square;
use crate::options::Learning;
use crate::{Coordinates, Features};

/// Minimum motion of the grippers, in standard deviations of the noise of `δs`. Noise then changes
/// `J` by a third of the response of a rope that moves as much as its grippers. With half of
/// Broyden's step, the change is half of that.
const STEP_BY_NOISE: f64 = 3.0;

/// A shape, and the grippers' positions when its image was exposed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Frame {
    pub(crate) features: Features,
    pub(crate) r: Coordinates,
    /// Time of `r`, on the clock of the commands.
    pub(crate) at_ns: u64,
    /// Mean square distance caused by noise, px².
    pub(crate) noise_px2: f64,
}

/// Pairs each frame with an earlier one.
#[derive(Debug, Clone)]
pub(crate) struct Pairs {
    learning: Learning,
    first: Option<Frame>,
}

impl Pairs {
    pub(crate) fn new(learning: Learning) -> Self {
        Self {
            learning,
            first: None,
        }
    }

    pub(crate) fn forget(&mut self) {
        self.first = None;
    }

    /// Returns the pair that this frame completes, if any.
    pub(crate) fn pair(&mut self, frame: &Frame) -> Option<Pair> {
        let longest_ns = (self.learning.longest_pair_s * 1e9) as u64;
        let old = |first: &Frame| frame.at_ns.saturating_sub(first.at_ns) > longest_ns;
        let Some(first) = self.first.filter(|first| !old(first)) else {
            self.first = Some(*frame);
            return None;
        };
        let dr = std::array::from_fn(|i| frame.r[i] - first.r[i]);
        let noise_px2 = frame.noise_px2 + first.noise_px2;
        let least = (STEP_BY_NOISE * STEP_BY_NOISE * noise_px2)
            .max(self.learning.least_step_px * self.learning.least_step_px);
        if square(&dr) < least {
            return None;
        }
        let ds = std::array::from_fn(|k| frame.features[k] - first.features[k]);
        self.first = Some(*frame);
        Some(Pair { dr, ds, noise_px2 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{INPUTS, MAX_FEATURES};

    fn frame(px: f64, ms: u64, noise_px2: f64) -> Frame {
        let mut r = [0.0; INPUTS];
        r[1] = px;
        Frame {
            features: [2.0 * px; MAX_FEATURES],
            r,
            at_ns: ms * 1_000_000,
            noise_px2,
        }
    }

    #[test]
    fn frames_too_near_for_the_noise_wait_for_one_farther_off() {
        let mut pairs = Pairs::new(Learning::default());
        assert!(pairs.pair(&frame(0.0, 0, 2.0)).is_none());
        // Three times the root of 2 + 2 is 6.
        assert!(pairs.pair(&frame(5.9, 100, 2.0)).is_none());
        let pair = pairs.pair(&frame(6.1, 200, 2.0)).expect("far enough");
        assert_eq!((pair.dr[1], pair.ds[0], pair.noise_px2), (6.1, 12.2, 4.0));
        assert!(pairs.pair(&frame(7.0, 300, 0.0)).is_none());
    }

    #[test]
    fn frames_too_far_apart_in_time_are_no_pair() {
        let mut pairs = Pairs::new(Learning::default());
        assert!(pairs.pair(&frame(0.0, 0, 0.01)).is_none());
        assert!(pairs.pair(&frame(50.0, 1001, 0.01)).is_none());
        assert!(pairs.pair(&frame(100.0, 2000, 0.01)).is_some());
    }
}
