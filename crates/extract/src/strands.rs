//! Edges joined through crossings: each rope as a list of edges in their order.

use crate::graph::Graph;
use crate::pairing::Pairing;
use crate::skeleton::NONE;
use crate::zones::{Arm, Zones};

/// One edge on the way along a rope.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Leg {
    pub(crate) edge: u32,
    /// Whether the rope runs from the edge's second node to its first.
    pub(crate) reversed: bool,
    /// Pixels left out at the leg's start and end, because they lie in a crossing.
    pub(crate) trim: [u32; 2],
}

/// One rope: a range of `Strands::legs`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Strand {
    pub(crate) from: u32,
    pub(crate) to: u32,
    pub(crate) closed: bool,
    /// The length of its edges, in pixels of the skeleton.
    pub(crate) length_px: f32,
}

/// Memory and result of the step.
#[derive(Debug, Default)]
pub(crate) struct Strands {
    pairing: Pairing,
    /// For each end of each edge (2·edge + end) the end that it goes on to, or `NONE`.
    link: Vec<u32>,
    /// The pixels to leave out there.
    trim: Vec<u32>,
    used: Vec<bool>,
    pub(crate) legs: Vec<Leg>,
    /// The ropes, the longest first.
    pub(crate) strands: Vec<Strand>,
}

impl Strands {
    /// Pairs the arms of each zone and follows each rope from end to end.
    pub(crate) fn join(&mut self, yuv: bool, graph: &Graph, zones: &Zones) {
        self.link.clear();
        self.link.resize(2 * graph.edges.len(), NONE);
        self.trim.clear();
        self.trim.resize(2 * graph.edges.len(), 0);
        let mut from = 0;
        while from < zones.arms.len() {
            let to = zones.zone_end(from);
            self.pair_zone(yuv, &zones.arms[from..to]);
            from = to;
        }
        self.walk(graph, zones);
    }

    fn pair_zone(&mut self, yuv: bool, arms: &[Arm]) {
        let slot = |i: usize| 2 * arms[i].edge as usize + usize::from(arms[i].end);
        for (i, &j) in self.pairing.resolve(arms, yuv).iter().enumerate() {
            self.trim[slot(i)] = arms[i].trim;
            if j != i {
                self.link[slot(i)] = slot(j) as u32;
            }
        }
    }

    /// Follows links from every loose end, then around what is left.
    fn walk(&mut self, graph: &Graph, zones: &Zones) {
        self.legs.clear();
        self.strands.clear();
        self.used.clear();
        self.used.extend_from_slice(&zones.inside);
        for slot in 0..self.link.len() {
            if self.link[slot] == NONE && graph.edges[slot / 2].nodes[0] != NONE {
                self.follow(slot, graph);
            }
        }
        for slot in (0..self.link.len()).step_by(2) {
            self.follow(slot, graph);
        }
        self.strands
            .sort_unstable_by(|a, b| b.length_px.total_cmp(&a.length_px));
    }

    /// Follows the rope that starts at end `slot % 2` of edge `slot / 2`, unless it is known.
    fn follow(&mut self, start: usize, graph: &Graph) {
        let from = self.legs.len() as u32;
        let (mut slot, mut length_px) = (start, 0.0);
        let closed = loop {
            let edge = slot / 2;
            if self.used[edge] {
                break true;
            }
            self.used[edge] = true;
            let far = slot ^ 1;
            self.legs.push(Leg {
                edge: edge as u32,
                reversed: slot % 2 == 1,
                trim: [self.trim[slot], self.trim[far]],
            });
            length_px += graph.edges[edge].length_px;
            if self.link[far] == NONE {
                break graph.edges[edge].nodes[0] == NONE;
            }
            slot = self.link[far] as usize;
        };
        if from < self.legs.len() as u32 {
            let to = self.legs.len() as u32;
            self.strands.push(Strand {
                from,
                to,
                closed,
                length_px,
            });
        }
    }
}
