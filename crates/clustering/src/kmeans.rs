//! k-means by Lloyd's rounds (S. Lloyd, Least Squares Quantization in PCM, 1982). Each round moves
//! every center to the mean of the pixels nearest to it, until the centers stay in place.
//!
//! A round does not visit individual pixels. `nearest` finds which columns of each piece of a run
//! belong to a center. n pixels from column a have the sum n·(a + (n − 1)/2). Sums are relative to
//! the center, so that they give its move without cancellation.

use lariat_portable::{Arch, Simd, WithSimd};

use super::blocks::{Block, Blocks, Lanes};
use super::nearest::Nearest;
use super::seeding::Seeding;
use super::{Outcome, Pixels, Start};

/// Maximum number of rounds, as in scikit-learn's `KMeans` (`max_iter`).
const MOST_ROUNDS: u32 = 300;
/// The rounds end when the squared moves of the centers sum to at most this share of the pixels'
/// variance. The variance is the mean over columns and rows, as in scikit-learn's `KMeans` (`tol`).
const TOLERANCE: f64 = 1e-4;

/// k-means clustering. It keeps its memory, so that once warm no run allocates.
#[derive(Debug, Default)]
pub struct KMeans {
    seeding: Seeding,
    blocks: Blocks,
    nearest: Nearest,
    /// Sums over each center's pixels, with centers from left to right: first per lane, then in
    /// total.
    lanes: Vec<LaneSums>,
    sums: Vec<Sums>,
    /// Pixels farthest from their centers, farthest first, for centers without pixels.
    far: Vec<Far>,
}

/// Number of pixels and the sum of their offsets from their center, per lane.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct LaneSums {
    count: Lanes,
    x: Lanes,
    y: Lanes,
}

/// The same sums over all lanes.
#[derive(Clone, Copy, Debug)]
struct Sums {
    count: f32,
    x: f32,
    y: f32,
}

/// A pixel, its squared distance from its center, and that center's rank.
#[derive(Clone, Copy, Debug)]
struct Far {
    square: f32,
    place: [f32; 2],
    rank: u32,
}

impl KMeans {
    /// Moves `centers` until they stay in place. The objective is the inertia: the sum over all
    /// pixels of the squared distance from the nearest center, in px².
    ///
    /// A center that is not the nearest of any pixel moves to the pixel farthest from its own
    /// center, as in scikit-learn. This needs a pixel that is not alone in its cell, so if there
    /// are more centers than pixels, some stay in place. Without pixels, all centers stay and no
    /// round is run.
    pub fn run(&mut self, pixels: &Pixels, start: Start, centers: &mut [[f32; 2]]) -> Outcome {
        let mut outcome = Outcome {
            rounds: 0,
            objective: 0.0,
        };
        if pixels.is_empty() || centers.is_empty() {
            return outcome;
        }
        self.seeding.begin(pixels, start, centers);
        self.blocks.take(pixels);
        // This memory is rarely needed, and possibly for the first time in a later run, so reserve
        // it in advance.
        self.far.clear();
        self.far.reserve(centers.len());
        let tolerance = TOLERANCE * variance(pixels);
        let arch = Arch::new();
        while outcome.rounds < MOST_ROUNDS {
            outcome.rounds += 1;
            self.nearest.take(centers);
            arch.dispatch(Summing(self));
            if self.sums.iter().any(|sums| sums.count == 0.0) {
                self.fill_empty(centers);
            }
            if self.advance(centers) <= tolerance {
                break;
            }
        }
        self.nearest.take(centers);
        outcome.objective = arch.dispatch(Measuring(self));
        outcome
    }

    /// Moves every center to the mean of its pixels. Returns the sum of the squared moves.
    fn advance(&self, centers: &mut [[f32; 2]]) -> f64 {
        let mut squares = 0.0;
        for (sums, &center) in self.sums.iter().zip(&self.nearest.order) {
            if sums.count > 0.0 {
                let center = &mut centers[center as usize];
                let [x, y] = [sums.x / sums.count, sums.y / sums.count];
                *center = [center[0] + x, center[1] + y];
                squares += f64::from(x * x + y * y);
            }
        }
        squares
    }

    /// Gives every center without pixels the pixel that is farthest from its own center.
    #[cold]
    fn fill_empty(&mut self, centers: &[[f32; 2]]) {
        let empty = self.sums.iter().filter(|sums| sums.count == 0.0).count();
        self.far.clear();
        Arch::new().dispatch(Searching {
            memory: self,
            most: empty,
        });
        let mut far = self.far.iter();
        for rank in 0..self.sums.len() {
            if self.sums[rank].count > 0.0 {
                continue;
            }
            // A pixel that is alone in its cell stays there.
            let Some(pixel) = far.find(|far| self.sums[far.rank as usize].count > 1.0) else {
                return;
            };
            let off = |rank: usize| {
                let [x, y] = centers[self.nearest.order[rank] as usize];
                [pixel.place[0] - x, pixel.place[1] - y]
            };
            let (from_own, from_here) = (off(pixel.rank as usize), off(rank));
            let own = &mut self.sums[pixel.rank as usize];
            own.count -= 1.0;
            own.x -= from_own[0];
            own.y -= from_own[1];
            self.sums[rank] = Sums {
                count: 1.0,
                x: from_here[0],
                y: from_here[1],
            };
        }
    }
}

/// Mean of the variances of columns and rows, in px².
fn variance(pixels: &Pixels) -> f64 {
    let origin = pixels.runs()[0];
    let (mut count, mut sum, mut squares) = (0.0, [0.0; 2], 0.0);
    for run in pixels.runs() {
        let n = f64::from(run.to) - f64::from(run.from);
        let x = 0.5 * (f64::from(run.from) + f64::from(run.to) - 1.0) - f64::from(origin.from);
        let y = f64::from(run.y) - f64::from(origin.y);
        count += n;
        sum[0] += n * x;
        sum[1] += n * y;
        squares += n * (x * x + y * y + (n * n - 1.0) / 12.0);
    }
    let of_mean = (sum[0] * sum[0] + sum[1] * sum[1]) / count;
    0.5 * ((squares - of_mean) / count).max(0.0)
}

/// A center's pixels in the pieces of a block: their number, and the offset of their middle from
/// the center.
struct Part<V> {
    count: V,
    x: V,
    y: V,
}

/// Returns the part of the `i`-th near center in the `lane`-th vector of a block's pieces.
#[inline(always)]
fn part<S: Simd>(
    simd: S,
    block: &Block,
    nearest: &Nearest,
    i: usize,
    lane: usize,
) -> Part<S::f32s> {
    let begin = S::as_simd_f32s(&nearest.begins[i]).0[lane];
    let end = S::as_simd_f32s(&nearest.ends[i]).0[lane];
    let y = S::as_simd_f32s(&block.y).0[lane];
    let near = nearest.near[i];
    let count = simd.max_f32s(simd.sub_f32s(end, begin), simd.splat_f32s(0.0));
    let half = simd.splat_f32s(0.5);
    // Half a pixel right of the middle, since `end` is exclusive.
    let middle = simd.mul_f32s(half, simd.add_f32s(begin, end));
    Part {
        count,
        x: simd.sub_f32s(middle, simd.splat_f32s(near.x + 0.5)),
        y: simd.sub_f32s(y, simd.splat_f32s(near.y)),
    }
}

/// Sums up the pixels of each center.
struct Summing<'a>(&'a mut KMeans);

impl WithSimd for Summing<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let KMeans {
            blocks,
            nearest,
            lanes,
            sums,
            ..
        } = self.0;
        let none = LaneSums {
            count: Lanes::default(),
            x: Lanes::default(),
            y: Lanes::default(),
        };
        lanes.clear();
        lanes.resize(nearest.order.len(), none);
        for block in &blocks.blocks {
            for i in 0..nearest.cut(simd, block) {
                let sums = &mut lanes[nearest.near[i].rank as usize];
                let counts = S::as_mut_simd_f32s(&mut sums.count).0.iter_mut();
                let xs = S::as_mut_simd_f32s(&mut sums.x).0.iter_mut();
                let ys = S::as_mut_simd_f32s(&mut sums.y).0.iter_mut();
                for (lane, ((count, x), y)) in counts.zip(xs).zip(ys).enumerate() {
                    let part = part(simd, block, nearest, i, lane);
                    *count = simd.add_f32s(*count, part.count);
                    *x = simd.mul_add_f32s(part.count, part.x, *x);
                    *y = simd.mul_add_f32s(part.count, part.y, *y);
                }
            }
        }
        sums.clear();
        for lanes in lanes {
            sums.push(Sums {
                count: total(simd, &lanes.count),
                x: total(simd, &lanes.x),
                y: total(simd, &lanes.y),
            });
        }
    }
}

#[inline(always)]
fn total<S: Simd>(simd: S, lanes: &Lanes) -> f32 {
    let mut sum = simd.splat_f32s(0.0);
    for &part in S::as_simd_f32s(lanes).0 {
        sum = simd.add_f32s(sum, part);
    }
    simd.reduce_sum_f32s(sum)
}

/// Sums up the pixels' squared distances.
struct Measuring<'a>(&'a mut KMeans);

impl WithSimd for Measuring<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let KMeans {
            blocks, nearest, ..
        } = self.0;
        let [one, twelfth] = [simd.splat_f32s(1.0), simd.splat_f32s(1.0 / 12.0)];
        let mut inertia = 0.0;
        for block in &blocks.blocks {
            let mut squares = simd.splat_f32s(0.0);
            for i in 0..nearest.cut(simd, block) {
                for lane in 0..S::as_simd_f32s(&block.y).0.len() {
                    let Part { count, x, y } = part(simd, block, nearest, i, lane);
                    // n pixels around their middle contribute (n² − 1)/12 each.
                    let around = simd.sub_f32s(simd.mul_f32s(count, count), one);
                    let mut square = simd.mul_f32s(around, twelfth);
                    square = simd.mul_add_f32s(x, x, square);
                    square = simd.mul_add_f32s(y, y, square);
                    squares = simd.mul_add_f32s(count, square, squares);
                }
            }
            inertia += f64::from(simd.reduce_sum_f32s(squares));
        }
        inertia
    }
}

/// Lists the pixels farthest from their centers, farthest first.
struct Searching<'a> {
    memory: &'a mut KMeans,
    most: usize,
}

impl WithSimd for Searching<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let KMeans {
            blocks,
            nearest,
            far,
            ..
        } = self.memory;
        for block in &blocks.blocks {
            for i in 0..nearest.cut(simd, block) {
                let near = nearest.near[i];
                for lane in 0..block.count {
                    // The farthest pixel is at one of the two ends, and so is the farthest of the
                    // rest.
                    let y = block.y[lane];
                    let (mut from, mut to) = (nearest.begins[i][lane], nearest.ends[i][lane]);
                    while from < to {
                        let is_left = near.x - from > to - 1.0 - near.x;
                        let x = if is_left { from } else { to - 1.0 };
                        let pixel = Far {
                            square: (x - near.x).powi(2) + (y - near.y).powi(2),
                            place: [x, y],
                            rank: near.rank,
                        };
                        if !offer(far, self.most, pixel) {
                            break;
                        }
                        if is_left {
                            from += 1.0;
                        } else {
                            to -= 1.0;
                        }
                    }
                }
            }
        }
    }
}

/// Inserts a pixel into the list of the `most` farthest, if it is one of them.
fn offer(far: &mut Vec<Far>, most: usize, pixel: Far) -> bool {
    if far.len() == most {
        if far.last().is_none_or(|last| pixel.square <= last.square) {
            return false;
        }
        far.pop();
    }
    if pixel.square > 0.0 {
        let at = far.partition_point(|other| other.square >= pixel.square);
        far.insert(at, pixel);
        return true;
    }
    false
}
