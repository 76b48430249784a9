//! The darkening of a round rope toward its edges, and the share of its contrast that is left
//! there.
//!
//! Under even and directed light together, a cylinder shows a + b·√(1 − u²) + d·u at the position u
//! across it (−1 to 1). This is Lambert's law; d is light from the side. The law is fitted to the
//! middle of the rope's mean cross-section, where no blur reaches, and yields the contrast at the
//! rim. At the rope's true edge, the lens shows half of the contrast that the rope has within the
//! blur's reach, so this level marks the edge. Half of the contrast at the middle would draw a
//! round rope too narrow by a third of a pixel, and off its axis if the lamp is at one side.
//!
//! When a rope turns, the lamp is on its other side. Therefore d depends on the normal as D·n, and
//! D is fitted to all sections. With a single d, a loop would be up to a pixel off its axis, to the
//! left on one side and to the right on the other.

use lariat_portable::{Arch, Simd, WithSimd};

use super::line::Line;
use super::section::Measure;
use crate::image::gray::GrayPlane;
use crate::image::ray::{LANES, Lanes, Rays};
use crate::vec2::{self, Vec2};

/// Range searched for σ of the blur, lens and pixel together, in pixels.
const BLURS: std::ops::RangeInclusive<f32> = 0.5..=8.0;
/// Distance from the edge, in σ, up to which blur reaches: 0.6 % of the table is left there.
const CLEAR: f32 = 2.5;
/// Minimum reach of the fit. At 0.4 a round rope has darkened by 8 %, well beyond what the blur
/// leaves.
const LEAST_REACH: f32 = 0.4;
/// Distance between the samples across an edge, and their number inside and outside of it.
const HOP_PX: f32 = 0.5;
const INSIDE: usize = 24;
const OUTSIDE: usize = 8;
/// Number of places read at once on either side, and the resulting number across an edge.
const BATCH: usize = 4;
const PLACES: usize = (INSIDE + OUTSIDE + 1).next_multiple_of(BATCH);
/// Number of positions across half of the rope, for the fit.
const POSITIONS: usize = 6;
/// Maximum number of sections read along a rope. With this many, camera noise of 4 levels adds less
/// than one level to their mean.
const SECTIONS: usize = 4 * LANES;
/// Ridge term, as a share of all sections. Light from the side that cannot be determined, as along
/// a straight rope, is assumed to be small.
const LITTLE: f32 = 1e-3;
/// Minimum share of the difference between the sides that a lamp explains. A smaller share means
/// shine, or an adjacent shadow that was measured as part of the rope.
const LIKE_A_LAMP: f32 = 0.9;
/// Limits of the share, around one half: a rim is never quite dark, nor twice as bright as the
/// middle.
const SHARES: std::ops::RangeInclusive<f32> = 0.25..=0.75;

/// The share of the rope's contrast at which its edges are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shading {
    /// Mean of both sides.
    share: f32,
    /// Excess on the side toward the light, by that side's normal.
    lit: Vec2,
}

impl Shading {
    /// A ribbon, as bright at its edges as in its middle.
    pub(crate) const FLAT: Self = Self {
        share: 0.5,
        lit: [0.0; 2],
    };

    /// The levels of the edges of sections with these normals and contrasts, on the −normal and the
    /// +normal side.
    #[inline(always)]
    pub(crate) fn levels(&self, normals: &[Lanes; 2], contrasts: &Lanes) -> [Lanes; 2] {
        let mut levels = [[0.0; LANES]; 2];
        for l in 0..LANES {
            let lit = self.lit[0] * normals[0][l] + self.lit[1] * normals[1][l];
            for (levels, lit) in levels.iter_mut().zip([-lit, lit]) {
                let share = (self.share + lit).clamp(*SHARES.start(), *SHARES.end());
                levels[l] = share * contrasts[l];
            }
        }
        levels
    }

    /// The shading of the rope along `line`, whose samples are in its middle and have widths. It is
    /// flat if the rope is too narrow to tell.
    pub(crate) fn measure(line: &Line, difference: &GrayPlane, how: Measure) -> Self {
        let mut mean = Profile::new(how);
        Arch::new().dispatch(FillProfile {
            mean: &mut mean,
            line,
            difference,
            how,
        });
        let half_px = how.half_px;
        let blur_px = mean.blur();
        let clear = (1.0 - CLEAR * blur_px / half_px).min(0.8);
        if clear < 0.0 {
            return Self::FLAT;
        }
        // Blur acts alike on both sides, so their difference is visible nearer to the edge, too.
        let most = clear.max(LEAST_REACH);
        let position = |k: usize| most * (k as f32 - POSITIONS as f32) / POSITIONS as f32;
        let profile: [f32; 2 * POSITIONS + 1] = std::array::from_fn(|k| mean.at(position(k)));
        let from_above = match clear < LEAST_REACH {
            true => Some([profile[POSITIONS], 0.0]),
            false => fit(&profile, position),
        };
        from_above.map_or(Self::FLAT, |[a, b]| {
            let d = mean.lamp(position).unwrap_or_default();
            Self::at_the_rim([a, b], d, half_px, blur_px)
        })
    }

    /// The levels at the rims of a rope shaded by [a, b] and D, relative to its contrast.
    fn at_the_rim([a, b]: [f32; 2], d: Vec2, half_px: f32, blur_px: f32) -> Self {
        // The mean of √(1 − u²) over the middle, where the contrast is measured: u = 0, ±¼, ±½.
        let contrast = a + b * (1.0 + 2.0 * 0.968_246 + 2.0 * 0.866_025) / 5.0;
        let (mut weight, mut round, mut aside) = (0.0, 0.0, 0.0);
        // The half of the blur inside of the rope, up to three σ.
        for k in 0..12 {
            let sigmas = 0.25 * (k as f32 + 0.5);
            let u = (1.0 - sigmas * blur_px / half_px).max(0.0);
            let w = libm::expf(-0.5 * sigmas * sigmas);
            weight += w;
            round += w * (1.0 - u * u).sqrt();
            aside += w * u;
        }
        let half = 0.5 / contrast;
        Self {
            share: half * (a + b * round / weight),
            lit: d.map(|d| half * d * aside / weight),
        }
    }
}

/// The mean section of a rope: sums over some sections, at steps from either edge.
struct Profile {
    /// Levels from the middle outward, with the edge at `INSIDE`, on the −normal and the +normal
    /// side.
    levels: [[f32; PLACES]; 2],
    /// Excess of the +normal side over the other, times the two components of the normal.
    leans: [[f32; PLACES]; 2],
    /// Sums of the normals' products: xx, xy and yy.
    normals: [f32; 3],
    /// First index at which `levels` and `leans` are known.
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

/// Fills a profile, for the widest registers.
struct FillProfile<'a> {
    mean: &'a mut Profile,
    line: &'a Line,
    difference: &'a GrayPlane,
    how: Measure,
}

impl WithSimd for FillProfile<'_> {
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
            leans: [[0.0; PLACES]; 2],
            normals: [0.0; 3],
            // Whole batches are read.
            first: (INSIDE - inside) / BATCH * BATCH,
            half_px: 0.0,
        }
    }

    /// Reads some of the line's sections outside of crossings, evenly spaced.
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
        let [x, y] = &group.rays.along;
        for (x, y) in x[..count].iter().zip(y) {
            self.normals[0] += x * x;
            self.normals[1] += x * y;
            self.normals[2] += y * y;
        }
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
            let (left, right) = values.split_at(BATCH);
            for (k, (left, right)) in left.iter().zip(right).enumerate() {
                for (leans, normal) in self.leans.iter_mut().zip(&group.rays.along) {
                    for l in 0..count {
                        leans[first + k] += normal[l] * (right[l] - left[l]);
                    }
                }
            }
        }
    }

    /// The sum at a position across the rope, −1 to 1.
    fn at(&self, u: f32) -> f32 {
        self.between(&self.levels[usize::from(u > 0.0)], u)
    }

    /// D, times the number of sections: least squares of the part that varies with position and
    /// normal, at the positions of `fit`. `None` if a lamp does not explain the difference between
    /// the sides.
    fn lamp(&self, position: impl Fn(usize) -> f32) -> Option<Vec2> {
        let [xx, xy, yy] = self.normals;
        let count = xx + yy;
        let (xx, yy) = (xx + LITTLE * count, yy + LITTLE * count);
        let per = 1.0 / (xx * yy - xy * xy);
        let solve = |[x, y]: Vec2| [per * (yy * x - xy * y), per * (xx * y - xy * x)];
        let (mut squares, mut sums, mut all) = (0.0, [0.0; 2], 0.0);
        for u in (POSITIONS + 1..=2 * POSITIONS).map(position) {
            let leans = [0, 1].map(|c| self.between(&self.leans[c], u));
            squares += u * u;
            sums = vec2::along(sums, leans, u);
            all += vec2::dot(leans, solve(leans));
        }
        let d = solve(sums);
        let by_lamp = vec2::dot(sums, d) / squares;
        (by_lamp > LIKE_A_LAMP * all).then(|| d.map(|d| 0.5 * count / squares * d))
    }

    /// The value at a position across the rope, interpolated from the levels of one side.
    fn between(&self, levels: &[f32; PLACES], u: f32) -> f32 {
        let hops = (1.0 - u.abs()) * self.half_px / HOP_PX;
        let place = (INSIDE as f32 - hops).max(self.first as f32);
        let k = (place as usize).min(INSIDE);
        levels[k] + (place - k as f32) * (levels[k + 1] - levels[k])
    }

    /// σ of the blur in pixels, from the mean fall of the difference across the rope's edges. A
    /// blurred step of height h has the slope h / (σ√(2π)) in its middle.
    fn blur(&self) -> f32 {
        let [left, right] = &self.levels;
        let levels: [f32; INSIDE + OUTSIDE + 1] =
            std::array::from_fn(|k| left[k.max(self.first)] + right[k.max(self.first)]);
        let slopes = levels.windows(3).map(|l| (l[0] - l[2]) / (2.0 * HOP_PX));
        let steepest = slopes.fold(1e-3, f32::max);
        let mut sigma_px = *BLURS.start();
        // The step's height is read where the blur ends. That place depends on the height itself,
        // hence the iteration.
        for _ in 0..4 {
            let inside = ((CLEAR * sigma_px / HOP_PX) as usize + 1).min(INSIDE);
            let height = levels[INSIDE - inside] - levels[INSIDE + OUTSIDE];
            sigma_px = height / ((2.0 * std::f32::consts::PI).sqrt() * steepest);
            sigma_px = sigma_px.clamp(*BLURS.start(), *BLURS.end());
        }
        sigma_px
    }
}

/// Least squares of a + b·√(1 − u²) over symmetric positions, where d·u is independent of the rest.
fn fit(profile: &[f32], position: impl Fn(usize) -> f32) -> Option<[f32; 2]> {
    let n = profile.len() as f32;
    let (mut sum_c, mut sum_cc, mut sum_y, mut sum_cy) = (0.0, 0.0, 0.0, 0.0);
    for (k, &y) in profile.iter().enumerate() {
        let u = position(k);
        let c = (1.0 - u * u).sqrt();
        (sum_c, sum_cc) = (sum_c + c, sum_cc + c * c);
        (sum_y, sum_cy) = (sum_y + y, sum_cy + c * y);
    }
    let b = (n * sum_cy - sum_c * sum_y) / (n * sum_cc - sum_c * sum_c);
    let a = (sum_y - b * sum_c) / n;
    (sum_y > 0.0 && b.is_finite()).then_some([a, b])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::centerline::line::Sample;

    const MIDDLE: f32 = 100.0;
    const RADIUS: f32 = 60.0;
    const HALF: f32 = 9.0;
    const FLAT: f32 = 70.0;
    const ROUND: f32 = 60.0;
    const LAMP: f32 = 40.0;

    /// A ring lit by a lamp at its right.
    fn ring() -> (GrayPlane, Line) {
        let mut plane = GrayPlane::default();
        plane.resize(2 * MIDDLE as usize, 2 * MIDDLE as usize);
        for y in 0..2 * MIDDLE as usize {
            for (x, byte) in plane.row_mut(y).iter_mut().enumerate() {
                // The mean of 16 places.
                let light = (0..16).map(|k| {
                    let [x, y] = [(x, k % 4), (y, k / 4)]
                        .map(|(at, k)| at as f32 + (k as f32 + 0.5) / 4.0 - 0.5 - MIDDLE);
                    let far = (x * x + y * y).sqrt();
                    let u = (far - RADIUS) / HALF;
                    let shade = FLAT + ROUND * (1.0 - u * u).max(0.0).sqrt() + LAMP * x / far * u;
                    if u.abs() < 1.0 { shade } else { 0.0 }
                });
                *byte = (light.sum::<f32>() / 16.0 + 0.5) as u8;
            }
        }
        let samples = (0..180).map(|k| {
            let (sin, cos) = libm::sincosf(k as f32 * std::f32::consts::TAU / 180.0);
            Sample {
                at: [MIDDLE + RADIUS * cos, MIDDLE + RADIUS * sin],
                weight: 1.0,
                width_px: 2.0 * HALF,
                side: 0.0,
            }
        });
        let line = Line {
            samples: samples.collect(),
            closed: true,
            ..Line::default()
        };
        (plane, line)
    }

    #[test]
    fn the_lit_side_of_a_ring_is_its_right_one_on_either_side_of_it() {
        let (plane, line) = ring();
        let how = Measure {
            half_px: HALF,
            step_px: 2.0,
            tolerance: 1.25,
            shading: Shading::FLAT,
        };
        let shading = Shading::measure(&line, &plane, how);
        // Normals to the right, down, to the left.
        let mut normals = [[0.0; LANES]; 2];
        (normals[0][0], normals[1][1], normals[0][2]) = (1.0, 1.0, -1.0);
        let contrast = FLAT + ROUND * (1.0 + 2.0 * 0.968_246 + 2.0 * 0.866_025) / 5.0;
        let levels = shading.levels(&normals, &[contrast; LANES]);
        // Half of the level at the rim. As blur reaches in, it may also be half of the level up to
        // a tenth of the half-width further inside.
        let at = |u: f32, lamp: f32| 0.5 * (FLAT + ROUND * (1.0 - u * u).sqrt() + u * lamp);
        for (lane, lamp) in [(0, LAMP), (1, 0.0), (2, -LAMP)] {
            for (level, lamp) in [(levels[0][lane], -lamp), (levels[1][lane], lamp)] {
                let (rim, inner) = (at(1.0, lamp), at(0.9, lamp));
                assert!(
                    (rim - 3.0..inner + 3.0).contains(&level),
                    "{level}: {rim} to {inner}"
                );
            }
        }
        let [left, right] = [levels[0][1], levels[1][1]];
        assert!((left - right).abs() < 1.0, "{left} and {right}");
    }
}
