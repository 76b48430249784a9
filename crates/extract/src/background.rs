//! The table's color everywhere, from the image alone.
//!
//! A rope covers a small share of the pixels, so the table is what most of a sparse grid of pixels
//! agrees on: a quadratic surface per channel (light falls off smoothly over a table, and lenses
//! vignette), fitted by least squares again and again to the pixels that lie within a few times the
//! median residual. Up to about 40% of the samples may be rope.

mod counts;
mod sums;

use crate::Image;
use crate::color;
use counts::Counts;
use pulp::{Arch, Simd, WithSimd};
use sums::{Sum, cholesky, solve};

/// Samples along each side of the grid: enough for six coefficients and a sharp median, few enough
/// to cost less than one pass over a 640×480 image.
const GRID: usize = 64;
const ROUNDS: usize = 8;
/// Samples farther than this many median residuals from the surface are taken for rope.
const OUTLIER: f32 = 3.0;
/// The terms of the surface: 1, u, v, u², uv, v².
const TERMS: usize = 6;
/// Samples that are worked on side by side.
const LANES: usize = 16;
/// Residuals are counted in sixteenths of a level, finer than anything made of their median, up to one beyond which no
/// rope would stand out.
const STEPS: f32 = 16.0;
const BINS: usize = 64 * STEPS as usize;
/// Rows of the grid from one to the next of which the table's first guess is made.
const GLANCE: usize = 4;

type Lanes = [f32; LANES];

/// Memory of the fit and its result.
#[derive(Debug, Default)]
pub(crate) struct Background {
    /// The pixels of the grid's columns, and their positions from −1 to 1, filled up to whole lanes.
    x: Vec<usize>,
    u: Vec<Lanes>,
    /// The same of its rows.
    y: Vec<usize>,
    v: Vec<f32>,
    /// The samples of each channel, row by row.
    colors: [Vec<Lanes>; 3],
    /// How far each is off the surface; those that fill up a row are infinitely far.
    residuals: Vec<Lanes>,
    /// The same in steps.
    steps: Vec<[u32; LANES]>,
    coefficients: [[f32; TERMS]; 3],
    width: f32,
    height: f32,
    /// The median distance of the table's pixels from the surface, at least half a level.
    pub(crate) noise: f32,
}

impl Background {
    /// Fits the surface to `image`.
    pub(crate) fn estimate(&mut self, image: &Image) {
        self.lay_grid(image.width(), image.height());
        self.take_samples(image);
        self.coefficients = [[0.0; TERMS]; 3];
        for channel in 0..3 {
            self.coefficients[channel][0] = self.median_level(channel);
        }
        let chroma = color::chroma_weight(image.format());
        // Every few rows show what is table; all of them how it is lit.
        let arch = Arch::new();
        let glance = self.measure(arch, GLANCE, chroma);
        let scale = self.refine(GLANCE, glance, chroma);
        self.take_residuals(arch, 1, chroma);
        self.noise = self.refine(1, scale, chroma).max(0.5);
    }

    /// Fits the surface, over and over, to the samples of every `stride`-th row of the grid that lie near it, at first
    /// within a few times `scale`, the median residual. Returns the new one.
    fn refine(&mut self, stride: usize, mut scale: f32, chroma: f32) -> f32 {
        let arch = Arch::new();
        for _ in 0..ROUNDS {
            if !self.fit(arch, stride, OUTLIER * scale.max(0.7)) {
                break;
            }
            let before = std::mem::replace(&mut scale, self.measure(arch, stride, chroma));
            if (scale - before).abs() < 0.02 * before {
                break;
            }
        }
        scale
    }

    /// The table's color at a pixel.
    pub(crate) fn at(&self, x: usize, y: usize) -> [f32; 3] {
        let (u, v) = (unit(x as f32, self.width), unit(y as f32, self.height));
        self.coefficients.map(|c| surface(&along_row(&c, v), u))
    }

    /// The same for kernels, that have numbers of the same kind for everything.
    #[inline(always)]
    pub(crate) fn at_place(&self, [x, y]: [f32; 2]) -> [f32; 3] {
        let (u, v) = (unit(x, self.width), unit(y, self.height));
        let level = |c: &[f32; TERMS]| surface(&along_row(c, v), u);
        let [a, b, c] = &self.coefficients;
        // No `map`: it would not be compiled for the kernel's machine.
        [level(a), level(b), level(c)]
    }

    /// The table's color at each of some pixels in whole levels, a byte each in a word.
    #[inline(always)]
    pub(crate) fn at_all<const N: usize>(&self, x: &[f32; N], y: &[f32; N], out: &mut [u32; N]) {
        for i in 0..N {
            let (u, v) = (unit(x[i], self.width), unit(y[i], self.height));
            let [a, b, c] = &self.coefficients;
            let level = |c: &[f32; TERMS]| rounded(surface(&along_row(c, v), u), 255.0);
            out[i] = level(a) | level(b) << 8 | level(c) << 16;
        }
    }

    /// The table's levels along a row, from pixel [x, y] on, one for each block of pixels, taken in its middle.
    pub(crate) fn row(&self, [x, y]: [usize; 2], block: usize, out: [&mut [u8]; 3]) {
        let v = unit(y as f32, self.height);
        let middle = unit(x as f32 + 0.5 * (block - 1) as f32, self.width);
        let step = 2.0 * block as f32 / self.width;
        for (levels, c) in out.into_iter().zip(&self.coefficients) {
            Arch::new().dispatch(AlongRow {
                surface: along_row(c, v),
                middle,
                step,
                levels,
            });
        }
    }

    fn lay_grid(&mut self, width: usize, height: usize) {
        (self.width, self.height) = (width as f32, height as f32);
        let place = |i: usize, count: usize, side: usize| (2 * i + 1) * side / (2 * count);
        let (columns, rows) = (GRID.min(width), GRID.min(height));
        self.x.clear();
        self.x
            .extend((0..columns).map(|i| place(i, columns, width)));
        self.y.clear();
        self.y.extend((0..rows).map(|j| place(j, rows, height)));
        let groups = columns.div_ceil(LANES);
        self.u.resize(groups, [0.0; LANES]);
        for (u, &x) in self.u.as_flattened_mut().iter_mut().zip(&self.x) {
            *u = unit(x as f32, self.width);
        }
        self.v.clear();
        let (height, y) = (self.height, &self.y);
        self.v.extend(y.iter().map(|&y| unit(y as f32, height)));
        for plane in self.colors.iter_mut().chain([&mut self.residuals]) {
            plane.resize(groups * rows, [0.0; LANES]);
        }
        self.steps.resize(groups * rows, [0; LANES]);
    }

    fn take_samples(&mut self, image: &Image) {
        let groups = self.u.len();
        for (j, &y) in self.y.iter().enumerate() {
            let [a, b, c] = self
                .colors
                .each_mut()
                .map(|plane| plane[j * groups..][..groups].as_flattened_mut());
            color::at_places(image, y, &self.x, |i, pixel| {
                (a[i], b[i], c[i]) = (pixel[0].into(), pixel[1].into(), pixel[2].into());
            });
        }
    }

    /// The middle level of a channel, at a glance.
    fn median_level(&self, channel: usize) -> f32 {
        let (columns, groups) = (self.x.len(), self.u.len());
        let mut counts = Counts::<256>::default();
        for row in self.colors[channel].chunks_exact(groups).step_by(GLANCE) {
            for (i, &level) in row.as_flattened()[..columns].iter().enumerate() {
                counts.add(i, level as usize);
            }
        }
        counts.middle() as f32
    }

    /// Finds how far the samples are off the surface; returns the median.
    fn measure(&mut self, arch: Arch, stride: usize, chroma: f32) -> f32 {
        self.take_residuals(arch, stride, chroma);
        let groups = self.u.len();
        let columns = self.x.len();
        let mut counts = Counts::<BINS>::default();
        for row in self.steps.chunks_exact(groups).step_by(stride) {
            for (i, &step) in row.as_flattened()[..columns].iter().enumerate() {
                counts.add(i, step as usize);
            }
        }
        (counts.middle() as f32 + 0.5) / STEPS
    }

    /// Finds how far the samples are off the surface.
    fn take_residuals(&mut self, arch: Arch, stride: usize, chroma: f32) {
        arch.dispatch(Measure {
            stride,
            u: &self.u,
            v: &self.v,
            colors: &self.colors,
            coefficients: &self.coefficients,
            chroma,
            residuals: &mut self.residuals,
            steps: &mut self.steps,
        });
    }

    /// Least squares over the samples within `limit` of the surface. False when they do not
    /// determine it.
    fn fit(&mut self, arch: Arch, stride: usize, limit: f32) -> bool {
        // What fills up the rows counts for nothing.
        let (columns, groups) = (self.x.len(), self.u.len());
        for row in self.residuals.chunks_exact_mut(groups) {
            row.as_flattened_mut()[columns..].fill(f32::INFINITY);
        }
        let moments = arch.dispatch(Sum {
            stride,
            u: &self.u,
            v: &self.v,
            colors: &self.colors,
            residuals: &self.residuals,
            limit,
        });
        let Some(factor) = cholesky(moments.gram()) else {
            return false;
        };
        for (channel, c) in self.coefficients.iter_mut().enumerate() {
            *c = solve(&factor, moments.right(channel)).map(|v| v as f32);
        }
        true
    }
}

/// The surface along a row, as a polynomial of u.
#[inline(always)]
fn along_row(c: &[f32; TERMS], v: f32) -> [f32; 3] {
    [c[0] + v * (c[2] + v * c[5]), c[1] + v * c[4], c[3]]
}

#[inline(always)]
fn surface(row: &[f32; 3], u: f32) -> f32 {
    row[0] + u * (row[1] + u * row[2])
}

/// The surface along a row in whole levels, from `middle` on at each `step`.
struct AlongRow<'a> {
    surface: [f32; 3],
    middle: f32,
    step: f32,
    levels: &'a mut [u8],
}

impl WithSimd for AlongRow<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for (i, level) in self.levels.iter_mut().enumerate() {
            let u = self.middle + i as u32 as f32 * self.step;
            *level = rounded(surface(&self.surface, u), 255.0) as u8;
        }
    }
}

/// How far the samples are off the surface, by `color::distance`, and the same in steps.
struct Measure<'a> {
    /// Rows of the grid from one that counts to the next.
    stride: usize,
    u: &'a [Lanes],
    v: &'a [f32],
    colors: &'a [Vec<Lanes>; 3],
    coefficients: &'a [[f32; TERMS]; 3],
    chroma: f32,
    residuals: &'a mut [Lanes],
    steps: &'a mut [[u32; LANES]],
}

impl WithSimd for Measure<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let groups = self.u.len();
        for (j, &v) in self.v.iter().enumerate().step_by(self.stride) {
            let rows = self.coefficients.each_ref().map(|c| along_row(c, v));
            let [a, b, c] = self
                .colors
                .each_ref()
                .map(|plane| &plane[j * groups..][..groups]);
            let samples = self.u.iter().zip(a).zip(b).zip(c);
            let residuals = self.residuals[j * groups..][..groups].iter_mut();
            let steps = self.steps[j * groups..][..groups].iter_mut();
            for (((((u, a), b), c), residuals), steps) in samples.zip(residuals).zip(steps) {
                for lane in 0..LANES {
                    let off = |color: f32, row: &[f32; 3]| (color - surface(row, u[lane])).abs();
                    let [a, b, c] = [
                        off(a[lane], &rows[0]),
                        self.chroma * off(b[lane], &rows[1]),
                        self.chroma * off(c[lane], &rows[2]),
                    ];
                    let larger = |a: f32, b: f32| if a > b { a } else { b };
                    let residual = larger(a, larger(b, c));
                    residuals[lane] = residual;
                    steps[lane] = rounded(residual * STEPS - 0.5, BINS as f32 - 1.0);
                }
            }
        }
    }
}

/// The nearest whole number from 0 to `most`, which is below 2²³: where a float's last bit stands for 1.
#[inline(always)]
fn rounded(value: f32, most: f32) -> u32 {
    const ONES: f32 = 8_388_608.0;
    ((if value > 0.0 { value } else { 0.0 }).min(most) + ONES).to_bits() - ONES.to_bits()
}

/// A pixel's position on a scale from −1 to 1 across the image.
#[inline(always)]
fn unit(position: f32, side: f32) -> f32 {
    (position + 0.5) * (2.0 / side) - 1.0
}

/// The middle value (of an even number the upper one); 0 of nothing.
pub(crate) fn median(values: &mut [f32]) -> f32 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f32::total_cmp).1
}
