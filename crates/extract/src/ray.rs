//! Reading a plane along a straight line that lies well inside of it: no clamping, and positions in 1/256 px, which
//! the sum with a power of two leaves in the lowest bits of a float.

use crate::plane::Plane;
use crate::vec2::Vec2;

/// Added to a position below it, the lowest bit of the sum stands for 1/256: 2¹⁵ has 8 binary places in an `f32`.
const FIX: f32 = 32_768.0;
/// Binary places of a position.
const PLACES: u32 = 8;
/// Its part behind the point, and that before it.
const PART: u32 = (1 << PLACES) - 1;
const WHOLE: u32 = 0x7fff;

/// A line through a plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray<'a> {
    bytes: &'a [u8],
    /// The same from the second row on.
    below: &'a [u8],
    row: u32,
    from: Vec2,
    along: Vec2,
}

impl<'a> Ray<'a> {
    /// The line through `from` in the direction `along`, a unit; nothing when it may leave the plane within `reach_px`
    /// to either side.
    #[inline(always)]
    pub(crate) fn new(plane: &'a Plane, from: Vec2, along: Vec2, reach_px: f32) -> Option<Self> {
        // The pixel to the right and the rounding stay inside, too.
        let right = (plane.width() as f32).min(FIX) - 2.0;
        let bottom = (plane.height() as f32).min(FIX) - 2.0;
        let [x, y] = from;
        let inside = x.min(y) >= reach_px && x + reach_px < right && y + reach_px < bottom;
        inside.then(|| Self {
            bytes: plane.bytes(),
            below: &plane.bytes()[plane.width()..],
            row: plane.width() as u32,
            from,
            along,
        })
    }

    /// The values at some distances from the start, bilinear.
    #[inline(always)]
    pub(crate) fn at_each<const N: usize>(&self, far_px: [f32; N]) -> [f32; N] {
        // Three loops, so that only the one that fetches goes pixel by pixel.
        let (mut x, mut y, mut first) = ([0; N], [0; N], [0; N]);
        for k in 0..N {
            x[k] = (self.from[0] + far_px[k] * self.along[0] + FIX).to_bits();
            y[k] = (self.from[1] + far_px[k] * self.along[1] + FIX).to_bits();
            first[k] = (y[k] >> PLACES & WHOLE) * self.row + (x[k] >> PLACES & WHOLE);
        }
        let (mut top, mut low) = ([0; N], [0; N]);
        for k in 0..N {
            let at = first[k] as usize;
            top[k] = pair(self.bytes, at);
            low[k] = pair(self.below, at);
        }
        let mut values = [0.0; N];
        for k in 0..N {
            let part = |c: u32| (c & PART) as i32 as f32 * (1.0 / (PART + 1) as f32);
            let mix = |pair: u32| {
                let [a, b] = [pair & 0xff, pair >> 8];
                let [a, b] = [a as i32 as f32, b as i32 as f32];
                a + part(x[k]) * (b - a)
            };
            let (top, low) = (mix(top[k]), mix(low[k]));
            values[k] = top + part(y[k]) * (low - top);
        }
        values
    }

    /// The value at a distance from the start, bilinear.
    #[inline(always)]
    pub(crate) fn at(&self, far_px: f32) -> f32 {
        self.at_each([far_px])[0]
    }
}

/// Two bytes side by side.
#[inline(always)]
fn pair(bytes: &[u8], at: usize) -> u32 {
    let pair = &bytes[at..at + 2];
    u32::from(u16::from_le_bytes([pair[0], pair[1]]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vec2;
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
            prop_assert_eq!(ray.at_each([0.0, far, -far]), [ray.at(0.0), ray.at(far), ray.at(-far)]);
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
