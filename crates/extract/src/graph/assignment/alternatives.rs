//! The alternatives of a cluster with their features, for learning the weights.

use super::Cluster;
use super::ends::{Strands, node};
use super::features::{self, COUNT, FEATURES, Features, cost};
use super::joins::{extend, join_features};
use super::solver::{Choice, Solver};
use crate::vec2;

/// An assignment of a cluster.
#[derive(Debug, Clone, Default)]
pub struct Alternative {
    /// Sums of its features, in the order of [`FEATURES`].
    pub features: [f32; COUNT],
    /// Its joins: positions of both ends, and directions into the crossing, in pixels.
    pub joins: Vec<[[f32; 2]; 4]>,
    /// Length of the edges that each join passes, in pixels.
    pub passed_px: Vec<f32>,
    /// Its ends: position and direction.
    pub ends: Vec<[[f32; 2]; 2]>,
    /// Middles of edges without a strand, and their direction.
    pub left_out: Vec<[[f32; 2]; 2]>,
    /// Half-width of strands, in pixels.
    pub half_px: f32,
}

impl Cluster<'_> {
    /// Lists the assignments that the solver found.
    pub(super) fn alternatives(&self, solver: &Solver) -> Vec<Alternative> {
        let found = solver.costs().enumerate();
        found
            .map(|(k, cost)| self.alternative(solver.choices(k), cost))
            .collect()
    }

    fn alternative(
        &self,
        choices: impl Iterator<Item = (u8, Choice)>,
        cost_of_it: f32,
    ) -> Alternative {
        let graph = self.of.graph;
        let mut of_it = Alternative {
            half_px: self.zones.half_px,
            ..Alternative::default()
        };
        let mut sum = [0.0; COUNT];
        let mut add = |features: Features| {
            sum.iter_mut().zip(features).for_each(|(s, f)| *s += f);
        };
        let mut passes = vec![0; self.edges.len()];
        let mut is_leg = vec![true; self.edges.len()];
        for (local, choice) in choices {
            let slot = self.slot(local);
            match choice {
                Choice::NoLeg => is_leg[usize::from(local / 2)] = false,
                Choice::End => {
                    add(self.ends.end_features(slot, graph, self.zones));
                    if graph.nodes[node(slot, graph) as usize].degree >= 2 {
                        let arm = &self.ends.mouths[slot as usize].arm;
                        of_it.ends.push([arm.at, arm.into]);
                    }
                }
                Choice::Join(j) => {
                    let join = &self.joins.found[j as usize];
                    let mut stretch = Vec::new();
                    for &slot in join.passed() {
                        extend(&mut stretch, slot, graph);
                        passes[self.place[slot as usize / 2] as usize] += 1;
                    }
                    let mouths = join.slots.map(|slot| &self.ends.mouths[slot as usize]);
                    let of = (self.of, self.zones);
                    add(join_features(mouths, join.passed(), &stretch, of));
                    let [a, b] = mouths.map(|mouth| &mouth.arm);
                    of_it.joins.push([a.at, a.into, b.at, b.into]);
                    let length_px = |&slot: &u32| graph.edges[slot as usize / 2].length_px;
                    of_it
                        .passed_px
                        .push(join.passed().iter().map(length_px).sum());
                }
            }
        }
        for (place, &e) in self.edges.iter().enumerate() {
            let strands = match (is_leg[place], passes[place]) {
                (true, 0) => Strands::One,
                (false, 0) => Strands::None,
                (false, 1) => Strands::Passing,
                _ => Strands::Several,
            };
            add(self.ends.edge_features(e as usize, strands));
            if strands == Strands::None {
                let pixels = graph.pixels(e as usize);
                let at = |k: usize| self.of.skeleton.pixels[pixels[k] as usize].at();
                let n = pixels.len();
                of_it
                    .left_out
                    .push([at(n / 2), vec2::sub(at(n - 1), at(0))]);
            }
        }
        // The other features do not explain the cost of rings.
        let rings = (cost_of_it - cost(&sum)) / FEATURES[features::RING].1;
        sum[features::RING] = rings.round().max(0.0);
        of_it.features = sum;
        of_it
    }
}
