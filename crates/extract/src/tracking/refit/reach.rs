//! Which places a line accounts for.

use crate::centerline::line::{Line, Sample};
use crate::vec2::{self, Vec2};

/// Widths within which it does.
const WIDTHS: f32 = 1.0;

/// What lies near a line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reach {
    /// The farthest that a sample lies from the one before.
    apart_px: f32,
    /// The farthest that a place may lie from one to be near.
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

    /// Whether a place is near the line. From a sample that lies far off, those after it are passed over that cannot be
    /// nearer than is near.
    pub(super) fn holds(self, line: &Line, at: Vec2) -> bool {
        let mut i = 0;
        while let Some(sample) = line.samples.get(i) {
            let off_px = vec2::distance(sample.at, at);
            if off_px < WIDTHS * sample.width_px.max(1.0) {
                return true;
            }
            // Less what rounding may add.
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
