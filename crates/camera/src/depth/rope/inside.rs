//! All of a section's inside, read at places of a fixed pattern: what it says of the axis.
//!
//! In a vector are as many sections as there are lanes, and the places come one after another: nothing is summed across lanes.

use super::floats::{Floats, LANES, Lanes};
use super::places::Places;
use super::sections::Sections;
use crate::depth::image::DepthImage;
use lariat_portable::{Simd, WithSimd};

/// Places in a section where its pixels are read.
const SAMPLES: usize = 32;
/// The share of them that fall on a pixel of their own, at most.
const READ_ONCE: f32 = 0.75;
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
const RADIUS_ERROR: f32 = 0.02;
/// What is this many standard deviations from the mean is another thing.
const STRAY: f32 = 2.5;

/// Farther off than anything: what a pixel says that does not count.
const NOTHING: f32 = 1e9;

/// What is read of an axis.
#[derive(Debug, Clone, Copy)]
pub(super) struct Found {
    /// How far ahead of the depth camera it is, and the variance of that.
    pub(super) ahead: f64,
    pub(super) variance: f64,
    /// How far beside the middle of what is seen of the rope it is, of the rope's half width.
    pub(super) beside: f64,
}

/// All of some sections' insides.
pub(super) struct InsideSampler<'a> {
    pub(super) image: &'a DepthImage<'a>,
    pub(super) sections: &'a Sections,
    /// Room.
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
    /// Reads the pixels. First all of them, as what is read one by one can be taken up together only a while later.
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
            // Of a narrow section the places fall on pixels beside it, too, which do not count.
            let starts = places.starts(column, row);
            let starts = starts.where_less(beside.abs(), inner, nowhere);
            let farther = rise * per_sine - (slope * on + tilt * beside);
            to.starts[k] = starts.lanes().map(f32::to_bits);
            to.beside[k] = beside.lanes();
            to.farther[k] = farther.lanes();
        }
        self.image.read(&to.starts, &mut to.off);
    }

    /// What the pixels say of the axes.
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
        // What is behind an edge takes the first mean with it, and is left out then.
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

/// The pixels of some sections, a place of all of them after the other.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pixels {
    /// Where they begin in the image.
    starts: [[u32; LANES]; SAMPLES],
    /// How far beside the axis they are, px.
    beside: [Lanes; SAMPLES],
    /// How much farther ahead than what is measured there the axis is at the section's point, mm.
    farther: [Lanes; SAMPLES],
    /// What is measured there, mm; then by that how much farther ahead than it was taken for the axis is, or `NOTHING`.
    off: [Lanes; SAMPLES],
}

impl Pixels {
    pub(super) const NONE: Self = Self {
        starts: [[0; LANES]; SAMPLES],
        beside: [[0.0; LANES]; SAMPLES],
        farther: [[0.0; LANES]; SAMPLES],
        off: [[0.0; LANES]; SAMPLES],
    };

    /// How many are nearer than `gate` to `about`, and the sum of their distances from it.
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

    /// Their mean, and what else is known of it.
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

/// The mean of so many numbers, the sum of the squares of their distances from it, and the mean of how far beside the axis they are.
#[derive(Clone, Copy)]
struct Mean<S: Simd> {
    count: Floats<S>,
    mean: Floats<S>,
    beside: Floats<S>,
    squares: Floats<S>,
}

impl<S: Simd> Mean<S> {
    /// Another where this is of nothing.
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
