//! Estimates the axis of each section from its whole inside, read at a fixed pattern of places.
//!
//! A vector has one section per lane, and the places are processed one after another. Nothing is
//! summed across lanes.

use super::floats::{Floats, LANES, Lanes};
use super::places::Places;
use super::sections::Sections;
use crate::depth::image::DepthImage;
use lariat_portable::{Simd, WithSimd};

/// Number of places in a section where pixels are read.
const SAMPLES: usize = 32;
/// Maximum share of the places that count as independent, because several places may read the same
/// pixel.
const READ_ONCE: f32 = 0.75;
/// Coordinates of the places, -1 to 1. They are a Fibonacci lattice, which has no rows that could
/// align with those of the image.
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
/// Assumed relative error of the radius, since widths have errors.
const RADIUS_ERROR: f32 = 0.02;
/// A value this many standard deviations from the mean belongs to another object.
const STRAY: f32 = 2.5;

/// Value of a pixel that does not count: farther off than anything.
const NOTHING: f32 = 1e9;

/// Estimate of an axis.
#[derive(Debug, Clone, Copy)]
pub(super) struct Found {
    /// Distance ahead of the depth camera, and its variance.
    pub(super) ahead: f64,
    pub(super) variance: f64,
    /// Distance of the axis from the middle of the visible rope, in half widths of the rope.
    pub(super) beside: f64,
}

/// Full reading of some sections.
pub(super) struct InsideSampler<'a> {
    pub(super) image: &'a DepthImage<'a>,
    pub(super) sections: &'a Sections,
    /// Working memory.
    pub(super) pixels: &'a mut Pixels,
}

impl WithSimd for InsideSampler<'_> {
    type Output = [Option<Found>; LANES];

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) -> Self::Output {
        self.read(simd);
        self.look(simd)
    }
}

impl InsideSampler<'_> {
    /// Reads all pixels before any of them is used. Numbers that were stored one by one can be
    /// loaded as a vector only after a delay.
    #[inline(always)]
    fn read<S: Simd>(&mut self, simd: S) {
        let of = self.sections;
        let [at_x, at_y] = of.at.map(|at| Floats::of(simd, &at));
        let [along_x, along_y] = of.along.map(|along| Floats::of(simd, &along));
        let [first, last] = of.ends.map(|end| Floats::of(simd, &end));
        let inner = Floats::of(simd, &of.inner);
        let (slope, tilt) = (Floats::of(simd, &of.slope), Floats::of(simd, &of.tilt));
        let per_px = Floats::of(simd, &of.beside_per_px);
        let radius = Floats::of(simd, &of.radius);
        let (zero, half) = (Floats::splat(simd, 0.0), Floats::splat(simd, 0.5));
        let per_sine = Floats::splat(simd, 1.0) / Floats::of(simd, &of.sine);
        let squared_radius = radius * radius;
        let (middle, half) = (half * (first + last), half * (last - first));
        let (places, nowhere) = (Places::new(simd, self.image), Places::nowhere(simd));
        let to = &mut *self.pixels;
        for k in 0..SAMPLES {
            let on = half * Floats::splat(simd, ALONG[k]) + middle;
            let off = inner * Floats::splat(simd, ACROSS[k]);
            let column = (at_x + (on * along_x - off * along_y)).rounded();
            let row = (at_y + (off * along_x + on * along_y)).rounded();
            let (x, y) = (column - at_x, row - at_y);
            let beside = y * along_x - x * along_y;
            let on = x * along_x + y * along_y;
            let from_axis = beside * per_px;
            let rise = (squared_radius - from_axis * from_axis).max(zero).sqrt();
            // In a narrow section, some places fall on pixels next to it, which do not count.
            let starts = places.starts(column, row);
            let starts = starts.where_less(beside.abs(), inner, nowhere);
            let farther = rise * per_sine - (slope * on + tilt * beside);
            to.starts[k] = starts.lanes().map(f32::to_bits);
            to.beside[k] = beside.lanes();
            to.farther[k] = farther.lanes();
        }
        self.image.read(&to.starts, &mut to.off);
    }

    /// Estimates the axes from the pixels.
    #[inline(always)]
    fn look<S: Simd>(&mut self, simd: S) -> [Option<Found>; LANES] {
        let of = self.sections;
        let (zero, one) = (Floats::splat(simd, 0.0), Floats::splat(simd, 1.0));
        let ahead = Floats::of(simd, &of.ahead);
        let nothing = Floats::splat(simd, NOTHING);
        let sigma = Floats::of(simd, &of.sigma);
        let (radius, sine) = (Floats::of(simd, &of.radius), Floats::of(simd, &of.sine));
        let reach = radius + Floats::splat(simd, 5.0) * sigma;
        let stray = Floats::splat(simd, STRAY) * sigma;
        let (mut in_reach, mut sum) = (zero, zero);
        for (off, farther) in self.pixels.off.iter_mut().zip(&self.pixels.farther) {
            let measured = Floats::of(simd, off);
            let from = measured - ahead + Floats::of(simd, farther);
            let from = from.where_less(zero, measured, nothing);
            *off = from.lanes();
            in_reach = in_reach + one.where_less(from.abs(), reach, zero);
            sum = sum + from.where_less(from.abs(), reach, zero);
        }
        let pixels = &*self.pixels;
        let all = sum / in_reach;
        // Pixels behind an edge shift the first mean, and are left out of the next.
        let [count, sum] = pixels.sum(simd, all, stray);
        let near = all + (sum / count).where_less(zero, count, zero);
        let mut near = pixels.mean(simd, near, stray);
        for (about, gate) in [(all, stray), (zero, reach)] {
            let known = near.count.where_less(zero, in_reach, one);
            if known.least() > 0.0 {
                break;
            }
            near = near.or(simd, pixels.mean(simd, about, gate));
        }
        let inner = Floats::of(simd, &of.inner);
        let [first, last] = of.ends.map(|end| Floats::of(simd, &end));
        let wide = Floats::splat(simd, 2.0) * inner.max(Floats::splat(simd, 0.5));
        let pixels = wide * (last - first).max(one);
        let spread = near.squares / (near.count - one).max(one);
        let share =
            Floats::splat(simd, READ_ONCE).min(pixels * Floats::splat(simd, 1.0 / SAMPLES as f32));
        let alone = (share * near.count).max(one);
        let wrong = Floats::splat(simd, RADIUS_ERROR) * radius / sine;
        let ahead = (ahead + near.mean).lanes();
        let variance = (spread.max(sigma * sigma) / alone + wrong * wrong).lanes();
        let beside = (near.beside * Floats::of(simd, &of.mm_per_px) / radius).lanes();
        let count = near.count.lanes();
        let mut found = [None; LANES];
        for (k, found) in found.iter_mut().enumerate() {
            if count[k] > 0.0 {
                *found = Some(Found {
                    ahead: f64::from(ahead[k]),
                    variance: f64::from(variance[k]),
                    beside: f64::from(beside[k]),
                });
            }
        }
        found
    }
}

/// The pixels of some sections, place by place: for each place, the pixels of all sections.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pixels {
    /// Their offsets in the image.
    starts: [[u32; LANES]; SAMPLES],
    /// Their distances to the side of the axis, px.
    beside: [Lanes; SAMPLES],
    /// Distance ahead of the axis at the section's point, minus the depth measured at the pixel,
    /// mm.
    farther: [Lanes; SAMPLES],
    /// The measured depth, mm; later how much farther ahead the axis is than was assumed, or
    /// `NOTHING`.
    off: [Lanes; SAMPLES],
}

impl Pixels {
    pub(super) const NONE: Self = Self {
        starts: [[0; LANES]; SAMPLES],
        beside: [[0.0; LANES]; SAMPLES],
        farther: [[0.0; LANES]; SAMPLES],
        off: [[0.0; LANES]; SAMPLES],
    };

    /// Returns the number of values closer than `gate` to `about`, and the sum of their differences
    /// from it.
    #[inline(always)]
    fn sum<S: Simd>(&self, simd: S, about: Floats<S>, gate: Floats<S>) -> [Floats<S>; 2] {
        let (zero, one) = (Floats::splat(simd, 0.0), Floats::splat(simd, 1.0));
        let (mut count, mut sum) = (zero, zero);
        for off in &self.off {
            let from = Floats::of(simd, off) - about;
            count = count + one.where_less(from.abs(), gate, zero);
            sum = sum + from.where_less(from.abs(), gate, zero);
        }
        [count, sum]
    }

    /// Computes the mean of these values, and its statistics.
    #[inline(always)]
    fn mean<S: Simd>(&self, simd: S, about: Floats<S>, gate: Floats<S>) -> Mean<S> {
        let (zero, one) = (Floats::splat(simd, 0.0), Floats::splat(simd, 1.0));
        let (mut count, mut sum, mut squares, mut aside) = (zero, zero, zero, zero);
        for (off, beside) in self.off.iter().zip(&self.beside) {
            let from = Floats::of(simd, off) - about;
            let part = from.where_less(from.abs(), gate, zero);
            count = count + one.where_less(from.abs(), gate, zero);
            sum = sum + part;
            squares = squares + part * part;
            aside = aside + Floats::of(simd, beside).where_less(from.abs(), gate, zero);
        }
        Mean {
            count,
            mean: about + sum / count,
            beside: aside / count,
            squares: (squares - sum * sum / count).max(zero),
        }
    }
}

/// Mean of `count` numbers, sum of their squared differences from the mean, and mean distance of
/// their pixels to the side of the axis.
#[derive(Clone, Copy)]
struct Mean<S: Simd> {
    count: Floats<S>,
    mean: Floats<S>,
    beside: Floats<S>,
    squares: Floats<S>,
}

impl<S: Simd> Mean<S> {
    /// Uses another mean where this one is empty.
    #[inline(always)]
    fn or(self, simd: S, other: Self) -> Self {
        let zero = Floats::splat(simd, 0.0);
        Self {
            mean: self.mean.where_less(zero, self.count, other.mean),
            beside: self.beside.where_less(zero, self.count, other.beside),
            squares: self.squares.where_less(zero, self.count, other.squares),
            count: self.count.where_less(zero, self.count, other.count),
        }
    }
}
