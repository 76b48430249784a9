//! Reads a plane along straight lines well inside it, one line at a time or one in each lane of a
//! register.
//!
//! Positions are not clamped. They are in 1/256 px: adding a power of two leaves them in the lowest
//! bits of a float.

use super::gray::GrayPlane;
use crate::vec2::Vec2;

/// Constant that, added to a smaller position, makes the lowest bit of the sum worth 1/256: an
/// `f32` near 2¹⁵ has 8 binary places.
const FIX: f32 = 32_768.0;
/// Binary places of a position.
const PLACES: u32 = 8;
/// Masks of the fractional part of a position and of its whole part.
const PART: u32 = (1 << PLACES) - 1;
const WHOLE: u32 = 0x7fff;

/// A line through a plane.
#[cfg(test)]
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray<'a> {
    bytes: &'a [u8],
    /// The bytes from the second row on.
    below: &'a [u8],
    row: u32,
    from: Vec2,
    along: Vec2,
}

#[cfg(test)]
impl<'a> Ray<'a> {
    /// Returns the line through `from` in the direction `along`, a unit vector. `None` if the line
    /// may leave the plane within `reach_px` to either side.
    #[inline(always)]
    pub(crate) fn new(
        plane: &'a GrayPlane,
        from: Vec2,
        along: Vec2,
        reach_px: f32,
    ) -> Option<Self> {
        // The pixel to the right and the rounding must also stay inside.
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

    /// Values at some distances from the start, bilinear.
    #[inline(always)]
    pub(crate) fn at_each<const N: usize>(&self, far_px: [f32; N]) -> [f32; N] {
        // Three loops, because only the loop that fetches has to go pixel by pixel.
        let (mut x, mut y, mut first) = ([0; N], [0; N], [0; N]);
        for k in 0..N {
            x[k] = (self.from[0] + far_px[k] * self.along[0] + FIX).to_bits();
            y[k] = (self.from[1] + far_px[k] * self.along[1] + FIX).to_bits();
            first[k] = (y[k] >> PLACES & WHOLE) * self.row + (x[k] >> PLACES & WHOLE);
        }
        let mut fours = [0; N];
        for (four, &at) in fours.iter_mut().zip(&first) {
            let at = at as usize;
            *four = pair(self.bytes, at) | pair(self.below, at) << 16;
        }
        let mut values = [0.0; N];
        for k in 0..N {
            values[k] = mix(fours[k], x[k], y[k]);
        }
        values
    }
}

/// Number of lines read at once: one in each lane of the widest registers.
pub(crate) const LANES: usize = 16;
/// One number per line.
pub(crate) type Lanes = [f32; LANES];

/// [`LANES`] lines through a plane.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Rays {
    pub(crate) from: [Lanes; 2],
    /// Directions of the lines, unit vectors.
    pub(crate) along: [Lanes; 2],
}

impl Rays {
    /// Lays line `lane` through `from`, at right angles to `slope`. `slope` can have any length if
    /// [`unify`](Self::unify) follows.
    #[inline(always)]
    pub(crate) fn lay(&mut self, lane: usize, from: Vec2, slope: Vec2) {
        (self.from[0][lane], self.from[1][lane]) = (from[0], from[1]);
        (self.along[0][lane], self.along[1][lane]) = (-slope[1], slope[0]);
    }

    /// Scales the directions to unit length.
    #[inline(always)]
    pub(crate) fn unify(&mut self) {
        let [along_x, along_y] = &mut self.along;
        for (x, y) in along_x.iter_mut().zip(along_y) {
            let length = (*x * *x + *y * *y).sqrt();
            let (has, share) = (length > 1e-6, 1.0 / length);
            // Without a direction, use the normal of a slope to the right.
            (*x, *y) = (
                if has { *x * share } else { 0.0 },
                if has { *y * share } else { 1.0 },
            );
        }
    }

    /// Start and direction of line `lane`.
    #[inline(always)]
    pub(crate) fn line(&self, lane: usize) -> (Vec2, Vec2) {
        let of = |both: &[Lanes; 2]| [both[0][lane], both[1][lane]];
        (of(&self.from), of(&self.along))
    }

    /// Returns which of the lines stay within the plane up to `reach_px` to either side.
    #[inline(always)]
    pub(crate) fn are_inside(&self, plane: &GrayPlane, reach_px: f32) -> [bool; LANES] {
        let right = (plane.width() as f32).min(FIX) - 2.0;
        let bottom = (plane.height() as f32).min(FIX) - 2.0;
        let mut inside = [false; LANES];
        for (l, inside) in inside.iter_mut().enumerate() {
            let (x, y) = (self.from[0][l], self.from[1][l]);
            let left_or_top = (x >= reach_px) & (y >= reach_px);
            *inside = left_or_top & (x + reach_px < right) & (y + reach_px < bottom);
        }
        inside
    }

    /// Fills `values` with the values at some distances along each line, as the plain `Ray` of the
    /// tests reads them. Values of a line that leaves the plane are meaningless.
    #[inline(always)]
    pub(crate) fn read<const K: usize>(
        &self,
        plane: &GrayPlane,
        far_px: &[Lanes; K],
        values: &mut [Lanes; K],
    ) {
        let (bytes, width) = (plane.bytes(), plane.width());
        let row = width as u32;
        let (Some(below), Some(last)) = (bytes.get(width..), bytes.len().checked_sub(width + 2))
        else {
            return;
        };
        // Three loops, because only the loop that fetches has to go pixel by pixel.
        let (mut first, mut fours) = ([[0; LANES]; K], [[0; LANES]; K]);
        let (mut x, mut y) = ([[0; LANES]; K], [[0; LANES]; K]);
        for k in 0..K {
            for l in 0..LANES {
                x[k][l] = (self.from[0][l] + far_px[k][l] * self.along[0][l] + FIX).to_bits();
                y[k][l] = (self.from[1][l] + far_px[k][l] * self.along[1][l] + FIX).to_bits();
                let at = (y[k][l] >> PLACES & WHOLE) * row + (x[k][l] >> PLACES & WHOLE);
                first[k][l] = at.min(last as u32);
            }
        }
        let flat = fours.as_flattened_mut().iter_mut();
        for (four, &at) in flat.zip(first.as_flattened()) {
            let at = at as usize;
            *four = pair(bytes, at) | pair(below, at) << 16;
        }
        for k in 0..K {
            for l in 0..LANES {
                values[k][l] = mix(fours[k][l], x[k][l], y[k][l]);
            }
        }
    }
}

/// Interpolates between four pixels. The upper row's two are in the lower bytes.
#[inline(always)]
fn mix(four: u32, x: u32, y: u32) -> f32 {
    let part = |c: u32| (c & PART) as i32 as f32 * (1.0 / (PART + 1) as f32);
    let byte = |k: u32| (four >> (8 * k) & 0xff) as i32 as f32;
    let top = byte(0) + part(x) * (byte(1) - byte(0));
    let low = byte(2) + part(x) * (byte(3) - byte(2));
    top + part(y) * (low - top)
}

/// Two adjacent bytes.
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

    fn plane() -> GrayPlane {
        let mut plane = GrayPlane::default();
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
            // Two coordinates, each off by at most 1/512 px, across steps of at most 255 levels.
            let expected = plane.sample(vec2::along([x, y], along, far));
            prop_assert!((ray.at_each([far])[0] - expected).abs() <= 2.0 * 255.0 / 512.0 + 0.1);
            prop_assert_eq!(ray.at_each([0.0, far, -far]), [0.0, far, -far].map(|far| ray.at_each([far])[0]));
        }
    }

    proptest! {
        #[test]
        fn many_lines_read_what_each_of_them_does(places in proptest::array::uniform16((0.0f32..61.0, 0.0f32..47.0, -3.0f32..3.0, 0.0f32..12.0)), reach in 1.0f32..12.0) {
            let (plane, mut rays, mut far) = (plane(), Rays::default(), [[0.0; LANES]; 3]);
            for (l, (x, y, turn, away)) in places.into_iter().enumerate() {
                (rays.from[0][l], rays.from[1][l]) = (x, y);
                (rays.along[0][l], rays.along[1][l]) = (turn.cos(), turn.sin());
                (far[1][l], far[2][l]) = (away.min(reach), -away.min(reach));
            }
            let (inside, mut values) = (rays.are_inside(&plane, reach), [[0.0; LANES]; 3]);
            rays.read(&plane, &far, &mut values);
            for (l, (x, y, turn, _)) in places.into_iter().enumerate() {
                let ray = Ray::new(&plane, [x, y], [turn.cos(), turn.sin()], reach);
                prop_assert_eq!(ray.is_some(), inside[l]);
                if let Some(ray) = ray {
                    prop_assert_eq!([0, 1, 2].map(|k| values[k][l]), ray.at_each([0, 1, 2].map(|k| far[k][l])));
                }
            }
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
