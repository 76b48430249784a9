//! A self-organizing map (T. Kohonen, Self-organized formation of topologically correct feature
//! maps, Biological Cybernetics 43, 1982). The map is a line of nodes. Each pixel in turn pulls the
//! nearest node toward itself, and that node's neighbors on the line less.
//!
//! ```text
//! in each round t of T: a pixel x, drawn at random
//!   the winner      w = argminⱼ |x − cⱼ|
//!   all nodes       cⱼ ← cⱼ + η e^(−(j − w)²/2σ²) (x − cⱼ)
//!   then narrower   η = η₀/(1 + 2t/T),  σ = σ₀/(1 + 2t/T)
//! ```
//!
//! This is `MiniSom(1, K, 2)` with its Gaussian neighborhood and its default decay, to a third of
//! the initial values.

use lariat_portable::{Arch, Simd, WithSimd};

use super::exponential::power_of_two;
use super::extent::Extent;
use super::seeding::Seeding;
use super::{Outcome, Pixels, Start};
use lariat_portable::SplitMix64;

/// Nodes processed in parallel: the lanes of the widest register.
const LANES: usize = 16;
/// A coordinate so far from all pixels that it is never the nearest, for unused lanes.
const NOWHERE: f32 = 1e18;
/// Neighbors beyond this many standard deviations are not moved. There, e^(−u²/2) is 2⁻²⁴, the
/// precision of a float.
const REACH: f32 = 5.768;
/// Seed of the samples in frames that continue a map; the same in every frame.
const CONTINUED: u64 = 0;

/// Duration and strength of a training.
#[derive(Clone, Copy, Debug)]
pub(super) struct Training {
    /// Number of samples, one per round.
    rounds: u32,
    /// Initial share of the distance to the sample by which the winner moves.
    rate: f32,
    /// Initial standard deviation of the neighborhood, in nodes.
    sigma: f32,
}

impl Training {
    /// Training from scratch. Each of 120 nodes wins some 80 rounds. The rate is MiniSom's default.
    /// MiniSom's default of σ = 1 is too narrow to straighten an unordered line of 120 nodes: nodes
    /// whose neighbors are on other parts of the rope stay between them, on the table. From σ = 4,
    /// nodes contract and end farther from the pixels.
    pub(super) const COLD: Self = Self {
        rounds: 10_000,
        rate: 0.5,
        sigma: 3.0,
    };
    /// Training that continues from the last frame's nodes. It starts where the previous training
    /// ends, at a third of its rate and σ. Each of 120 nodes wins some 17 rounds, enough to move
    /// nine tenths of the way to the rope's new position.
    const CONTINUED: Self = Self {
        rounds: 2_000,
        rate: Self::COLD.rate / 3.0,
        sigma: Self::COLD.sigma / 3.0,
    };
}

/// A self-organizing map: a line of nodes. It keeps its memory from run to run.
#[derive(Debug, Default)]
pub struct Som {
    seeding: Seeding,
    /// Coordinates of the nodes, x and y, padded to whole registers.
    nodes: [Vec<f32>; 2],
}

impl Som {
    /// Trains the map whose nodes are `centers` on randomly drawn `pixels`. The same start draws
    /// the same pixels.
    ///
    /// From [`Start::Seeded`] it runs 10,000 rounds, and from [`Start::Given`] 2,000 that move
    /// less. The centers stay within the bounding box of the pixels. Neighbors in the list are
    /// mostly neighbors on the rope. Without pixels nothing changes.
    ///
    /// The objective is the quantization error: the mean distance of pixels from the nearest
    /// center, in pixels. A round is one sample.
    pub fn run(&mut self, pixels: &Pixels, start: Start, centers: &mut [[f32; 2]]) -> Outcome {
        self.seeding.begin(pixels, start, centers);
        let (training, seed) = match start {
            Start::Seeded(seed) => (Training::COLD, seed),
            Start::Given => (Training::CONTINUED, CONTINUED),
        };
        self.train(pixels, training, seed, centers)
    }

    /// Trains on pixels drawn by a generator with this seed.
    pub(super) fn train(
        &mut self,
        pixels: &Pixels,
        training: Training,
        seed: u64,
        centers: &mut [[f32; 2]],
    ) -> Outcome {
        let Some(extent) = Extent::of(pixels).filter(|_| !centers.is_empty()) else {
            return Outcome {
                rounds: 0,
                objective: 0.0,
            };
        };
        extent.confine(centers);
        for (axis, nodes) in self.nodes.iter_mut().enumerate() {
            nodes.clear();
            nodes.extend(centers.iter().map(|center| center[axis]));
            nodes.resize(centers.len().next_multiple_of(LANES), NOWHERE);
        }
        let [x, y] = &mut self.nodes;
        let objective = Arch::new().dispatch(Train {
            pixels,
            training,
            random: SplitMix64::new(seed),
            count: centers.len(),
            nodes: [x, y],
        });
        for (i, center) in centers.iter_mut().enumerate() {
            *center = [self.nodes[0][i], self.nodes[1][i]];
        }
        // Rounding may have moved a node just outside the box.
        extent.confine(centers);
        Outcome {
            rounds: training.rounds,
            objective,
        }
    }
}

/// The whole training. Returns the quantization error.
struct Train<'a> {
    pixels: &'a Pixels,
    training: Training,
    random: SplitMix64,
    count: usize,
    nodes: [&'a mut [f32]; 2],
}

impl WithSimd for Train<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) -> f64 {
        let mut lanes = [0.0; LANES];
        for (i, lane) in lanes.iter_mut().enumerate() {
            *lane = i as f32;
        }
        let [x, y] = &mut self.nodes;
        let mut line = Line {
            simd,
            lanes: S::as_simd_f32s(&lanes).0[0],
            count: simd.splat_f32s(self.count as f32),
            x: S::as_mut_simd_f32s(x).0,
            y: S::as_mut_simd_f32s(y).0,
        };
        let (xs, ys) = (self.pixels.xs(), self.pixels.ys());
        let rounds = self.training.rounds;
        let decay = 2.0 / rounds as f32;
        for t in 0..rounds {
            let i = self.random.below(xs.len());
            let weaker = 1.0 + decay * t as f32;
            let (rate, sigma) = (self.training.rate / weaker, self.training.sigma / weaker);
            let (winner, _) = line.nearest([xs[i], ys[i]]);
            line.draw([xs[i], ys[i]], winner, rate, sigma);
        }
        let mut sum = 0.0;
        for (&x, &y) in xs.iter().zip(ys) {
            sum += f64::from(line.nearest([x, y]).1.sqrt());
        }
        sum / xs.len() as f64
    }
}

/// The nodes in registers.
struct Line<'a, S: Simd> {
    simd: S,
    /// 0, 1, 2, …
    lanes: S::f32s,
    count: S::f32s,
    x: &'a mut [S::f32s],
    y: &'a mut [S::f32s],
}

impl<S: Simd> Line<'_, S> {
    /// Returns the node nearest to a place, the first of several, and its squared distance.
    #[inline(always)]
    fn nearest(&self, [x, y]: [f32; 2]) -> (f32, f32) {
        let simd = self.simd;
        let (x, y) = (simd.splat_f32s(x), simd.splat_f32s(y));
        let step = simd.splat_f32s(S::F32_LANES as f32);
        let mut index = self.lanes;
        let (mut winner, mut least) = (index, simd.splat_f32s(f32::INFINITY));
        for (cx, cy) in self.x.iter().zip(&*self.y) {
            let (dx, dy) = (simd.sub_f32s(x, *cx), simd.sub_f32s(y, *cy));
            let square = simd.mul_add_f32s(dx, dx, simd.mul_f32s(dy, dy));
            let nearer = simd.less_than_f32s(square, least);
            winner = simd.select_f32s(nearer, index, winner);
            least = simd.min_f32s(square, least);
            index = simd.add_f32s(index, step);
        }
        let square = simd.reduce_min_f32s(least);
        let is_least = simd.equal_f32s(least, simd.splat_f32s(square));
        let winner = simd.select_f32s(is_least, winner, simd.splat_f32s(f32::INFINITY));
        (simd.reduce_min_f32s(winner), square)
    }

    /// Pulls the winner and its neighbors toward a place.
    #[inline(always)]
    fn draw(&mut self, [x, y]: [f32; 2], winner: f32, rate: f32, sigma: f32) {
        let simd = self.simd;
        let width = S::F32_LANES as f32;
        let reach = REACH * sigma;
        let from = ((winner - reach).max(0.0) / width) as usize;
        let to = (((winner + reach) / width) as usize + 1).min(self.x.len());
        let (x, y) = (simd.splat_f32s(x), simd.splat_f32s(y));
        let (rate, winner) = (simd.splat_f32s(rate), simd.splat_f32s(winner));
        let narrow = simd.splat_f32s(-0.5 * std::f32::consts::LOG2_E / (sigma * sigma));
        for i in from..to {
            let index = simd.add_f32s(self.lanes, simd.splat_f32s(i as f32 * width));
            let away = simd.sub_f32s(index, winner);
            let z = simd.mul_f32s(simd.mul_f32s(away, away), narrow);
            let share = simd.mul_f32s(rate, power_of_two(simd, z));
            // Padding lanes stay where they are.
            let is_node = simd.less_than_f32s(index, self.count);
            let share = simd.select_f32s(is_node, share, simd.splat_f32s(0.0));
            for (at, c) in [(x, &mut self.x[i]), (y, &mut self.y[i])] {
                *c = simd.mul_add_f32s(share, simd.sub_f32s(at, *c), *c);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Run;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_round_draws_the_first_of_the_nearest_and_its_neighbors(
            nodes in prop::collection::vec((0..12u8, 0..12u8), 1..70),
            place in (0..12u8, 0..12u8),
            sigma in 0.3..4.0f32,
        ) {
            let [mut x, mut y] = [(); 2].map(|()| vec![NOWHERE; nodes.len().next_multiple_of(LANES)]);
            for (i, &node) in nodes.iter().enumerate() {
                (x[i], y[i]) = (node.0.into(), node.1.into());
            }
            let mut pixels = Pixels::default();
            let (from, row) = (place.0.into(), place.1.into());
            pixels.push(Run { y: row, from, to: from + 1 });
            let square = |&(x, y): &(u8, u8)| {
                let [dx, dy] = [i32::from(x) - i32::from(place.0), i32::from(y) - i32::from(place.1)];
                dx * dx + dy * dy
            };
            // `min_by_key` also returns the first of several.
            let winner = (0..nodes.len()).min_by_key(|&i| square(&nodes[i])).expect("there is a node");
            for arch in [Arch::new(), Arch::Plain] {
                let (mut found_x, mut found_y) = (x.clone(), y.clone());
                let training = Training { rounds: 1, rate: 0.5, sigma };
                arch.dispatch(Train {
                    pixels: &pixels,
                    training,
                    random: SplitMix64::new(0),
                    count: nodes.len(),
                    nodes: [&mut found_x, &mut found_y],
                });
                for i in 0..x.len() {
                    let away = (i.abs_diff(winner) as f32 / sigma).powi(2);
                    let share = if i < nodes.len() { 0.5 * (-0.5 * away).exp() } else { 0.0 };
                    for (found, c, at) in [(found_x[i], x[i], place.0), (found_y[i], y[i], place.1)] {
                        let expected = c + share * (f32::from(at) - c);
                        prop_assert!((found - expected).abs() <= 1e-5, "{}: {} {}", i, found, expected);
                    }
                }
            }
        }
    }
}
