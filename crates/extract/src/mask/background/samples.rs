//! Samples of the grid, and their distances from the table's surface.

use super::{GRID, LANES, Lanes, TERMS, along_row, rounded};
use lariat_portable::{Simd, WithSimd};

/// Number of steps per level in which residuals are counted, finer than anything that depends on
/// their median. With a median above the maximum, no rope would stand out.
pub(super) const STEPS: f32 = 16.0;
pub(super) const MOST_STEPS: u16 = 64 * STEPS as u16 - 1;

/// Samples of some rows of the grid, in `N` channels, and the surface that they are compared with.
#[derive(Clone, Copy)]
pub(super) struct Samples<'a, const N: usize> {
    /// Step between the rows of the grid that count.
    pub(super) stride: usize,
    /// Samples in a row. The row is padded to whole lanes.
    pub(super) columns: usize,
    pub(super) u: &'a [Lanes],
    pub(super) v: &'a [f32],
    /// Channels of each sample as the bytes of a number, the first channel in the lowest byte.
    pub(super) pixels: &'a [[u32; LANES]],
    pub(super) coefficients: &'a [[f32; TERMS]; 3],
    /// Weight of a difference of the second and third channel.
    pub(super) chroma: f32,
}

/// A row of the grid in the widest registers, and the surface along it.
pub(super) struct Row<'a, S: Simd, const N: usize> {
    simd: S,
    pub(super) u: &'a [S::f32s],
    pixels: &'a [S::u32s],
    surfaces: [[S::f32s; 3]; N],
    chroma: S::f32s,
}

impl<'a, const N: usize> Samples<'a, N> {
    /// Indices of the rows that count, and their positions.
    #[inline(always)]
    pub(super) fn rows(&self) -> impl Iterator<Item = (usize, &'a f32)> + use<'a, N> {
        self.v.iter().enumerate().step_by(self.stride)
    }

    /// Row `j`, whose position is `v`.
    #[inline(always)]
    pub(super) fn row<S: Simd>(&self, simd: S, j: usize, v: f32) -> Row<'a, S, N> {
        let groups = self.u.len().min(GRID / LANES);
        let pixels = &self.pixels[j * self.u.len()..][..groups];
        let mut surfaces = [[simd.splat_f32s(0.0); 3]; N];
        for (surface, c) in surfaces.iter_mut().zip(self.coefficients) {
            for (term, c) in surface.iter_mut().zip(along_row(c, v)) {
                *term = simd.splat_f32s(c);
            }
        }
        Row {
            simd,
            u: S::as_simd_f32s(self.u[..groups].as_flattened()).0,
            pixels: S::as_simd_u32s(pixels.as_flattened()).0,
            surfaces,
            chroma: simd.splat_f32s(self.chroma),
        }
    }
}

impl<S: Simd, const N: usize> Row<'_, S, N> {
    /// Levels of the `i`-th samples, and their distance from the surface: the largest of all
    /// channels, as in `color::distance`.
    #[inline(always)]
    pub(super) fn at(&self, i: usize) -> ([S::f32s; N], S::f32s) {
        // A whole number below 2²³ that is written into the last bits of this float adds to its
        // value.
        const ONES: f32 = 8_388_608.0;
        let simd = self.simd;
        let (u, pixels) = (self.u[i], self.pixels[i]);
        let (byte, ones) = (simd.splat_u32s(0xFF), simd.splat_f32s(ONES));
        let mut colors = [ones; N];
        let mut residual = simd.splat_f32s(0.0);
        for (channel, (color, [a, b, c])) in colors.iter_mut().zip(self.surfaces).enumerate() {
            let shift = simd.splat_u32s(8 * channel as u32);
            let level = simd.and_u32s(simd.wrapping_dyn_shr_u32s(pixels, shift), byte);
            let level = simd.or_u32s(level, simd.transmute_u32s_f32s(ones));
            *color = simd.sub_f32s(simd.transmute_f32s_u32s(level), ones);
            let surface = simd.mul_add_f32s(u, simd.mul_add_f32s(u, c, b), a);
            let mut off = simd.abs_f32s(simd.sub_f32s(*color, surface));
            if channel > 0 {
                off = simd.mul_f32s(self.chroma, off);
            }
            residual = simd.max_f32s(residual, off);
        }
        (colors, residual)
    }
}

/// Computes the distances of the samples from the surface, in steps. Returns their number.
pub(super) struct Measure<'a, const N: usize> {
    pub(super) samples: Samples<'a, N>,
    pub(super) steps: &'a mut [u16],
}

impl<const N: usize> WithSimd for Measure<'_, N> {
    type Output = usize;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> usize {
        let columns = self.samples.columns.min(GRID);
        let mut count = 0;
        for (j, &v) in self.samples.rows() {
            let row = self.samples.row(simd, j, v);
            let mut residuals = [0.0; GRID];
            for (i, to) in S::as_mut_simd_f32s(&mut residuals).0.iter_mut().enumerate() {
                if i < row.u.len() {
                    *to = row.at(i).1;
                }
            }
            let steps = &mut self.steps[count..][..columns];
            for (step, residual) in steps.iter_mut().zip(&residuals) {
                *step = rounded(residual * STEPS - 0.5, f32::from(MOST_STEPS)) as u16;
            }
            count += columns;
        }
        count
    }
}

/// Collects the levels of one channel of the samples. Returns their number.
pub(super) struct Levels<'a, const N: usize> {
    pub(super) samples: Samples<'a, N>,
    pub(super) channel: usize,
    pub(super) levels: &'a mut [u16],
}

impl<const N: usize> WithSimd for Levels<'_, N> {
    type Output = usize;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> usize {
        let (groups, columns) = (self.samples.u.len(), self.samples.columns);
        let mut count = 0;
        for (j, _) in self.samples.rows() {
            let pixels = &self.samples.pixels[j * groups..][..groups];
            let pixels = &pixels.as_flattened()[..columns];
            for (level, pixel) in self.levels[count..][..columns].iter_mut().zip(pixels) {
                *level = (pixel >> (8 * self.channel) & 0xFF) as u16;
            }
            count += columns;
        }
        count
    }
}
