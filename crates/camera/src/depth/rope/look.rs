//! All of a section's inside, read at places of a fixed pattern: what it says of the axis.

use super::reading::Section;
use crate::depth::image::DepthImage;
use lariat_portable::{Simd, WithSimd};

/// Places in a section where its pixels are read.
const SAMPLES: usize = 32;
const VECTORS: usize = SAMPLES / 16;
/// The share of them that fall on a pixel of their own, at most.
const READ_ONCE: f64 = 0.75;
/// Added and taken away it leaves a whole number, of what is below 4 million in size.
const ROUNDING: f32 = 12_582_912.0;
/// Where they are, -1 to 1: a lattice of Fibonacci's, without rows that would fall into step with those of the image.
const ALONG: [f32; SAMPLES] = {
    let mut places = [0.0; SAMPLES];
    let mut k = 0;
    while k < SAMPLES {
        places[k] = (2 * k + 1) as f32 / SAMPLES as f32 - 1.0;
        k += 1;
    }
    places
};
const ACROSS: [f32; SAMPLES] = {
    let mut places = [0.0; SAMPLES];
    let mut k = 0;
    while k < SAMPLES {
        let turns = (k as f64 + 0.5) * 0.618_033_988_749_895;
        places[k] = (2.0 * (turns - (turns as usize) as f64) - 1.0) as f32;
        k += 1;
    }
    places
};
/// Of the radius: how much of it is taken for wrong, as widths are.
const RADIUS_ERROR: f64 = 0.02;
/// What is this many standard deviations from the mean is another thing.
const STRAY: f32 = 2.5;

/// What is read of an axis.
pub(super) struct Found {
    /// How far ahead of the depth camera it is, and the variance of that.
    pub(super) ahead: f64,
    pub(super) variance: f64,
    /// How far beside the middle of what is seen of the rope it is, of the rope's half width.
    pub(super) beside: f64,
}

/// All of a section's inside.
pub(super) struct Look<'a> {
    pub(super) image: &'a DepthImage<'a>,
    pub(super) section: Section,
}

impl WithSimd for Look<'_> {
    type Output = Option<Found>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let section = &self.section;
        let samples = self.samples(simd);
        let sigma = section.sigma as f32;
        let reach = section.radius as f32 + 5.0 * sigma;
        let all = samples.middle(simd, 0.0, reach)?;
        // What is behind an edge takes the first mean with it, and is left out then.
        let near = samples.middle(simd, all, STRAY * sigma).unwrap_or(all);
        let near = (samples.mean(simd, near, STRAY * sigma))
            .or_else(|| samples.mean(simd, all, STRAY * sigma))
            .or_else(|| samples.mean(simd, 0.0, reach))?;
        let [first, last] = section.ends;
        // Of a narrow section the places fall on pixels beside it, too, which do not count.
        let pixels = 2.0 * section.inner.max(0.5) * (last - first).max(1.0);
        let count = f64::from(near.count);
        let spread = f64::from(near.squares) / (count - 1.0).max(1.0);
        let alone = (READ_ONCE.min(pixels / SAMPLES as f64) * count).max(1.0);
        let variance = spread.max(section.sigma * section.sigma) / alone;
        let wrong = RADIUS_ERROR * section.radius / section.sine;
        Some(Found {
            ahead: section.ahead + f64::from(near.mean),
            variance: variance + wrong * wrong,
            beside: f64::from(near.beside) * section.mm_per_px / section.radius,
        })
    }
}

impl Look<'_> {
    /// Reads the pixels of a section.
    #[inline(always)]
    fn samples<S: Simd>(&self, simd: S) -> Samples<S> {
        let section = &self.section;
        let [first, last] = section.ends;
        let middle = splat(simd, 0.5 * (first + last));
        let half = splat(simd, 0.5 * (last - first));
        let (at_x, at_y) = (splat(simd, section.at[0]), splat(simd, section.at[1]));
        let along_x = splat(simd, section.along[0]);
        let along_y = splat(simd, section.along[1]);
        let inner = splat(simd, section.inner);
        let (mut columns, mut rows) = ([0.0; SAMPLES], [0.0; SAMPLES]);
        let to = S::as_mut_simd_f32s(&mut columns).0.iter_mut();
        let to = to.zip(S::as_mut_simd_f32s(&mut rows).0);
        let from = S::as_simd_f32s(&ALONG)
            .0
            .iter()
            .zip(S::as_simd_f32s(&ACROSS).0);
        for ((column, row), (&along, &across)) in to.zip(from) {
            let on = simd.mul_add_f32s(half, along, middle);
            let off = simd.mul_f32s(inner, across);
            let x = simd.sub_f32s(simd.mul_f32s(on, along_x), simd.mul_f32s(off, along_y));
            let y = simd.mul_add_f32s(off, along_x, simd.mul_f32s(on, along_y));
            *column = rounded(simd, simd.add_f32s(at_x, x));
            *row = rounded(simd, simd.add_f32s(at_y, y));
        }
        let mut measured = [0.0; SAMPLES];
        self.image.read(&columns, &rows, &mut measured);
        let zero = simd.splat_f32s(0.0);
        let (about, slope) = (splat(simd, section.ahead), splat(simd, section.slope));
        let (tilt, per_px) = (
            splat(simd, section.tilt),
            splat(simd, section.beside_per_px),
        );
        let squared_radius = splat(simd, section.radius * section.radius);
        let per_sine = splat(simd, 1.0 / section.sine);
        let mut samples = Samples {
            off: [zero; VECTORS],
            beside: [zero; VECTORS],
            counts: [zero; VECTORS],
        };
        let columns = S::as_simd_f32s(&columns).0;
        let rows = S::as_simd_f32s(&rows).0;
        let measured = S::as_simd_f32s(&measured).0;
        for k in 0..VECTORS {
            let (x, y) = (
                simd.sub_f32s(columns[k], at_x),
                simd.sub_f32s(rows[k], at_y),
            );
            let beside = simd.sub_f32s(simd.mul_f32s(y, along_x), simd.mul_f32s(x, along_y));
            let on = simd.mul_add_f32s(x, along_x, simd.mul_f32s(y, along_y));
            samples.beside[k] = beside;
            let from_axis = simd.mul_f32s(beside, per_px);
            let inside = simd.sub_f32s(squared_radius, simd.mul_f32s(from_axis, from_axis));
            let rise = simd.sqrt_f32s(simd.max_f32s(inside, zero));
            let rise = simd.mul_f32s(rise, per_sine);
            let surface = simd.sub_f32s(measured[k], about);
            let leaning = simd.mul_add_f32s(slope, on, simd.mul_f32s(tilt, beside));
            samples.off[k] = simd.sub_f32s(simd.add_f32s(surface, rise), leaning);
            let is_inside = simd.less_than_or_equal_f32s(simd.abs_f32s(beside), inner);
            let count = simd.select_f32s(is_inside, simd.splat_f32s(1.0), zero);
            let is_measured = simd.less_than_f32s(zero, measured[k]);
            samples.counts[k] = simd.select_f32s(is_measured, count, zero);
        }
        samples
    }
}

/// What the pixels of a section say: how much farther ahead the axis is than it was taken for, mm, how far beside it they are, px, and
/// whether they count, 0 or 1.
struct Samples<S: Simd> {
    off: [S::f32s; VECTORS],
    beside: [S::f32s; VECTORS],
    counts: [S::f32s; VECTORS],
}

impl<S: Simd> Samples<S> {
    /// The mean of what counts and is nearer than `gate` to `about`; `None` of nothing.
    #[inline(always)]
    fn middle(&self, simd: S, about: f32, gate: f32) -> Option<f32> {
        let (center, gate) = (simd.splat_f32s(about), simd.splat_f32s(gate));
        let zero = simd.splat_f32s(0.0);
        let (mut count, mut sum) = (zero, zero);
        for k in 0..VECTORS {
            let from = simd.sub_f32s(self.off[k], center);
            let is_near = simd.less_than_f32s(simd.abs_f32s(from), gate);
            let near = simd.select_f32s(is_near, self.counts[k], zero);
            count = simd.add_f32s(count, near);
            sum = simd.add_f32s(sum, simd.mul_f32s(near, from));
        }
        let count = simd.reduce_sum_f32s(count);
        (count != 0.0).then(|| about + simd.reduce_sum_f32s(sum) / count)
    }

    /// The same, and what else is known of it.
    #[inline(always)]
    fn mean(&self, simd: S, about: f32, gate: f32) -> Option<Mean> {
        let (center, gate) = (simd.splat_f32s(about), simd.splat_f32s(gate));
        let zero = simd.splat_f32s(0.0);
        let (mut count, mut sum, mut squares, mut aside) = (zero, zero, zero, zero);
        for k in 0..VECTORS {
            let from = simd.sub_f32s(self.off[k], center);
            let is_near = simd.less_than_f32s(simd.abs_f32s(from), gate);
            let near = simd.select_f32s(is_near, self.counts[k], zero);
            aside = simd.mul_add_f32s(near, self.beside[k], aside);
            let part = simd.mul_f32s(near, from);
            count = simd.add_f32s(count, near);
            sum = simd.add_f32s(sum, part);
            squares = simd.mul_add_f32s(part, from, squares);
        }
        let count = simd.reduce_sum_f32s(count);
        if count == 0.0 {
            return None;
        }
        let sum = simd.reduce_sum_f32s(sum);
        Some(Mean {
            count,
            mean: about + sum / count,
            beside: simd.reduce_sum_f32s(aside) / count,
            squares: (simd.reduce_sum_f32s(squares) - sum * sum / count).max(0.0),
        })
    }
}

#[inline(always)]
fn splat<S: Simd>(simd: S, value: f64) -> S::f32s {
    simd.splat_f32s(value as f32)
}

/// The whole numbers nearest to these.
#[inline(always)]
fn rounded<S: Simd>(simd: S, places: S::f32s) -> S::f32s {
    let rounding = simd.splat_f32s(ROUNDING);
    simd.sub_f32s(simd.add_f32s(places, rounding), rounding)
}

/// The mean of so many numbers, the sum of the squares of their distances from it, and the mean of how far beside the axis they are.
#[derive(Debug, Clone, Copy)]
struct Mean {
    count: f32,
    mean: f32,
    beside: f32,
    squares: f32,
}
