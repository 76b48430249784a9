//! A self-organizing map (T. Kohonen, Self-organized formation of topologically correct feature maps, Biological
//! Cybernetics 43, 1982): a line of nodes, of which one pixel after the other draws the nearest toward itself, and its
//! neighbors on the line less.
//!
//! ```text
//! in each round t of T: a pixel x, drawn at random
//!   the winner      w = argminⱼ |x − cⱼ|
//!   all nodes       cⱼ ← cⱼ + η e^(−(j − w)²/2σ²) (x − cⱼ)
//!   then narrower   η = η₀/(1 + 2t/T),  σ = σ₀/(1 + 2t/T)
//! ```
//!
//! This is `MiniSom(1, K, 2)` with its Gaussian neighborhood and its default decay, to a third of where it began.

use lariat_portable::{Arch, Simd, WithSimd};

use super::exponential::power_of_two;
use super::extent::Extent;
use super::seeding::Seeding;
use super::{Outcome, Pixels, Start};
use lariat_portable::SplitMix64;

/// Nodes that are worked on side by side, as many as the widest register holds.
const LANES: usize = 16;
/// Where no node is: so far from all pixels that it never is the nearest.
const NOWHERE: f32 = 1e18;
/// A neighbor so much less than the winner, e^(−u²/2), is not moved: 2⁻²⁴, what a float cannot tell from nothing.
const REACH: f32 = 5.768;
/// The samples of a map that continues are these, in every frame.
const CONTINUED: u64 = 0;

/// How long and how strongly a map is trained.
#[derive(Clone, Copy, Debug)]
pub(super) struct Training {
    /// Samples, one a round.
    rounds: u32,
    /// The share of the way to the sample that the winner goes, at first.
    rate: f32,
    /// The neighborhood's standard deviation in nodes, at first.
    sigma: f32,
}

impl Training {
    /// From a start that knows nothing. Each of 120 nodes wins some 80 rounds; the rate is MiniSom's default. Its
    /// default of σ = 1 is too narrow to straighten a line of 120 nodes that begins in no order: nodes whose neighbors lie
    /// on other parts of the rope stay between them, on the table. From 4 on the nodes are drawn together, and stand
    /// farther from the pixels in the end.
    pub(super) const COLD: Self = Self {
        rounds: 10_000,
        rate: 0.5,
        sigma: 3.0,
    };
    /// From the last frame's nodes: it goes on where the other one ends, at a third of its rate and σ. A node is met often
    /// enough, some 17 times of 120 nodes, to go nine tenths of the way to where the rope now is.
    const CONTINUED: Self = Self {
        rounds: 2_000,
        rate: Self::COLD.rate / 3.0,
        sigma: Self::COLD.sigma / 3.0,
    };
}

/// A self-organizing map: a line of nodes. Keeps its memory from run to run.
#[derive(Debug, Default)]
pub struct Som {
    seeding: Seeding,
    /// The nodes, x and y, filled up to whole registers.
    nodes: [Vec<f32>; 2],
}

impl Som {
    /// Trains the map whose nodes are `centers` on `pixels`, drawn at random: the same for the same start. From
    /// [`Start::Seeded`] for 10,000 rounds, from [`Start::Given`] for 2,000 that move less. The centers stay within the
    /// box around the pixels, and neighbors in the list mostly are neighbors on the rope. Without pixels nothing changes.
    ///
    /// The objective is the quantization error, the pixels' mean distance from the nearest center in pixels; a round is
    /// one sample.
    pub fn run(&mut self, pixels: &Pixels, start: Start, centers: &mut [[f32; 2]]) -> Outcome {
        self.seeding.begin(pixels, start, centers);
        let (training, seed) = match start {
            Start::Seeded(seed) => (Training::COLD, seed),
            Start::Given => (Training::CONTINUED, CONTINUED),
        };
        self.train(pixels, training, seed, centers)
    }

    /// Trains on the pixels that a generator begun at `seed` draws.
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
        // Rounding may have led a node just outside.
        extent.confine(centers);
        Outcome {
            rounds: training.rounds,
            objective,
        }
    }
}

/// The whole of it; returns the quantization error.
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
    /// The node nearest to a place, the first of several, and the square of its distance.
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

    /// Draws the winner and those around it toward a place.
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
            // What only fills up the registers stays where it is.
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
            // The first of several is what this takes as well.
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
