//! The pass of a round over all pixels. It computes the moments of each Gaussian and the total
//! log-likelihood.
//!
//! ```text
//! for each tile
//!   candidates: those whose largest log-density in the tile's box is no less than the best one's least there − T
//!   for each pixel:  lₖ = levelₖ − fallₖ|x − μₖ|²,   m = maxₖ lₖ,   eₖ = 2^(lₖ − m),   s = Σₖ eₖ
//!                    sums of candidate k += eₖ/s · (1, x, y, |x|²),   log-likelihood += m + log₂ s
//! ```
//!
//! Each Gaussian left out contributes less than 2⁻ᵀ of the density of any pixel in the tile. With T
//! = 24 + log₂ K, all of them together contribute less than 2⁻²⁴, the precision of a float.

use lariat_portable::{Simd, WithSimd};

use super::super::exponential::{logarithm, power_of_two};
use super::super::tiles::Tile;
use super::{Gaussian, LANES, Sums, Tiles};

/// The Gaussians' parameters, in lists padded to whole registers with Gaussians of density 0, and
/// scratch memory.
#[derive(Debug, Default)]
pub(super) struct Memory {
    x: Vec<f32>,
    y: Vec<f32>,
    level: Vec<f32>,
    fall: Vec<f32>,
    /// The largest log-density in the tile.
    most: Vec<f32>,
    candidates: Vec<Candidate>,
    /// One register of densities per candidate, and four registers of moments.
    densities: Vec<f32>,
    moments: Vec<f32>,
}

/// A Gaussian relative to a tile's middle.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    index: usize,
    x: f32,
    y: f32,
    level: f32,
    fall: f32,
}

/// Sums of each candidate: Σr, Σrx, Σry, Σr|x|².
const MOMENTS: usize = 4;

impl Memory {
    /// Stores the Gaussians of this round.
    pub(super) fn take(&mut self, gaussians: &[Gaussian]) {
        let padded = gaussians.len().next_multiple_of(LANES);
        for list in [&mut self.x, &mut self.y, &mut self.level, &mut self.fall] {
            list.clear();
        }
        for gaussian in gaussians {
            let [level, fall] = gaussian.shape();
            self.x.push(gaussian.mean[0] as f32);
            self.y.push(gaussian.mean[1] as f32);
            self.level.push(level as f32);
            self.fall.push(fall as f32);
        }
        self.x.resize(padded, 0.0);
        self.y.resize(padded, 0.0);
        self.level.resize(padded, f32::NEG_INFINITY);
        self.fall.resize(padded, 0.0);
        self.most.resize(padded, 0.0);
        self.densities.resize(padded * LANES, 0.0);
        self.moments.resize(padded * LANES * MOMENTS, 0.0);
        self.candidates.clear();
        self.candidates.reserve(padded);
    }
}

/// The pass. Returns the base-2 log-likelihood of all pixels.
pub(super) struct Expectation<'a> {
    pub(super) tiles: &'a Tiles,
    pub(super) gaussians: &'a [Gaussian],
    pub(super) memory: &'a mut Memory,
    pub(super) sums: &'a mut [Sums],
}

impl WithSimd for Expectation<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let mut likelihood = 0.0;
        let margin = 24.0 + libm::log2f(self.gaussians.len() as f32);
        let lists = self.tiles.lists();
        for tile in self.tiles.tiles() {
            let best = self.memory.bound(simd, tile);
            // If all Gaussians are very narrow, the rounding error of the bounds themselves exceeds
            // T.
            let least = best - margin - 4.0 * f32::EPSILON * best.abs();
            self.memory.choose(self.gaussians, tile, least);
            let memory = &mut *self.memory;
            let moments = S::as_mut_simd_f32s(&mut memory.moments).0;
            let moments = &mut moments.as_chunks_mut::<MOMENTS>().0[..memory.candidates.len()];
            moments.fill([simd.splat_f32s(0.0); MOMENTS]);
            let mut work = Work {
                simd,
                candidates: &memory.candidates,
                densities: S::as_mut_simd_f32s(&mut memory.densities).0,
                moments,
            };
            let mut bits = simd.splat_f32s(0.0);
            let [x, y, counts] = lists;
            let x = S::as_simd_f32s(&x[tile.from..tile.to]).0;
            let y = S::as_simd_f32s(&y[tile.from..tile.to]).0;
            let counts = S::as_simd_f32s(&counts[tile.from..tile.to]).0;
            for ((x, y), count) in x.iter().zip(y).zip(counts) {
                bits = simd.add_f32s(bits, work.pixels([*x, *y], *count));
            }
            likelihood += f64::from(simd.reduce_sum_f32s(bits));
            for (candidate, moments) in memory.candidates.iter().zip(&*moments) {
                let mut sums = [0.0; MOMENTS];
                for (sum, moment) in sums.iter_mut().zip(moments) {
                    *sum = f64::from(simd.reduce_sum_f32s(*moment));
                }
                self.sums[candidate.index].add(sums, tile.middle);
            }
        }
        likelihood
    }
}

impl Memory {
    /// Stores the largest log-density of each Gaussian in the tile's box. Returns the best
    /// Gaussian's least log-density there.
    #[inline(always)]
    fn bound<S: Simd>(&mut self, simd: S, tile: &Tile) -> f32 {
        let mut best = simd.splat_f32s(f32::NEG_INFINITY);
        let [low_x, low_y] = [0, 1].map(|axis| simd.splat_f32s(tile.middle[axis] + tile.low[axis]));
        let [high_x, high_y] =
            [0, 1].map(|axis| simd.splat_f32s(tile.middle[axis] + tile.high[axis]));
        let gaussians = S::as_simd_f32s(&self.x).0.iter();
        let gaussians = gaussians.zip(S::as_simd_f32s(&self.y).0);
        let shapes = S::as_simd_f32s(&self.level).0.iter();
        let shapes = shapes.zip(S::as_simd_f32s(&self.fall).0);
        let most = S::as_mut_simd_f32s(&mut self.most).0;
        for (((x, y), (level, fall)), most) in gaussians.zip(shapes).zip(most) {
            let (near_x, far_x) = reach(simd, *x, low_x, high_x);
            let (near_y, far_y) = reach(simd, *y, low_y, high_y);
            let near = simd.mul_add_f32s(near_x, near_x, simd.mul_f32s(near_y, near_y));
            let far = simd.mul_add_f32s(far_x, far_x, simd.mul_f32s(far_y, far_y));
            *most = simd.sub_f32s(*level, simd.mul_f32s(*fall, near));
            let least = simd.sub_f32s(*level, simd.mul_f32s(*fall, far));
            best = simd.max_f32s(best, least);
        }
        simd.reduce_max_f32s(best)
    }

    /// Selects the Gaussians that reach `least` in the tile.
    #[inline(always)]
    fn choose(&mut self, gaussians: &[Gaussian], tile: &Tile, least: f32) {
        self.candidates.clear();
        for (index, gaussian) in gaussians.iter().enumerate() {
            // The Gaussian that set the bound always reaches it, whatever the rounding.
            if self.most[index] >= least && self.level[index] > f32::NEG_INFINITY {
                self.candidates.push(Candidate {
                    index,
                    x: (gaussian.mean[0] - f64::from(tile.middle[0])) as f32,
                    y: (gaussian.mean[1] - f64::from(tile.middle[1])) as f32,
                    level: self.level[index],
                    fall: self.fall[index],
                });
            }
        }
    }
}

/// Minimum and maximum distance along one axis between `c` and the interval from `low` to `high`.
#[inline(always)]
fn reach<S: Simd>(simd: S, c: S::f32s, low: S::f32s, high: S::f32s) -> (S::f32s, S::f32s) {
    let (below, above) = (simd.sub_f32s(low, c), simd.sub_f32s(c, high));
    let near = simd.max_f32s(simd.max_f32s(below, above), simd.splat_f32s(0.0));
    let far = simd.max_f32s(simd.sub_f32s(c, low), simd.sub_f32s(high, c));
    (near, far)
}

/// State for the pixels of one tile.
struct Work<'a, S: Simd> {
    simd: S,
    candidates: &'a [Candidate],
    densities: &'a mut [S::f32s],
    moments: &'a mut [[S::f32s; MOMENTS]],
}

impl<S: Simd> Work<'_, S> {
    /// Adds a register of pixels to the moments. Returns the logarithms of the densities, and 0 for
    /// padding.
    #[inline(always)]
    fn pixels(&mut self, [x, y]: [S::f32s; 2], count: S::f32s) -> S::f32s {
        let simd = self.simd;
        let mut most = simd.splat_f32s(f32::NEG_INFINITY);
        for (candidate, density) in self.candidates.iter().zip(&mut *self.densities) {
            let dx = simd.sub_f32s(x, simd.splat_f32s(candidate.x));
            let dy = simd.sub_f32s(y, simd.splat_f32s(candidate.y));
            let square = simd.mul_add_f32s(dx, dx, simd.mul_f32s(dy, dy));
            let fall = simd.splat_f32s(-candidate.fall);
            *density = simd.mul_add_f32s(fall, square, simd.splat_f32s(candidate.level));
            most = simd.max_f32s(most, *density);
        }
        let mut sum = simd.splat_f32s(0.0);
        for density in &mut self.densities[..self.candidates.len()] {
            *density = power_of_two(simd, simd.sub_f32s(*density, most));
            sum = simd.add_f32s(sum, *density);
        }
        let share = simd.div_f32s(count, sum);
        let square = simd.mul_add_f32s(x, x, simd.mul_f32s(y, y));
        for (density, moments) in self.densities.iter().zip(&mut *self.moments) {
            let r = simd.mul_f32s(*density, share);
            moments[0] = simd.add_f32s(moments[0], r);
            moments[1] = simd.mul_add_f32s(r, x, moments[1]);
            moments[2] = simd.mul_add_f32s(r, y, moments[2]);
            moments[3] = simd.mul_add_f32s(r, square, moments[3]);
        }
        simd.mul_f32s(count, simd.add_f32s(most, logarithm(simd, sum)))
    }
}

impl Sums {
    /// Adds sums that are relative to a tile's middle.
    fn add(&mut self, [count, x, y, second]: [f64; MOMENTS], middle: [f32; 2]) {
        let [middle_x, middle_y] = middle.map(f64::from);
        self.count += count;
        self.first[0] += x + count * middle_x;
        self.first[1] += y + count * middle_y;
        self.second += second
            + 2.0 * (x * middle_x + y * middle_y)
            + count * (middle_x * middle_x + middle_y * middle_y);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Pixels, Run};
    use lariat_portable::Arch;
    use proptest::prelude::*;

    /// The definition: evaluates every pixel for every Gaussian, in doubles. Returns the
    /// log-likelihood, the largest absolute log-density of a pixel, and the sums.
    fn defined(pixels: &Pixels, gaussians: &[Gaussian]) -> (f64, f64, Vec<Sums>) {
        let (mut likelihood, mut largest) = (0.0, 0.0f64);
        let mut sums = vec![Sums::default(); gaussians.len()];
        for (&x, &y) in pixels.xs().iter().zip(pixels.ys()) {
            let place = [x, y].map(f64::from);
            let density = |g: &Gaussian| {
                let [level, fall] = g.shape();
                let (dx, dy) = (place[0] - g.mean[0], place[1] - g.mean[1]);
                level - fall * (dx * dx + dy * dy)
            };
            let most = gaussians.iter().map(density).fold(f64::MIN, f64::max);
            let part = |g: &Gaussian| (density(g) - most).exp2();
            let all: f64 = gaussians.iter().map(part).sum();
            likelihood += most + all.log2();
            largest = largest.max(most.abs());
            for (sums, gaussian) in sums.iter_mut().zip(gaussians) {
                let r = part(gaussian) / all;
                sums.count += r;
                sums.first[0] += r * place[0];
                sums.first[1] += r * place[1];
                sums.second += r * (place[0] * place[0] + place[1] * place[1]);
            }
        }
        (likelihood, largest, sums)
    }

    fn gaussian() -> impl Strategy<Value = Gaussian> {
        // From a hundredth of a pixel to wider than all tiles.
        let variance = (-4.0..3.5f64).prop_map(|power| 10f64.powf(power));
        (0.0..90.0, 0.0..70.0, variance, 1e-4..1.0).prop_map(|(x, y, variance, weight)| Gaussian {
            weight,
            mean: [x, y],
            variance,
        })
    }

    proptest! {
        #[test]
        fn what_is_left_out_is_less_than_rounding(
            runs in prop::collection::vec((0..70u16, 0..80u16, 1..10u16), 1..20),
            gaussians in prop::collection::vec(gaussian(), 1..40),
        ) {
            let mut pixels = Pixels::default();
            for (y, from, length) in runs {
                pixels.push(Run { y, from, to: from + length });
            }
            let (likelihood, largest, expected) = defined(&pixels, &gaussians);
            let mut tiles = Tiles::default();
            tiles.fill(&pixels);
            for arch in [Arch::new(), Arch::Plain] {
                let mut sums = vec![Sums::default(); gaussians.len()];
                let mut memory = Memory::default();
                memory.take(&gaussians);
                let found = arch.dispatch(Expectation {
                    tiles: &tiles,
                    gaussians: &gaussians,
                    memory: &mut memory,
                    sums: &mut sums,
                });
                // The error is in a logarithm's last bits, which is large for narrow Gaussians far
                // away.
                let off = 5e-7 * (20.0 + largest) * pixels.len() as f64;
                prop_assert!((found - likelihood).abs() < off, "{} {}", found, likelihood);
                for (found, expected) in sums.iter().zip(&expected) {
                    prop_assert!((found.count - expected.count).abs() < off);
                    for axis in 0..2 {
                        let moved = found.first[axis] - expected.first[axis];
                        prop_assert!(moved.abs() < 100.0 * off, "{:?} {:?}", found, expected);
                    }
                    prop_assert!((found.second - expected.second).abs() < 1e4 * off);
                }
            }
        }
    }

    #[test]
    fn a_tile_is_only_asked_about_what_reaches_it() {
        let mut pixels = Pixels::default();
        for (y, from) in [(8, 5), (400, 500)] {
            let to = from + 6;
            pixels.push(Run { y, from, to });
        }
        let gaussians = [[8.0, 8.0], [505.0, 401.0]].map(|mean| Gaussian {
            weight: 0.5,
            mean,
            variance: 30.0,
        });
        let mut tiles = Tiles::default();
        tiles.fill(&pixels);
        let mut memory = Memory::default();
        memory.take(&gaussians);
        let mut sums = [Sums::default(); 2];
        Arch::new().dispatch(Expectation {
            tiles: &tiles,
            gaussians: &gaussians,
            memory: &mut memory,
            sums: &mut sums,
        });
        let asked: Vec<usize> = memory.candidates.iter().map(|c| c.index).collect();
        assert_eq!(asked, [1]);
    }
}
