//! Places that a line explains.

use crate::centerline::line::{Line, Sample};
use crate::vec2::{self, Vec2};

/// Maximum distance of such a place from the line, in widths.
const WIDTHS: f32 = 1.0;

/// Bounds on a line's samples, for finding places near it quickly.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reach {
    /// Maximum distance between consecutive samples.
    apart_px: f32,
    /// Maximum distance of a place that is near a sample.
    within_px: f32,
}

impl Reach {
    pub(super) fn of(line: &Line) -> Self {
        let apart = |pair: &[Sample]| vec2::distance(pair[0].at, pair[1].at);
        let within = |sample: &Sample| WIDTHS * sample.width_px.max(1.0);
        let (pairs, samples) = (line.samples.windows(2), line.samples.iter());
        Self {
            apart_px: pairs.map(apart).fold(1e-3, f32::max),
            within_px: samples.map(within).fold(0.0, f32::max),
        }
    }

    /// Returns whether a place is near the line. After a distant sample, it skips those that cannot
    /// be near.
    pub(super) fn holds(self, line: &Line, at: Vec2) -> bool {
        let mut i = 0;
        while let Some(sample) = line.samples.get(i) {
            let off_px = vec2::distance(sample.at, at);
            if off_px < WIDTHS * sample.width_px.max(1.0) {
                return true;
            }
            // Skips slightly fewer samples, because of rounding.
            let passed = 0.99 * (off_px - self.within_px) / self.apart_px;
            i += (passed as usize).max(1);
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn nothing_near_is_passed_over(
            samples in prop::collection::vec(((0.0..60.0f32, 0.0..60.0f32), 0.0..9.0f32), 0..60),
            at in (0.0..60.0f32, 0.0..60.0f32),
        ) {
            let sample = |&((x, y), width_px): &((f32, f32), f32)| Sample {
                at: [x, y],
                width_px,
                ..Sample::default()
            };
            let line = Line {
                samples: samples.iter().map(sample).collect(),
                ..Line::default()
            };
            let at = [at.0, at.1];
            let near = |s: &Sample| vec2::distance(s.at, at) < WIDTHS * s.width_px.max(1.0);
            prop_assert_eq!(Reach::of(&line).holds(&line, at), line.samples.iter().any(near));
        }
    }
}
