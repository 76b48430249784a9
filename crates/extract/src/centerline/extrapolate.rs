//! How a rope continues beyond its known part, and where it ends.

use crate::image::gray::GrayPlane;
use crate::vec2::{self, Vec2};

/// Sharpest bend that a tip is followed around, in radians over 1.5 half-widths.
const SHARPEST: f32 = 0.8;

/// The path beyond the first of three samples, as a function from distance to position. It
/// continues the arc from the third sample through the second, or is straight if no arc is known.
pub(crate) fn arc([here, before, oldest]: [Vec2; 3], is_arc: bool) -> impl Fn(f32) -> Vec2 + use<> {
    let new = vec2::sub(here, before);
    let old = vec2::sub(before, oldest);
    let length = vec2::norm(new).max(1e-3);
    let direction = vec2::unit_or(new, [1.0, 0.0]);
    let turn = if is_arc {
        vec2::angle(old, new).clamp(-SHARPEST, SHARPEST)
    } else {
        0.0
    };
    let (half_turn, a_pixel) = (0.5 * turn, 0.5 * turn / length);
    move |far: f32| {
        // The chord to a point `far` ahead on a circle is off the tangent by half the angle.
        let (sin, cos) = sin_cos(half_turn + a_pixel * far);
        let ahead = vec2::along(vec2::scale(direction, cos), vec2::normal(direction), sin);
        vec2::along(here, ahead, far)
    }
}

/// Sine and cosine. Up to 1.5 rad they come from series, exact to all digits but the last.
fn sin_cos(x: f32) -> (f32, f32) {
    if x.abs() > 1.5 {
        return libm::sincosf(x);
    }
    let xx = x * x;
    // 1 / (k · (k + 1)) for every second k.
    let sin = 1.0
        - xx * (1.0 / 20.0)
            * (1.0 - xx * (1.0 / 42.0) * (1.0 - xx * (1.0 / 72.0) * (1.0 - xx * (1.0 / 110.0))));
    let cos = 1.0
        - xx * (1.0 / 12.0)
            * (1.0 - xx * (1.0 / 30.0) * (1.0 - xx * (1.0 / 56.0) * (1.0 - xx * (1.0 / 90.0))));
    (
        x * (1.0 - xx * (1.0 / 6.0) * sin),
        1.0 - xx * (1.0 / 2.0) * cos,
    )
}

/// Distance of the rope's tip along the path `at` (a position for each distance), at most
/// `limit_px`, and whether the image's border cuts the rope.
pub(crate) fn tip(
    difference: &GrayPlane,
    at: impl Fn(f32) -> Vec2,
    level: f32,
    limit_px: f32,
) -> (f32, bool) {
    const STEP: f32 = 0.5;
    let mut before = difference.sample(at(0.0));
    let mut far = 0.0;
    while far < limit_px {
        let p = at(far + STEP);
        let value = difference.sample(p);
        if value < level {
            let fall = before - value;
            let part = if fall > 0.0 {
                ((before - level) / fall).clamp(0.0, 1.0)
            } else {
                0.0
            };
            return (far + STEP * part, false);
        }
        if !difference.holds(p) {
            return (far + STEP, true);
        }
        (far, before) = (far + STEP, value);
    }
    (far, false)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_series_are_the_sine_and_the_cosine() {
        for k in -300..=300 {
            let x = 0.01 * k as f32;
            let ((sin, cos), expected) = (sin_cos(x), x.sin_cos());
            assert!((sin - expected.0).abs() < 1e-6, "{x}");
            assert!((cos - expected.1).abs() < 1e-6, "{x}");
        }
    }
}
