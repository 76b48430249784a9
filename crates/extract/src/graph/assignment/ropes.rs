//! The ropes of an assignment: its strands from end to end.

use super::joins::extend;
use super::links::Links;
use crate::graph::Graph;
use crate::graph::strands::{Leg, Strand};
use crate::skeleton::NONE;

/// Buffers and result of the step.
#[derive(Debug, Default)]
pub(super) struct Ropes {
    /// Pixels of passed edges, for the legs before them.
    pub(super) shared: Vec<u32>,
    pub(super) legs: Vec<Leg>,
    /// The ropes, the longest first.
    pub(super) strands: Vec<Strand>,
    stretch: Vec<u32>,
    used: Vec<bool>,
}

impl Ropes {
    pub(super) fn reserve(&mut self, edges: usize) {
        self.shared.reserve(8 * edges);
        self.legs.reserve(edges);
        self.strands.reserve(edges);
        self.stretch.reserve(8 * edges);
        self.used.reserve(edges);
    }

    /// Follows links from every loose end, then around the remaining rings. `trim` is the number of
    /// pixels at a slot that belong to a crossing, `half_px` the half-width of the wider strand along
    /// an edge.
    pub(super) fn follow_all(
        &mut self,
        links: &Links,
        (trim, half_px): (impl Fn(usize) -> u32 + Copy, impl Fn(usize) -> f32 + Copy),
        graph: &Graph,
    ) {
        self.legs.clear();
        self.strands.clear();
        self.shared.clear();
        self.used.clear();
        self.used.resize(graph.edges.len(), false);
        links.passed_edges().for_each(|e| self.used[e] = true);
        for slot in 0..2 * graph.edges.len() {
            if links.next[slot] == NONE && graph.edges[slot / 2].nodes[0] != NONE {
                self.follow(slot, links, (trim, half_px), graph);
            }
        }
        for slot in (0..2 * graph.edges.len()).step_by(2) {
            self.follow(slot, links, (trim, half_px), graph);
        }
        self.strands
            .sort_unstable_by(|a, b| b.length_px.total_cmp(&a.length_px));
    }

    /// Follows the rope that starts at end `start % 2` of edge `start / 2`, unless its edge is in
    /// use.
    fn follow(
        &mut self,
        start: usize,
        links: &Links,
        (trim, half_px): (impl Fn(usize) -> u32 + Copy, impl Fn(usize) -> f32 + Copy),
        graph: &Graph,
    ) {
        let from = self.legs.len() as u32;
        let (mut slot, mut length_px) = (start, 0.0);
        let closed = loop {
            let edge = slot / 2;
            if self.used[edge] {
                break true;
            }
            self.used[edge] = true;
            let far = slot ^ 1;
            let shared = self.shared_after(far, links, graph);
            let passed = links.join_at(far).and_then(|join| join.passed().first());
            self.legs.push(Leg {
                edge: edge as u32,
                reversed: slot % 2 == 1,
                trim: [slot, far].map(trim),
                shared,
                shared_half_px: passed.map_or(0.0, |&slot| half_px(slot as usize / 2)),
            });
            length_px += graph.edges[edge].length_px;
            if links.next[far] == NONE {
                break graph.edges[edge].nodes[0] == NONE;
            }
            slot = links.next[far] as usize;
        };
        if from < self.legs.len() as u32 {
            self.strands.push(Strand {
                from,
                to: self.legs.len() as u32,
                closed,
                length_px,
            });
        }
    }

    /// Lists the pixels of the edge passed behind a slot. Returns their range in `shared`. Several
    /// edges in a row may have other strands at each, so they are not laid.
    fn shared_after(&mut self, slot: usize, links: &Links, graph: &Graph) -> [u32; 2] {
        let from = self.shared.len();
        if let Some(join) = links.join_at(slot).filter(|join| join.passed().len() == 1) {
            self.stretch.clear();
            join.passed_from(slot as u32)
                .for_each(|slot| extend(&mut self.stretch, slot, graph));
            self.shared.extend_from_slice(&self.stretch);
        }
        [from, self.shared.len()].map(|at| at as u32)
    }
}
