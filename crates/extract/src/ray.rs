//! Reading a plane along a straight line that lies well inside of it: no clamping, and positions in 1/256 px, which
//! the sum with a power of two leaves in the lowest bits of a float.

use crate::plane::Plane;
use crate::vec2::{self, Vec2};

/// Added to a position below it, the lowest bit of the sum stands for 1/256: 2¹⁵ has 8 binary places in an `f32`.
const FIX: f32 = 32_768.0;
/// Binary places of a position.
const PLACES: u32 = 8;

/// A line through a plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray<'a> {
    bytes: &'a [u8],
    row: usize,
    from: Vec2,
    along: Vec2,
}

impl<'a> Ray<'a> {
    /// The line through `from` in the direction `along`, a unit; nothing when it may leave the plane within `reach_px`
    /// to either side.
    #[inline(always)]
    pub(crate) fn new(plane: &'a Plane, from: Vec2, along: Vec2, reach_px: f32) -> Option<Self> {
        // The pixel to the right and the rounding stay inside, too.
        let [right, bottom] = [plane.width(), plane.height()].map(|n| (n as f32).min(FIX) - 2.0);
        let [low_x, low_y] = from.map(|c| c - reach_px);
        let [high_x, high_y] = from.map(|c| c + reach_px);
        let inside = low_x >= 0.0 && low_y >= 0.0 && high_x < right && high_y < bottom;
        inside.then(|| Self {
            bytes: plane.bytes(),
            row: plane.width(),
            from,
            along,
        })
    }

    /// The value at a distance from the start, bilinear.
    #[inline(always)]
    pub(crate) fn at(&self, far_px: f32) -> f32 {
        let [x, y] = vec2::along(self.from, self.along, far_px).map(|c| (c + FIX).to_bits());
        let whole = |c: u32| (c >> PLACES & 0x7fff) as usize;
        let part = |c: u32| (c & ((1 << PLACES) - 1)) as i32;
        let first = whole(y) * self.row + whole(x);
        let mix = |at: usize| {
            let pair = &self.bytes[at..at + 2];
            let [a, b] = [i32::from(pair[0]), i32::from(pair[1])];
            (a << PLACES) + part(x) * (b - a)
        };
        let (top, low) = (mix(first), mix(first + self.row));
        let value = (top << PLACES) + part(y) * (low - top);
        value as f32 * (1.0 / (1 << (2 * PLACES)) as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn plane() -> Plane {
        let mut plane = Plane::default();
        plane.resize(61, 47);
        for y in 0..47 {
            for (x, byte) in plane.row_mut(y).iter_mut().enumerate() {
                *byte = (x * x * 7 + y * 31 + x * y) as u8;
            }
        }
        plane
    }

    proptest! {
        #[test]
        fn a_ray_reads_what_a_sample_does(x in 12.0f32..46.0, y in 12.0f32..32.0, turn in -3.0f32..3.0, far in -12.0f32..12.0) {
            let (plane, along) = (plane(), [turn.cos(), turn.sin()]);
            let ray = Ray::new(&plane, [x, y], along, 12.0).expect("well inside");
            // Two coordinates rounded to 1/512 px, over steps of at most 255 levels.
            let expected = plane.sample(vec2::along([x, y], along, far));
            prop_assert!((ray.at(far) - expected).abs() <= 2.0 * 255.0 / 512.0 + 0.1);
        }
    }

    #[test]
    fn a_line_that_may_leave_the_plane_is_none() {
        let plane = plane();
        for from in [[5.0, 20.0], [50.0, 20.0], [30.0, 5.0], [30.0, 36.0]] {
            assert!(Ray::new(&plane, from, [1.0, 0.0], 12.0).is_none());
        }
        assert!(Ray::new(&plane, [f32::NAN, 20.0], [1.0, 0.0], 12.0).is_none());
    }
}
