//! The ends of edges at each node, and what is known of each edge: the ground for all features of
//! edges and ends.

use super::Ground;
use super::features::{self, Features};
use super::mouth::{Mouth, mouth};
use crate::graph::Graph;
use crate::graph::forest::{join, root};
use crate::graph::zones::Zones;
use crate::skeleton::NONE;

/// Relative half-widths: the maximum for one strand, the minimum for two, and the cap of an excess or a
/// lack.
const ONE: f32 = 1.1;
const TWO: f32 = 1.4;
const MOST_EXCESS: f32 = 0.6;

/// Strands on an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Strands {
    None,
    /// One that has the edge as a leg.
    One,
    Several,
    /// One that only passes it.
    Passing,
}

impl Strands {
    /// In the order of `EdgeCosts`.
    pub(super) const ALL: [Self; 4] = [Self::None, Self::One, Self::Several, Self::Passing];
}

/// Ends of edges by node. Slot 2·e + end is an end of edge e.
#[derive(Debug, Default)]
pub(super) struct Ends {
    /// Slots at each node, node by node. `from` holds each node's start.
    slots: Vec<u32>,
    from: Vec<u32>,
    pub(super) mouths: Vec<Mouth>,
    /// Mean half-width of each edge, relative to the usual one.
    pub(super) ratio: Vec<f32>,
    /// Length of each edge, in widths.
    pub(super) widths: Vec<f32>,
    /// For each node, the first node of its connected piece. For those, the number of tips.
    pub(super) pieces: Vec<u32>,
    tips: Vec<u32>,
}

impl Ends {
    pub(super) fn reserve(&mut self, edges: usize) {
        self.slots.reserve(2 * edges);
        self.mouths.reserve(2 * edges);
        self.ratio.reserve(edges);
        self.widths.reserve(edges);
        for of_nodes in [&mut self.from, &mut self.pieces, &mut self.tips] {
            of_nodes.reserve(2 * edges);
        }
    }

    /// Measures all ends and edges.
    pub(super) fn measure(&mut self, of: Ground, zones: &Zones) {
        self.list_slots(of.graph);
        self.count_tips(of.graph);
        self.mouths.clear();
        self.ratio.clear();
        self.widths.clear();
        for (e, edge) in of.graph.edges.iter().enumerate() {
            let pixels = of.graph.pixels(e);
            let half = |&p: &u32| of.skeleton.pixels[p as usize].half_px;
            let mean_px = pixels.iter().map(half).sum::<f32>() / pixels.len() as f32;
            self.ratio
                .push((mean_px - 0.2) / zones.usual_half_px(e, of.graph));
            self.widths.push(edge.length_px / (2.0 * zones.half_px));
            for end in 0..2 {
                // The entries of a ring without junctions are never read.
                self.mouths.push(match edge.nodes[0] {
                    NONE => Mouth::NONE,
                    _ => mouth(e, end, of, zones),
                });
            }
        }
    }

    fn list_slots(&mut self, graph: &Graph) {
        self.from.clear();
        self.from.resize(graph.nodes.len() + 1, 0);
        let edges = || graph.edges.iter().enumerate();
        let joined = || edges().filter(|(_, edge)| edge.nodes[0] != NONE);
        for node in joined().flat_map(|(_, edge)| edge.nodes) {
            self.from[node as usize] += 1;
        }
        // These are the ends of each node's range. The ranges are filled from the back.
        for n in 1..self.from.len() {
            self.from[n] += self.from[n - 1];
        }
        let all = self.from.last().map_or(0, |&all| all as usize);
        self.slots.clear();
        self.slots.resize(all, NONE);
        for (e, edge) in joined() {
            for (end, &node) in edge.nodes.iter().enumerate() {
                self.from[node as usize] -= 1;
                self.slots[self.from[node as usize] as usize] = (2 * e + end) as u32;
            }
        }
    }

    /// Counts the tips of each connected piece of the skeleton.
    fn count_tips(&mut self, graph: &Graph) {
        let nodes = graph.nodes.len();
        self.pieces.clear();
        self.pieces.extend(0..nodes as u32);
        for edge in graph.edges.iter().filter(|edge| edge.nodes[0] != NONE) {
            join(&mut self.pieces, edge.nodes);
        }
        self.tips.clear();
        self.tips.resize(nodes, 0);
        for node in 0..nodes {
            self.pieces[node] = root(&mut self.pieces, node as u32);
            let is_tip = graph.nodes[node].degree == 1;
            self.tips[self.pieces[node] as usize] += u32::from(is_tip);
        }
    }

    /// Slots at a node.
    pub(super) fn at(&self, node: u32) -> &[u32] {
        let [from, to] = [node, node + 1].map(|node| self.from[node as usize] as usize);
        &self.slots[from..to]
    }

    /// Features of an edge with these strands.
    pub(super) fn edge_features(&self, e: usize, strands: Strands) -> Features {
        let mut features = [0.0; features::COUNT];
        let (widths, ratio) = (self.widths[e], self.ratio[e]);
        let excess = (ratio - ONE).clamp(0.0, MOST_EXCESS) * (0.5 + widths);
        match strands {
            Strands::None => features[features::LEFT_OUT] = widths,
            Strands::One => features[features::ONE_IN_WIDE] = excess,
            Strands::Several => {
                features[features::TWO_IN_NARROW] = (TWO - ratio).clamp(0.0, MOST_EXCESS) * widths;
            }
            Strands::Passing => {
                features[features::ONE_IN_WIDE] = excess;
                features[features::PASSED] = (widths - 1.0).max(0.0);
            }
        }
        features
    }

    /// Features of an end at a slot.
    pub(super) fn end_features(&self, slot: u32, graph: &Graph, zones: &Zones) -> Features {
        let mut features = [0.0; features::COUNT];
        let node = node(slot, graph) as usize;
        if graph.nodes[node].degree >= 2 {
            features[features::END] = 1.0;
            let tips = self.tips[self.pieces[node] as usize];
            features[features::END_OF_ONE] = f32::from(tips == 2);
            let arm = &self.mouths[slot as usize].arm;
            features[features::PRIOR_END] = zones.past.against_end(&arm.past);
        }
        features
    }
}

/// Node at a slot.
pub(super) fn node(slot: u32, graph: &Graph) -> u32 {
    graph.edges[slot as usize / 2].nodes[slot as usize % 2]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::assignment::features::cost;

    #[test]
    fn the_wider_a_stretch_the_more_strands_it_has() {
        let ratios = [0.9, 1.0, 1.1, 1.2, 1.3, 1.4, 1.6, 1.8];
        let ends = Ends {
            ratio: ratios.to_vec(),
            widths: vec![3.0; ratios.len()],
            ..Ends::default()
        };
        // Cost of one strand minus that of two.
        let excess = |e: usize| {
            let [one, two] =
                [Strands::One, Strands::Several].map(|s| cost(&ends.edge_features(e, s)));
            one - two
        };
        assert!((1..ratios.len()).all(|e| excess(e) >= excess(e - 1)));
        assert!(excess(0) < 0.0 && excess(ratios.len() - 1) > 0.0);
    }

    #[test]
    fn the_longer_a_stretch_the_more_it_costs_to_leave_it_out() {
        let ends = Ends {
            ratio: vec![1.0; 4],
            widths: vec![0.5, 1.0, 2.0, 4.0],
            ..Ends::default()
        };
        for strands in [Strands::None, Strands::Several, Strands::Passing] {
            let costs = [0, 1, 2, 3].map(|e| cost(&ends.edge_features(e, strands)));
            assert!(costs.is_sorted(), "{strands:?} {costs:?}");
        }
    }
}
