//! Estimates the axis of each section roughly, from three pixels.

use super::STEEPEST;
use super::floats::{Floats, LANES};
use super::inside::Found;
use super::places::Places;
use super::sections::Sections;
use crate::depth::image::DepthImage;
use lariat_portable::{Simd, WithSimd};

/// Value of a pixel that does not count: farther ahead than anything.
const NOTHING: f32 = f32::INFINITY;

/// Rough reading of some sections.
pub(super) struct Glance<'a> {
    pub(super) image: &'a DepthImage<'a>,
    pub(super) sections: &'a Sections,
}

impl WithSimd for Glance<'_> {
    type Output = [Option<Found>; LANES];

    /// Returns the distance ahead of the axis, from the median of three pixels across it.
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let [left, middle, right] = [
            self.axis_by_pixels(simd, -1.0),
            self.axis_by_pixels(simd, 0.0),
            self.axis_by_pixels(simd, 1.0),
        ];
        let (least, most) = (left.min(middle), left.max(middle));
        let (first, second) = (least.min(right), least.max(most.min(right)));
        // Selects the farther one of two pixels.
        let nothing = Floats::splat(simd, NOTHING);
        let ahead = second.where_less(second, nothing, first).lanes();
        let mut found = [None; LANES];
        for (found, ahead) in found.iter_mut().zip(ahead) {
            if ahead < NOTHING {
                *found = Some(Found {
                    ahead: f64::from(ahead),
                    variance: 0.0,
                    beside: 0.0,
                });
            }
        }
        found
    }
}

impl Glance<'_> {
    /// Distance ahead of each section's axis, according to the pixel `across` px to the side of the
    /// section's middle. `NOTHING` if that pixel does not count.
    #[inline(always)]
    fn axis_by_pixels<S: Simd>(&self, simd: S, across: f32) -> Floats<S> {
        let of = self.sections;
        let (at_x, at_y) = (Floats::of(simd, &of.at[0]), Floats::of(simd, &of.at[1]));
        let along_x = Floats::of(simd, &of.along[0]);
        let along_y = Floats::of(simd, &of.along[1]);
        let (first, last) = (Floats::of(simd, &of.ends[0]), Floats::of(simd, &of.ends[1]));
        let (inner, radius) = (Floats::of(simd, &of.inner), Floats::of(simd, &of.radius));
        let on = Floats::splat(simd, 0.5) * (first + last);
        let off = Floats::splat(simd, across);
        let column = (at_x + on * along_x - off * along_y).rounded();
        let row = (at_y + on * along_y + off * along_x).rounded();
        let places = Places::new(simd, self.image);
        let read = places.read(places.starts(column, row));
        let (x, y) = (column - at_x, row - at_y);
        let off = y * along_x - x * along_y;
        let on = x * along_x + y * along_y;
        let zero = Floats::splat(simd, 0.0);
        let from_axis = off * Floats::of(simd, &of.beside_per_px);
        let rise = (radius * radius - from_axis * from_axis).max(zero).sqrt();
        let rise = rise / Floats::of(simd, &of.sine);
        let leaning = Floats::of(simd, &of.slope) * on + Floats::of(simd, &of.tilt) * off;
        let ahead = read + rise - leaning;
        let steepest = Floats::splat(simd, STEEPEST as f32 * 0.75);
        let reach = steepest * (last - first) * Floats::of(simd, &of.mm_per_px);
        let noise = Floats::splat(simd, 5.0) * Floats::of(simd, &of.sigma);
        let gate = Floats::splat(simd, 6.0) * radius + noise + reach;
        let from = (ahead - Floats::of(simd, &of.ahead)).abs();
        let nothing = Floats::splat(simd, NOTHING);
        let ahead = ahead.where_less(from, gate, nothing);
        let ahead = ahead.where_less(off.abs(), inner, nothing);
        ahead.where_less(zero, read, nothing)
    }
}
