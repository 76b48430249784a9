//! A rope's difference from the table along a line. A section's contrast is the mean over its
//! middle. The contrast at a sample is the median of sections within three widths to either side,
//! so that a single speck of shine has no effect.

use std::ops::Range;

use lariat_portable::Simd;

use super::line::Line;
use super::section::Measure;
use crate::image::gray::GrayPlane;
use crate::image::ray::{LANES, Rays};
use crate::statistics::medians;

/// Positions across the rope, in half-widths, whose mean is a section's contrast.
const MIDDLE: [f32; 5] = [-0.5, -0.25, 0.0, 0.25, 0.5];
/// Reach of the median to either side, in half-widths, its minimum in samples, and the approximate
/// number of places read within it.
const AROUND_HALVES: f32 = 6.0;
const AROUND: usize = 4;
const PLACES: usize = 6;
/// Maximum number of places in one median. With 12 samples or more to either side, only every
/// second is read.
const MOST: usize = 4 * PLACES - 1;
/// Minimum contrast of a rope, in levels.
const LEAST: f32 = 2.0;

/// Memory and result of the step.
#[derive(Debug, Default)]
pub(crate) struct Contrast {
    /// Only every `stride`-th sample is read.
    stride: usize,
    /// The range of samples read, in strides, and the contrast at each.
    places: Range<usize>,
    seen: Vec<f32>,
    /// The contrast at each place, or ∞ inside of crossings and beyond both ends.
    shown: Vec<f32>,
    medians: Vec<f32>,
}

impl Contrast {
    /// Makes the buffers for lines of this many samples.
    pub(crate) fn reserve(&mut self, samples: usize) {
        self.seen.reserve(samples);
        self.shown.reserve(samples + LANES + 2 * MOST);
        self.medians.reserve(samples + LANES);
    }

    /// Number of samples to either side that count at a place, and the step between those that are
    /// read.
    pub(crate) fn reach(how: Measure) -> (usize, usize) {
        let reach = ((AROUND_HALVES * how.half_px / how.step_px) as usize).max(AROUND);
        (reach, (reach / PLACES).max(1))
    }

    /// Measures the samples of `part`, and those around it.
    #[inline(always)]
    pub(crate) fn measure<S: Simd>(
        &mut self,
        simd: S,
        line: &Line,
        difference: &GrayPlane,
        how: Measure,
        part: &Range<usize>,
    ) {
        let (reach, stride) = Self::reach(how);
        let around = reach / stride;
        self.stride = stride;
        let all = line.samples.len().div_ceil(stride);
        let first = (part.start / stride).saturating_sub(around);
        self.places = first..(part.end.div_ceil(stride) + around + 1).min(all);
        self.look(line, difference, how);
        self.shown.clear();
        self.shown.resize(around, f32::INFINITY);
        let shown = self.places.clone().zip(&self.seen).map(|(k, &level)| {
            let is_shown = line.samples[k * stride].weight > 0.0;
            if is_shown { level } else { f32::INFINITY }
        });
        self.shown.extend(shown);
        let filled = self.places.len().next_multiple_of(LANES) + 2 * around;
        self.shown.resize(filled, f32::INFINITY);
        self.find_medians(simd, 2 * around + 1);
    }

    /// The median around sample `i`.
    #[inline(always)]
    pub(crate) fn at(&self, i: usize) -> f32 {
        let k = (i + self.stride / 2) as u32 / self.stride as u32;
        let last = self.medians.len() - 1;
        self.medians[(k as usize - self.places.start).min(last)]
    }

    #[inline(always)]
    fn look(&mut self, line: &Line, difference: &GrayPlane, how: Measure) {
        let tangent_reach = how.tangent_reach();
        let far = MIDDLE.map(|k| [k * how.half_px; LANES]);
        let (mut rays, mut values) = (Rays::default(), [[0.0; LANES]; MIDDLE.len()]);
        self.seen.clear();
        for first in self.places.clone().step_by(LANES) {
            let count = (self.places.end - first).min(LANES);
            for l in 0..count {
                let i = (first + l) * self.stride;
                rays.lay(l, line.samples[i].at, line.slope(i, tangent_reach));
            }
            rays.unify();
            rays.read(difference, &far, &mut values);
            let inside = rays.are_inside(difference, how.half_px);
            let mut means = [0.0; LANES];
            for row in &values {
                for l in 0..LANES {
                    means[l] += row[l] * (1.0 / MIDDLE.len() as f32);
                }
            }
            for l in (0..count).filter(|&l| !inside[l]) {
                let (from, along) = rays.line(l);
                let places = MIDDLE.map(|k| k * how.half_px);
                let values = difference.sample_each(from, along, places);
                means[l] = values.iter().sum::<f32>() / MIDDLE.len() as f32;
            }
            self.seen.extend_from_slice(&means[..count]);
        }
    }

    /// Fills `medians` with the median of the `width` places around each place.
    #[inline(always)]
    fn find_medians<S: Simd>(&mut self, simd: S, width: usize) {
        let width = width.min(MOST);
        self.medians.clear();
        for first in (0..self.seen.len()).step_by(LANES) {
            let mut rows = [[f32::INFINITY; LANES]; MOST];
            let mut counts = [0u32; LANES];
            for (k, row) in rows[..width].iter_mut().enumerate() {
                row.copy_from_slice(&self.shown[first + k..][..LANES]);
                for l in 0..LANES {
                    counts[l] += u32::from(row[l] < f32::INFINITY);
                }
            }
            let medians = medians(simd, &mut rows[..width], &counts);
            let seen = &self.seen[first..];
            let found = medians.iter().zip(seen).zip(&counts);
            self.medians.extend(found.map(|((median, seen), count)| {
                let level = if *count == 0 { seen } else { median };
                level.max(LEAST)
            }));
        }
    }
}
