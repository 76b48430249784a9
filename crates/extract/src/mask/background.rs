//! The table's color at each place, from the image alone.
//!
//! A rope covers a small share of the pixels, so most pixels of a sparse grid show the table. Its
//! color is a quadratic surface per channel, because light falls off smoothly over a table and
//! lenses vignette. The surface is fitted repeatedly, by least squares, to the pixels within a few
//! median residuals of it. Up to about 40% of the samples may be rope.

mod middle;
mod samples;
mod sums;

use crate::image::{Image, PixelFormat, color};
use lariat_portable::{Arch, Simd, WithSimd};
use middle::Middle;
use samples::{Levels, MOST_STEPS, Measure, STEPS, Samples};
use sums::{Sum, cholesky, solve};

/// Samples along each side of the grid. They are enough for six coefficients and a sharp median,
/// and cost less than one pass over a 640×480 image.
const GRID: usize = 48;
const ROUNDS: usize = 8;
/// Samples farther than this many median residuals from the surface are treated as rope.
const OUTLIER: f32 = 3.0;
/// Number of terms of the surface: 1, u, v, u², uv, v².
const TERMS: usize = 6;
/// Samples that are processed in parallel.
const LANES: usize = 16;
/// Step between the rows of the grid that give the first estimate of the table.
const GLANCE: usize = 3;

type Lanes = [f32; LANES];

/// Memory of the fit and its result.
#[derive(Debug, Default)]
pub(crate) struct Background {
    /// The grid's columns in pixels, and their positions from −1 to 1, padded to whole lanes.
    x: Vec<usize>,
    u: Vec<Lanes>,
    /// The grid's rows in pixels, and their positions from −1 to 1.
    y: Vec<usize>,
    v: Vec<f32>,
    /// The samples row by row, padded to whole lanes.
    pixels: Vec<[u32; LANES]>,
    /// Values whose median is computed.
    steps: Vec<u16>,
    coefficients: [[f32; TERMS]; 3],
    width: f32,
    height: f32,
    /// Median distance of the table's pixels from the surface, at least half a level.
    pub(crate) noise: f32,
}

impl Background {
    /// Fits the surface to `image`.
    pub(crate) fn estimate(&mut self, image: &Image) {
        self.lay_grid(image.width(), image.height());
        self.take_samples(image);
        // All three channels of a gray picture are the same.
        if image.format() == PixelFormat::Gray8 {
            self.fit::<1>(1.0);
            self.coefficients = [self.coefficients[0]; 3];
        } else {
            self.fit::<3>(color::chroma_weight(image.format()));
        }
    }

    /// Fits the surface to the samples, which have `N` channels.
    fn fit<const N: usize>(&mut self, chroma: f32) {
        let arch = Arch::new();
        self.coefficients = [[0.0; TERMS]; 3];
        for channel in 0..N {
            self.coefficients[channel][0] = self.median_level::<N>(arch, channel);
        }
        // A few rows are enough to tell which samples are table. The light is then fitted to all
        // rows.
        let glance = self.measure::<N>(arch, GLANCE, chroma);
        let scale = self.refine::<N>(arch, GLANCE, glance, chroma);
        self.noise = self.refine::<N>(arch, 1, scale, chroma).max(0.5);
    }

    /// Fits the surface repeatedly to the samples near it, from every `stride`-th row of the grid.
    /// The first fit takes the samples within a few times `scale`, the median residual. Returns the
    /// new median residual.
    fn refine<const N: usize>(
        &mut self,
        arch: Arch,
        stride: usize,
        mut scale: f32,
        chroma: f32,
    ) -> f32 {
        for _ in 0..ROUNDS {
            if !self.solve::<N>(arch, stride, chroma, OUTLIER * scale.max(0.7)) {
                break;
            }
            let before = std::mem::replace(&mut scale, self.measure::<N>(arch, stride, chroma));
            if (scale - before).abs() < 0.02 * before {
                break;
            }
        }
        scale
    }

    /// The table's color at a pixel.
    #[inline]
    pub(crate) fn at(&self, x: usize, y: usize) -> [f32; 3] {
        self.at_place([x as f32, y as f32])
    }

    /// The table's color at some pixels of a row, one channel after the other.
    #[inline(always)]
    pub(crate) fn at_each(&self, xs: &[usize], y: usize, out: [&mut [f32]; 3]) {
        let v = unit(y as f32, self.height);
        for (out, c) in out.into_iter().zip(&self.coefficients) {
            let row = along_row(c, v);
            for (out, &x) in out.iter_mut().zip(xs) {
                *out = surface(&row, unit(x as f32, self.width));
            }
        }
    }

    /// The table's color at a position. For kernels, which use one type of number for everything.
    #[inline(always)]
    pub(crate) fn at_place(&self, [x, y]: [f32; 2]) -> [f32; 3] {
        let (u, v) = (unit(x, self.width), unit(y, self.height));
        let level = |c: &[f32; TERMS]| surface(&along_row(c, v), u);
        let [a, b, c] = &self.coefficients;
        // No `map`: it would not be compiled for the kernel's machine.
        [level(a), level(b), level(c)]
    }

    /// The table's color at some pixels in whole levels, one byte per channel in a word.
    #[inline(always)]
    pub(crate) fn at_all<const N: usize>(&self, x: &[f32; N], y: &[f32; N], out: &mut [u32; N]) {
        for i in 0..N {
            let (u, v) = (unit(x[i], self.width), unit(y[i], self.height));
            let [a, b, c] = &self.coefficients;
            let level = |c: &[f32; TERMS]| rounded(surface(&along_row(c, v), u), 255.0);
            out[i] = level(a) | level(b) << 8 | level(c) << 16;
        }
    }

    /// The table's levels along a row from pixel [x, y], one per block of pixels, at the block's
    /// middle.
    pub(crate) fn row(&self, [x, y]: [usize; 2], block: usize, out: [&mut [u8]; 3]) {
        let v = unit(y as f32, self.height);
        Arch::new().dispatch(AlongRow {
            surfaces: self.coefficients.map(|c| along_row(&c, v)),
            middle: unit(x as f32 + 0.5 * (block - 1) as f32, self.width),
            step: 2.0 * block as f32 / self.width,
            levels: out,
        });
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
        self.pixels.resize(groups * rows, [0; LANES]);
        self.steps.resize(columns * rows, 0);
    }

    fn take_samples(&mut self, image: &Image) {
        let groups = self.u.len();
        for (pixels, &y) in self.pixels.chunks_exact_mut(groups).zip(&self.y) {
            color::at_places(image, y, self.x.iter().copied(), pixels.as_flattened_mut());
        }
    }

    /// The samples of every `stride`-th row with the surface they are compared with, and the memory
    /// for `steps`.
    fn samples<const N: usize>(
        &mut self,
        stride: usize,
        chroma: f32,
    ) -> (Samples<'_, N>, &mut Vec<u16>) {
        let samples = Samples {
            stride,
            columns: self.x.len(),
            u: &self.u,
            v: &self.v,
            pixels: &self.pixels,
            coefficients: &self.coefficients,
            chroma,
        };
        (samples, &mut self.steps)
    }

    /// Median level of a channel, from every [`GLANCE`]-th row.
    fn median_level<const N: usize>(&mut self, arch: Arch, channel: usize) -> f32 {
        let (samples, levels) = self.samples::<N>(GLANCE, 1.0);
        let count = arch.dispatch(Levels {
            samples,
            channel,
            levels,
        });
        let (values, most) = (&levels[..count], u16::from(u8::MAX));
        f32::from(arch.dispatch(Middle { values, most }))
    }

    /// Median distance of the samples from the surface.
    fn measure<const N: usize>(&mut self, arch: Arch, stride: usize, chroma: f32) -> f32 {
        let (samples, steps) = self.samples::<N>(stride, chroma);
        let count = arch.dispatch(Measure { samples, steps });
        let (values, most) = (&steps[..count], MOST_STEPS);
        (f32::from(arch.dispatch(Middle { values, most })) + 0.5) / STEPS
    }

    /// Fits the surface by least squares to the samples within `limit` of it. Returns false if they
    /// do not determine it.
    fn solve<const N: usize>(
        &mut self,
        arch: Arch,
        stride: usize,
        chroma: f32,
        limit: f32,
    ) -> bool {
        let (samples, _) = self.samples::<N>(stride, chroma);
        let moments = arch.dispatch(Sum { samples, limit });
        let Some(factor) = cholesky(moments.gram()) else {
            return false;
        };
        for (c, &right) in self.coefficients.iter_mut().zip(&moments.levels) {
            *c = solve(&factor, right).map(|v| v as f32);
        }
        true
    }
}

/// The surface along a row, as a polynomial in u.
#[inline(always)]
fn along_row(c: &[f32; TERMS], v: f32) -> [f32; 3] {
    [c[0] + v * (c[2] + v * c[5]), c[1] + v * c[4], c[3]]
}

#[inline(always)]
fn surface(row: &[f32; 3], u: f32) -> f32 {
    row[0] + u * (row[1] + u * row[2])
}

/// Computes the surfaces along a row in whole levels, from `middle` in steps of `step`.
struct AlongRow<'a> {
    surfaces: [[f32; 3]; 3],
    middle: f32,
    step: f32,
    levels: [&'a mut [u8]; 3],
}

impl WithSimd for AlongRow<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for (levels, row) in self.levels.into_iter().zip(&self.surfaces) {
            for (i, level) in levels.iter_mut().enumerate() {
                let u = self.middle + i as u32 as f32 * self.step;
                *level = rounded(surface(row, u), 255.0) as u8;
            }
        }
    }
}

/// Nearest whole number from 0 to `most`. `most` is below 2²³, where a float's last bit is worth 1.
#[inline(always)]
fn rounded(value: f32, most: f32) -> u32 {
    const ONES: f32 = 8_388_608.0;
    ((if value > 0.0 { value } else { 0.0 }).min(most) + ONES).to_bits() - ONES.to_bits()
}

/// Position of a pixel on a scale from −1 to 1 across the image.
#[inline(always)]
fn unit(position: f32, side: f32) -> f32 {
    (position + 0.5) * (2.0 / side) - 1.0
}
