//! All of a section's inside, read at places of a fixed pattern: what it says of the axis.

use super::floats::{Floats, LANES};
use super::sections::Sections;
use crate::depth::image::DepthImage;
use lariat_portable::{Simd, WithSimd};

/// Places in a section where its pixels are read.
const SAMPLES: usize = 32;
const VECTORS: usize = SAMPLES / LANES;
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
pub(super) struct Look<'a> {
    pub(super) image: &'a DepthImage<'a>,
    pub(super) sections: &'a Sections,
    /// Room.
    pub(super) pixels: &'a mut [Pixels; LANES],
}

impl WithSimd for Look<'_> {
    type Output = [Option<Found>; LANES];

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) -> Self::Output {
        // First all are read, as what is read one by one can be taken up together only a while later.
        for k in 0..LANES {
            if self.sections.inner[k] > 0.0 {
                self.read(simd, k);
            }
        }
        let mut found = [None; LANES];
        for (k, found) in found.iter_mut().enumerate() {
            if self.sections.inner[k] > 0.0 {
                *found = self.look(simd, k);
            }
        }
        found
    }
}

impl Look<'_> {
    /// What the `k`-th section's pixels say of its axis.
    #[inline(always)]
    fn look<S: Simd>(&self, simd: S, k: usize) -> Option<Found> {
        let of = self.sections;
        let samples = self.samples(simd, k);
        let sigma = of.sigma[k];
        let reach = of.radius[k] + 5.0 * sigma;
        let all = samples.middle(simd, 0.0, reach)?;
        // What is behind an edge takes the first mean with it, and is left out then.
        let near = samples.middle(simd, all, STRAY * sigma).unwrap_or(all);
        let near = (samples.mean(simd, near, STRAY * sigma))
            .or_else(|| samples.mean(simd, all, STRAY * sigma))
            .or_else(|| samples.mean(simd, 0.0, reach))?;
        // Of a narrow section the places fall on pixels beside it, too, which do not count.
        let pixels = 2.0 * of.inner[k].max(0.5) * (of.ends[1][k] - of.ends[0][k]).max(1.0);
        let spread = near.squares / (near.count - 1.0).max(1.0);
        let alone = (READ_ONCE.min(pixels / SAMPLES as f32) * near.count).max(1.0);
        let variance = spread.max(sigma * sigma) / alone;
        let wrong = RADIUS_ERROR * of.radius[k] / of.sine[k];
        Some(Found {
            ahead: f64::from(of.ahead[k]) + f64::from(near.mean),
            variance: f64::from(variance + wrong * wrong),
            beside: f64::from(near.beside * of.mm_per_px[k] / of.radius[k]),
        })
    }

    /// Reads the pixels of the `k`-th section.
    #[inline(always)]
    fn read<S: Simd>(&mut self, simd: S, k: usize) {
        let of = self.sections;
        let [first, last] = [of.ends[0][k], of.ends[1][k]];
        let middle = Floats::splat(simd, 0.5 * (first + last));
        let half = Floats::splat(simd, 0.5 * (last - first));
        let at_x = Floats::splat(simd, of.at[0][k]);
        let at_y = Floats::splat(simd, of.at[1][k]);
        let along_x = Floats::splat(simd, of.along[0][k]);
        let along_y = Floats::splat(simd, of.along[1][k]);
        let inner = Floats::splat(simd, of.inner[k]);
        let Pixels {
            columns,
            rows,
            measured,
        } = &mut self.pixels[k];
        for from in (0..SAMPLES).step_by(LANES) {
            let on = half * Floats::of(simd, &ALONG[from..]) + middle;
            let off = inner * Floats::of(simd, &ACROSS[from..]);
            let column = (at_x + (on * along_x - off * along_y)).rounded();
            let row = (at_y + (off * along_x + on * along_y)).rounded();
            columns[from..from + LANES].copy_from_slice(&column.lanes());
            rows[from..from + LANES].copy_from_slice(&row.lanes());
        }
        self.image.read(columns, rows, measured);
    }

    /// What they say of its axis, one by one.
    #[inline(always)]
    fn samples<S: Simd>(&self, simd: S, k: usize) -> Samples<S> {
        let (of, pixels) = (self.sections, &self.pixels[k]);
        let at_x = Floats::splat(simd, of.at[0][k]);
        let at_y = Floats::splat(simd, of.at[1][k]);
        let along_x = Floats::splat(simd, of.along[0][k]);
        let along_y = Floats::splat(simd, of.along[1][k]);
        let inner = Floats::splat(simd, of.inner[k]);
        let (zero, one) = (Floats::splat(simd, 0.0), Floats::splat(simd, 1.0));
        let about = Floats::splat(simd, of.ahead[k]);
        let slope = Floats::splat(simd, of.slope[k]);
        let tilt = Floats::splat(simd, of.tilt[k]);
        let per_px = Floats::splat(simd, of.beside_per_px[k]);
        let squared_radius = Floats::splat(simd, of.radius[k] * of.radius[k]);
        let per_sine = Floats::splat(simd, 1.0 / of.sine[k]);
        let mut samples = Samples {
            off: [zero; VECTORS],
            beside: [zero; VECTORS],
            counts: [zero; VECTORS],
        };
        for k in 0..VECTORS {
            let from = k * LANES;
            let x = Floats::of(simd, &pixels.columns[from..]) - at_x;
            let y = Floats::of(simd, &pixels.rows[from..]) - at_y;
            let measured = Floats::of(simd, &pixels.measured[from..]);
            let beside = y * along_x - x * along_y;
            let on = x * along_x + y * along_y;
            samples.beside[k] = beside;
            let from_axis = beside * per_px;
            let rise = (squared_radius - from_axis * from_axis).max(zero).sqrt();
            samples.off[k] = measured - about + rise * per_sine - (slope * on + tilt * beside);
            let is_inside = zero.where_less(inner, beside.abs(), one);
            samples.counts[k] = is_inside.where_less(zero, measured, zero);
        }
        samples
    }
}

/// A section's pixels: where they are in the image, and what is measured there, mm.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pixels {
    columns: [f32; SAMPLES],
    rows: [f32; SAMPLES],
    measured: [f32; SAMPLES],
}

impl Pixels {
    pub(super) const NONE: Self = Self {
        columns: [0.0; SAMPLES],
        rows: [0.0; SAMPLES],
        measured: [0.0; SAMPLES],
    };
}

/// What the pixels of a section say: how much farther ahead the axis is than it was taken for, mm, how far beside it they are, px, and
/// whether they count, 0 or 1.
struct Samples<S: Simd> {
    off: [Floats<S>; VECTORS],
    beside: [Floats<S>; VECTORS],
    counts: [Floats<S>; VECTORS],
}

impl<S: Simd> Samples<S> {
    /// The mean of what counts and is nearer than `gate` to `about`; `None` of nothing.
    #[inline(always)]
    fn middle(&self, simd: S, about: f32, gate: f32) -> Option<f32> {
        let (center, gate) = (Floats::splat(simd, about), Floats::splat(simd, gate));
        let zero = Floats::splat(simd, 0.0);
        let (mut count, mut sum) = (zero, zero);
        for k in 0..VECTORS {
            let from = self.off[k] - center;
            let near = self.counts[k].where_less(from.abs(), gate, zero);
            count = count + near;
            sum = sum + near * from;
        }
        let count = count.sum();
        (count != 0.0).then(|| about + sum.sum() / count)
    }

    /// The same, and what else is known of it.
    #[inline(always)]
    fn mean(&self, simd: S, about: f32, gate: f32) -> Option<Mean> {
        let (center, gate) = (Floats::splat(simd, about), Floats::splat(simd, gate));
        let zero = Floats::splat(simd, 0.0);
        let (mut count, mut sum, mut squares, mut aside) = (zero, zero, zero, zero);
        for k in 0..VECTORS {
            let from = self.off[k] - center;
            let near = self.counts[k].where_less(from.abs(), gate, zero);
            aside = near * self.beside[k] + aside;
            let part = near * from;
            count = count + near;
            sum = sum + part;
            squares = part * from + squares;
        }
        let count = count.sum();
        if count == 0.0 {
            return None;
        }
        let sum = sum.sum();
        Some(Mean {
            count,
            mean: about + sum / count,
            beside: aside.sum() / count,
            squares: (squares.sum() - sum * sum / count).max(0.0),
        })
    }
}

/// The mean of so many numbers, the sum of the squares of their distances from it, and the mean of how far beside the axis they are.
#[derive(Debug, Clone, Copy)]
struct Mean {
    count: f32,
    mean: f32,
    beside: f32,
    squares: f32,
}
