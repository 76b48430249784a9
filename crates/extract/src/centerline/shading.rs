//! How a round rope darkens toward its edges, and so what share of its own contrast is left there.
//!
//! Under even and directed light together a cylinder shows, at the position u across it (−1 to 1), a + b·√(1 − u²) + d·u
//! (Lambert's law; d is light from the side). Fitted to the middle of the rope's mean cross-section, where no blur
//! reaches, this tells the contrast at its rim; the lens shows half of what lies within its blur of the rim, and that
//! level is the rope's true edge. Half of the contrast in the middle would draw a round rope too narrow by a third of
//! a pixel, and beside a lamp aside as well.

use lariat_portable::{Arch, Simd, WithSimd};

use super::line::Line;
use super::section::Measure;
use crate::image::gray::GrayPlane;
use crate::image::ray::{LANES, Lanes, Rays};

/// σ of the blur, lens and pixel together, is looked for in this range, in pixels.
const BLURS: std::ops::RangeInclusive<f32> = 0.5..=8.0;
/// Nearer to the edge than this many σ the blur reaches in: 0.6% of the table are left there.
const CLEAR: f32 = 2.5;
/// The fit reaches at least this far out. At 0.4 a round rope has darkened by 8%, well beyond what the blur leaves.
const LEAST_REACH: f32 = 0.4;
/// Distance between the samples across an edge, and how many there are inside and outside of it.
const HOP_PX: f32 = 0.5;
const INSIDE: usize = 24;
const OUTSIDE: usize = 8;
/// Places on either side that are read at once, and how many that makes across an edge.
const BATCH: usize = 4;
const PLACES: usize = (INSIDE + OUTSIDE + 1).next_multiple_of(BATCH);
/// Positions across half of the rope, those of the fit.
const POSITIONS: usize = 6;
/// Sections that are read along one rope: so many that a camera's noise of 4 levels adds less than one to their mean.
const SECTIONS: usize = 4 * LANES;
/// How far the share may lie from one half: a rim is never quite dark, nor twice as bright as the middle.
const SHARES: std::ops::RangeInclusive<f32> = 0.25..=0.75;

/// The share of the rope's contrast at which its edges lie, along the tangent's −normal and +normal side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shading {
    pub(crate) shares: [f32; 2],
}

impl Shading {
    /// A ribbon: as bright at its edges as in its middle.
    pub(crate) const FLAT: Self = Self { shares: [0.5; 2] };

    /// The shading of the rope along `line`, whose samples lie in its middle and have widths; flat when the rope is too
    /// narrow to tell.
    pub(crate) fn measure(line: &Line, difference: &GrayPlane, how: Measure) -> Self {
        let mut mean = Profile::new(how);
        Arch::new().dispatch(Reading {
            mean: &mut mean,
            line,
            difference,
            how,
        });
        let half_px = how.half_px;
        let blur_px = mean.blur();
        let most = (1.0 - CLEAR * blur_px / half_px).min(0.8);
        if most < LEAST_REACH {
            return Self::FLAT;
        }
        let position = |k: usize| most * (k as f32 - POSITIONS as f32) / POSITIONS as f32;
        let profile: [f32; 2 * POSITIONS + 1] = std::array::from_fn(|k| mean.at(position(k)));
        fit(&profile, position).map_or(Self::FLAT, |model| {
            Self::at_the_rim(model, half_px, blur_px)
        })
    }

    /// The levels at the rims of a rope shaded by [a, b, d], over its contrast.
    fn at_the_rim([a, b, d]: [f32; 3], half_px: f32, blur_px: f32) -> Self {
        // The mean of √(1 − u²) over the middle, as the contrast is measured: u = 0, ±¼, ±½.
        let contrast = a + b * (1.0 + 2.0 * 0.968_246 + 2.0 * 0.866_025) / 5.0;
        let (mut weight, mut within) = (0.0, [0.0; 2]);
        // The half of the blur that lies within the rope, to three σ.
        for k in 0..12 {
            let sigmas = 0.25 * (k as f32 + 0.5);
            let u = (1.0 - sigmas * blur_px / half_px).max(0.0);
            let w = libm::expf(-0.5 * sigmas * sigmas);
            let round = a + b * (1.0 - u * u).sqrt();
            weight += w;
            within[0] += w * (round - d * u);
            within[1] += w * (round + d * u);
        }
        let share =
            |sum: f32| (0.5 * sum / (weight * contrast)).clamp(*SHARES.start(), *SHARES.end());
        Self {
            shares: within.map(share),
        }
    }
}

/// The mean section of a rope: sums over some sections, at steps from either edge.
struct Profile {
    /// From the middle outward, the edge at `INSIDE`, along the −normal and the +normal side.
    levels: [[f32; PLACES]; 2],
    /// From where on these are known.
    first: usize,
    half_px: f32,
}

/// Sections that are read at once.
#[derive(Debug, Default)]
struct Group {
    rays: Rays,
    half_px: Lanes,
    count: usize,
}

/// What fills a profile, for the widest registers.
struct Reading<'a> {
    mean: &'a mut Profile,
    line: &'a Line,
    difference: &'a GrayPlane,
    how: Measure,
}

impl WithSimd for Reading<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.mean.read(self.line, self.difference, self.how);
    }
}

impl Profile {
    fn new(how: Measure) -> Self {
        let inside = ((how.half_px / HOP_PX) as usize + 1).min(INSIDE);
        Self {
            levels: [[0.0; PLACES]; 2],
            // Whole batches are read.
            first: (INSIDE - inside) / BATCH * BATCH,
            half_px: 0.0,
        }
    }

    /// Reads some of the line's sections outside of crossings, evenly spread.
    #[inline(always)]
    fn read(&mut self, line: &Line, difference: &GrayPlane, how: Measure) {
        let reach = how.tangent_reach();
        let stride = line.samples.len().div_ceil(SECTIONS).max(1);
        let mut group = Group::default();
        let mut count = 0;
        for (i, sample) in line.samples.iter().enumerate().step_by(stride) {
            if sample.weight >= 1.0 {
                let l = group.count;
                group.rays.lay(l, sample.at, line.slope(i, reach));
                group.half_px[l] = 0.5 * sample.width_px;
                self.half_px += group.half_px[l];
                (group.count, count) = (l + 1, count + 1);
                if group.count == LANES {
                    self.add(&mut group, difference);
                }
            }
        }
        if group.count > 0 {
            self.add(&mut group, difference);
        }
        self.half_px /= count.max(1) as f32;
    }

    /// Adds the sections of the group, and empties it.
    #[inline(always)]
    fn add(&mut self, group: &mut Group, difference: &GrayPlane) {
        group.rays.unify();
        let count = std::mem::take(&mut group.count);
        let widest_px = group.half_px[..count]
            .iter()
            .fold(0.0, |a, &b| f32::max(a, b));
        let reach_px = widest_px + HOP_PX * (PLACES - INSIDE) as f32;
        let inside = group.rays.are_inside(difference, reach_px);
        let (mut far, mut values) = ([[0.0; LANES]; 2 * BATCH], [[0.0; LANES]; 2 * BATCH]);
        for first in (self.first..PLACES).step_by(BATCH) {
            let (left, right) = far.split_at_mut(BATCH);
            for (k, (left, right)) in left.iter_mut().zip(right).enumerate() {
                let beyond_px = HOP_PX * ((first + k) as f32 - INSIDE as f32);
                for l in 0..LANES {
                    let out = (group.half_px[l] + beyond_px).max(0.0);
                    (left[l], right[l]) = (-out, out);
                }
            }
            group.rays.read(difference, &far, &mut values);
            for l in (0..count).filter(|&l| !inside[l]) {
                let (from, along) = group.rays.line(l);
                for (values, far) in values.iter_mut().zip(&far) {
                    [values[l]] = difference.sample_each(from, along, [far[l]]);
                }
            }
            for (k, row) in values.iter().enumerate() {
                self.levels[k / BATCH][first + k % BATCH] += row[..count].iter().sum::<f32>();
            }
        }
    }

    /// The sum at a position across the rope, −1 to 1.
    fn at(&self, u: f32) -> f32 {
        let levels = &self.levels[usize::from(u > 0.0)];
        let hops = (1.0 - u.abs()) * self.half_px / HOP_PX;
        let place = (INSIDE as f32 - hops).max(self.first as f32);
        let k = (place as usize).min(INSIDE);
        levels[k] + (place - k as f32) * (levels[k + 1] - levels[k])
    }

    /// σ of the blur in pixels, from the mean fall of the difference across the rope's edges: a blurred step of height h
    /// has the slope h / (σ√(2π)) in its middle.
    fn blur(&self) -> f32 {
        let [left, right] = &self.levels;
        let levels: [f32; INSIDE + OUTSIDE + 1] =
            std::array::from_fn(|k| left[k.max(self.first)] + right[k.max(self.first)]);
        let slopes = levels.windows(3).map(|l| (l[0] - l[2]) / (2.0 * HOP_PX));
        let steepest = slopes.fold(1e-3, f32::max);
        let mut sigma_px = *BLURS.start();
        // The step's height is read where the blur ends, which the height itself tells.
        for _ in 0..4 {
            let inside = ((CLEAR * sigma_px / HOP_PX) as usize + 1).min(INSIDE);
            let height = levels[INSIDE - inside] - levels[INSIDE + OUTSIDE];
            sigma_px = height / ((2.0 * std::f32::consts::PI).sqrt() * steepest);
            sigma_px = sigma_px.clamp(*BLURS.start(), *BLURS.end());
        }
        sigma_px
    }
}

/// Least squares of a + b·√(1 − u²) + d·u over symmetric positions, where the last term stands by itself.
fn fit(profile: &[f32], position: impl Fn(usize) -> f32) -> Option<[f32; 3]> {
    let n = profile.len() as f32;
    let (mut sum_c, mut sum_cc, mut sum_uu) = (0.0, 0.0, 0.0);
    let (mut sum_y, mut sum_cy, mut sum_uy) = (0.0, 0.0, 0.0);
    for (k, &y) in profile.iter().enumerate() {
        let u = position(k);
        let c = (1.0 - u * u).sqrt();
        (sum_c, sum_cc, sum_uu) = (sum_c + c, sum_cc + c * c, sum_uu + u * u);
        (sum_y, sum_cy, sum_uy) = (sum_y + y, sum_cy + c * y, sum_uy + u * y);
    }
    let b = (n * sum_cy - sum_c * sum_y) / (n * sum_cc - sum_c * sum_c);
    let a = (sum_y - b * sum_c) / n;
    (sum_y > 0.0 && b.is_finite()).then_some([a, b, sum_uy / sum_uu])
}
