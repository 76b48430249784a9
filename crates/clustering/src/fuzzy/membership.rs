//! The passes over all pixels and all centers.
//!
//! ```text
//! for each block of pixels
//!   for each pair of centers:  q = 1/(d²ₐ d²ᵦ),   wₐ = q d²ᵦ = 1/d²ₐ,   wᵦ = q d²ₐ,   s += wₐ + wᵦ
//!   for each center:           u² = (w/s)²,   sums += u² · (1, x, y)
//! ```
//!
//! With one division for two centers, the divider is no busier than the multipliers.

use lariat_portable::{Simd, WithSimd};

use super::Pixels;
use crate::aligned::{Aligned, LINE};

/// Registers of pixels per block. Their coordinates and sums stay in registers, and the weights of
/// 120 centers fit in the first-level cache.
const REGISTERS: usize = 4;
/// Number of blocks after which float sums are added to doubles.
const FLUSH: usize = 32;
/// Floor of squared distances, in px². A pixel this near to a center belongs to it alone, to a
/// float's last bit, unless another center is within a pixel. scikit-fuzzy has such a floor as
/// well.
const LEAST_SQUARE: f32 = 1e-8;

/// Sums of each center: Σu², Σu²x, Σu²y.
const MOMENTS: usize = 3;

/// Pixels relative to the middle of their bounding box, padded to whole blocks, and scratch memory.
#[derive(Debug, Default)]
pub(super) struct Memory {
    middle: [f32; 2],
    x: Aligned,
    y: Aligned,
    counts: Aligned,
    /// Weights of a block's pixels for each center, in two slots.
    weights: [Aligned; 2],
    /// Moments of each center, one register per moment, and their totals.
    moments: Aligned,
    sums: Vec<[f64; MOMENTS]>,
}

impl Memory {
    /// Stores the pixels and allocates for this many centers.
    pub(super) fn take(&mut self, pixels: &Pixels, middle: [f32; 2], centers: usize) {
        let padded = pixels.len().next_multiple_of(REGISTERS * LINE);
        self.middle = middle;
        let lists = [(&mut self.x, pixels.xs()), (&mut self.y, pixels.ys())];
        for (axis, (list, from)) in lists.into_iter().enumerate() {
            list.set_length(padded);
            let (list, rest) = list.as_mut_slice().split_at_mut(from.len());
            for (to, c) in list.iter_mut().zip(from) {
                *to = c - middle[axis];
            }
            rest.fill(0.0);
        }
        self.counts.set_length(padded);
        let (counts, rest) = self.counts.as_mut_slice().split_at_mut(pixels.len());
        counts.fill(1.0);
        rest.fill(0.0);
        for weights in &mut self.weights {
            weights.set_length(centers * REGISTERS * LINE);
        }
        self.moments.set_length(centers * MOMENTS * LINE);
        self.sums.resize(centers, [0.0; MOMENTS]);
    }

    /// Returns the pixels and the scratch memory as registers.
    #[inline(always)]
    fn split<S: Simd>(&mut self, simd: S) -> (Blocks<'_, S>, Room<'_, S>) {
        let [first, second] = &mut self.weights;
        let blocks = Blocks {
            x: S::as_simd_f32s(self.x.as_slice()).0.as_chunks().0,
            y: S::as_simd_f32s(self.y.as_slice()).0.as_chunks().0,
            counts: S::as_simd_f32s(self.counts.as_slice()).0.as_chunks().0,
        };
        let room = Room {
            simd,
            middle: self.middle,
            weights: [
                S::as_mut_simd_f32s(first.as_mut_slice())
                    .0
                    .as_chunks_mut()
                    .0,
                S::as_mut_simd_f32s(second.as_mut_slice())
                    .0
                    .as_chunks_mut()
                    .0,
            ],
            moments: S::as_mut_simd_f32s(self.moments.as_mut_slice())
                .0
                .as_chunks_mut()
                .0,
            sums: &mut self.sums,
        };
        (blocks, room)
    }
}

/// The pixels processed at a time.
type Block<S> = [<S as Simd>::f32s; REGISTERS];

struct Blocks<'a, S: Simd> {
    x: &'a [Block<S>],
    y: &'a [Block<S>],
    counts: &'a [Block<S>],
}

struct Room<'a, S: Simd> {
    simd: S,
    middle: [f32; 2],
    weights: [&'a mut [Block<S>]; 2],
    moments: &'a mut [[S::f32s; MOMENTS]],
    sums: &'a mut [[f64; MOMENTS]],
}

/// Moves all centers by one round.
pub(super) struct Round<'a> {
    pub(super) memory: &'a mut Memory,
    pub(super) centers: &'a mut [[f32; 2]],
}

impl WithSimd for Round<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let (blocks, mut room) = self.memory.split(simd);
        let count = self.centers.len();
        room.sums[..count].fill([0.0; MOMENTS]);
        room.moments[..count].fill([simd.splat_f32s(0.0); MOMENTS]);
        let pixels = blocks.x.iter().zip(blocks.y).zip(blocks.counts);
        for (i, ((x, y), counts)) in pixels.enumerate() {
            let sums = room.weigh(self.centers, x, y, 0);
            let mut shares = sums;
            for (share, counts) in shares.iter_mut().zip(counts) {
                *share = simd.div_f32s(*counts, *share);
            }
            room.gather(count, x, y, &shares);
            if i % FLUSH == FLUSH - 1 {
                room.flush(count);
            }
        }
        room.flush(count);
        for (center, [weight, x, y]) in self.centers.iter_mut().zip(&*room.sums) {
            // A center with weight 0 is so far away that floats cannot represent its share. It
            // stays.
            if *weight > 0.0 {
                *center = [
                    (x / weight + f64::from(room.middle[0])) as f32,
                    (y / weight + f64::from(room.middle[1])) as f32,
                ];
            }
        }
    }
}

/// Returns whether the memberships to the current and the previous centers differ by at least the
/// tolerance. A few blocks are usually enough to know.
pub(super) struct Moved<'a> {
    pub(super) memory: &'a mut Memory,
    pub(super) centers: [&'a [[f32; 2]]; 2],
    pub(super) tolerance: f64,
}

impl WithSimd for Moved<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        let (blocks, mut room) = self.memory.split(simd);
        let mut total = 0.0;
        let pixels = blocks.x.iter().zip(blocks.y).zip(blocks.counts);
        for ((x, y), counts) in pixels {
            let before = room.weigh(self.centers[0], x, y, 0);
            let now = room.weigh(self.centers[1], x, y, 1);
            let mut squares = simd.splat_f32s(0.0);
            for v in 0..REGISTERS {
                let before = simd.div_f32s(counts[v], before[v]);
                let now = simd.div_f32s(counts[v], now[v]);
                for k in 0..self.centers[0].len() {
                    let change = simd.sub_f32s(
                        simd.mul_f32s(room.weights[0][k][v], before),
                        simd.mul_f32s(room.weights[1][k][v], now),
                    );
                    squares = simd.mul_add_f32s(change, change, squares);
                }
            }
            total += f64::from(simd.reduce_sum_f32s(squares));
            if total >= self.tolerance * self.tolerance {
                return true;
            }
        }
        false
    }
}

/// Computes J.
pub(super) struct Distortion<'a> {
    pub(super) memory: &'a mut Memory,
    pub(super) centers: &'a [[f32; 2]],
}

impl WithSimd for Distortion<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let (blocks, mut room) = self.memory.split(simd);
        let mut total = 0.0;
        let pixels = blocks.x.iter().zip(blocks.y).zip(blocks.counts);
        for ((x, y), counts) in pixels {
            let sums = room.weigh(self.centers, x, y, 0);
            let mut all = simd.splat_f32s(0.0);
            for (sum, counts) in sums.into_iter().zip(counts) {
                all = simd.add_f32s(all, simd.div_f32s(*counts, sum));
            }
            total += f64::from(simd.reduce_sum_f32s(all));
        }
        total
    }
}

impl<S: Simd> Room<'_, S> {
    /// Computes the weights of a block's pixels for all centers and stores them in slot `place`.
    /// Returns their sums.
    #[inline(always)]
    fn weigh(
        &mut self,
        centers: &[[f32; 2]],
        x: &Block<S>,
        y: &Block<S>,
        place: usize,
    ) -> Block<S> {
        let (simd, middle) = (self.simd, self.middle);
        let mut sums = [simd.splat_f32s(0.0); REGISTERS];
        let (pairs, last) = centers.as_chunks::<2>();
        let weights = &mut self.weights[place][..centers.len()];
        let (weights, last_weights) = weights.as_chunks_mut::<2>();
        for ([a, b], [to_a, to_b]) in pairs.iter().zip(weights) {
            let (a, b) = (seen_from(simd, middle, a), seen_from(simd, middle, b));
            for v in 0..REGISTERS {
                let square_a = square(simd, x[v], y[v], a);
                let square_b = square(simd, x[v], y[v], b);
                let both = simd.div_f32s(simd.splat_f32s(1.0), simd.mul_f32s(square_a, square_b));
                to_a[v] = simd.mul_f32s(both, square_b);
                to_b[v] = simd.mul_f32s(both, square_a);
                sums[v] = simd.add_f32s(sums[v], simd.add_f32s(to_a[v], to_b[v]));
            }
        }
        // The last center of an odd number.
        for (center, to) in last.iter().zip(last_weights) {
            let center = seen_from(simd, middle, center);
            for v in 0..REGISTERS {
                to[v] = simd.div_f32s(simd.splat_f32s(1.0), square(simd, x[v], y[v], center));
                sums[v] = simd.add_f32s(sums[v], to[v]);
            }
        }
        sums
    }

    /// Adds a block to the moments of all centers.
    #[inline(always)]
    fn gather(&mut self, count: usize, x: &Block<S>, y: &Block<S>, shares: &Block<S>) {
        let simd = self.simd;
        let moments = self.moments[..count].iter_mut();
        for (moments, weights) in moments.zip(&*self.weights[0]) {
            for v in 0..REGISTERS {
                let u = simd.mul_f32s(weights[v], shares[v]);
                let square = simd.mul_f32s(u, u);
                moments[0] = simd.add_f32s(moments[0], square);
                moments[1] = simd.mul_add_f32s(square, x[v], moments[1]);
                moments[2] = simd.mul_add_f32s(square, y[v], moments[2]);
            }
        }
    }

    /// Adds the moments to the totals and clears them.
    #[inline(always)]
    fn flush(&mut self, count: usize) {
        for (sums, moments) in self.sums.iter_mut().zip(&mut self.moments[..count]) {
            for (sum, moment) in sums.iter_mut().zip(moments) {
                *sum += f64::from(self.simd.reduce_sum_f32s(*moment));
                *moment = self.simd.splat_f32s(0.0);
            }
        }
    }
}

/// Position of a center relative to the middle.
#[inline(always)]
fn seen_from<S: Simd>(simd: S, middle: [f32; 2], center: &[f32; 2]) -> [S::f32s; 2] {
    [
        simd.splat_f32s(center[0] - middle[0]),
        simd.splat_f32s(center[1] - middle[1]),
    ]
}

/// Squared distances of pixels from a center, no less than the floor.
#[inline(always)]
fn square<S: Simd>(simd: S, x: S::f32s, y: S::f32s, center: [S::f32s; 2]) -> S::f32s {
    let (dx, dy) = (simd.sub_f32s(x, center[0]), simd.sub_f32s(y, center[1]));
    let square = simd.mul_add_f32s(dx, dx, simd.mul_f32s(dy, dy));
    simd.max_f32s(square, simd.splat_f32s(LEAST_SQUARE))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Run;
    use lariat_portable::Arch;
    use proptest::prelude::*;

    /// The definition of a round, in doubles: the memberships and J before it, and the centers
    /// after it.
    fn defined(pixels: &Pixels, centers: &[[f32; 2]]) -> (Vec<Vec<f64>>, f64, Vec<[f64; 2]>) {
        let mut memberships = Vec::new();
        let mut objective = 0.0;
        let mut sums = vec![[0.0; MOMENTS]; centers.len()];
        for (&x, &y) in pixels.xs().iter().zip(pixels.ys()) {
            let [x, y] = [x, y].map(f64::from);
            let weight = |c: &[f32; 2]| {
                let (dx, dy) = (x - f64::from(c[0]), y - f64::from(c[1]));
                1.0 / (dx * dx + dy * dy).max(f64::from(LEAST_SQUARE))
            };
            let all: f64 = centers.iter().map(weight).sum();
            let u: Vec<f64> = centers.iter().map(|c| weight(c) / all).collect();
            for (sums, u) in sums.iter_mut().zip(&u) {
                sums[0] += u * u;
                sums[1] += u * u * x;
                sums[2] += u * u * y;
            }
            memberships.push(u);
            objective += 1.0 / all;
        }
        let centers = sums.iter().map(|[weight, x, y]| [x / weight, y / weight]);
        (memberships, objective, centers.collect())
    }

    proptest! {
        #[test]
        fn a_round_is_the_definitions(
            runs in prop::collection::vec((0..70u16, 0..80u16, 1..30u16), 1..40),
            centers in prop::collection::vec([0.0..90.0f32, 0.0..70.0f32], 1..30),
            on_pixel in any::<bool>(),
        ) {
            let mut pixels = Pixels::default();
            for (y, from, length) in runs {
                pixels.push(Run { y, from, to: from + length });
            }
            let mut centers = centers;
            if on_pixel {
                centers[0] = [pixels.xs()[0], pixels.ys()[0]];
            }
            let (before, objective, expected) = defined(&pixels, &centers);
            for arch in [Arch::new(), Arch::Plain] {
                let mut memory = Memory::default();
                memory.take(&pixels, [45.0, 35.0], centers.len());
                let memory = &mut memory;
                let found = arch.dispatch(Distortion { memory, centers: &centers });
                prop_assert!((found / objective - 1.0).abs() < 1e-5, "{} {}", found, objective);

                let mut after = centers.clone();
                arch.dispatch(Round { memory, centers: &mut after });
                for (found, expected) in after.iter().zip(&expected) {
                    for axis in 0..2 {
                        let off = f64::from(found[axis]) - expected[axis];
                        prop_assert!(off.abs() < 1e-4, "{:?} {:?}", found, expected);
                    }
                }

                let (now, _, _) = defined(&pixels, &after);
                let changes = now.iter().flatten().zip(before.iter().flatten());
                let change: f64 = changes.map(|(a, b)| (a - b) * (a - b)).sum();
                // Smaller changes are dominated by the rounding of all memberships.
                let change = change.sqrt().max(3e-3);
                for (tolerance, moved) in [(0.99 * change, change > 3e-3), (1.01 * change, false)] {
                    let found = arch.dispatch(Moved {
                        memory,
                        centers: [&centers, &after],
                        tolerance,
                    });
                    prop_assert_eq!(found, moved);
                }
            }
        }
    }
}
