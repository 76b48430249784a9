//! Edges joined through crossings: each rope as a list of edges in order.

use super::Graph;
use super::arm::Arm;
use super::pairing::{Pairing, cost};
use super::walk::Walker;
use super::zones::Zones;
use crate::bitmap::bits::BitPlane;
use crate::past::Past;
use crate::skeleton::{NONE, Skeleton};

/// Maximum additional cost for merging a ring with a strand that it meets. It equals a bend by some
/// 35° in each of the two pairs.
const RING: f32 = 0.35;
/// Weight of a ring's own bend in the crossing, in the same comparison. A ring that crosses a
/// strand runs straight there. A ring that only touches it and must bend to close is more likely
/// the loop of a rope.
const RING_BEND: f32 = 1.25;

/// Maximum number of rings that are opened.
const MOST_RINGS: usize = 64;

/// One edge along a rope.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Leg {
    pub(crate) edge: u32,
    /// True if the rope runs from the edge's second node to its first.
    pub(crate) reversed: bool,
    /// Number of pixels left out at the leg's start and end because they are in a crossing.
    pub(crate) trim: [u32; 2],
}

/// One rope: a range of `Strands::legs`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Strand {
    pub(crate) from: u32,
    pub(crate) to: u32,
    pub(crate) closed: bool,
    /// Length of its edges, in pixels of the skeleton.
    pub(crate) length_px: f32,
}

/// Buffers and result of the step.
#[derive(Debug, Default)]
pub(crate) struct Strands {
    pairing: Pairing,
    pub(crate) walker: Walker,
    /// For each end of each edge (2·edge + end), the end at which its strand continues, or `NONE`.
    link: Vec<u32>,
    /// Arm of each end, as an index into `Zones::arms`, or `NONE`.
    arm: Vec<u32>,
    used: Vec<bool>,
    /// Strand of each edge, as its start in `legs`.
    strand_of: Vec<u32>,
    pub(crate) legs: Vec<Leg>,
    /// The ropes, the longest first.
    pub(crate) strands: Vec<Strand>,
}

impl Strands {
    /// Reserves memory for the walks of a tangled rope.
    pub(crate) fn reserve(&mut self) {
        self.walker.reserve();
        self.legs.reserve(256);
        self.strands.reserve(64);
    }

    /// Pairs the arms of each zone, follows each rope from end to end, and opens rings, in this
    /// order. With `mask`, which must contain ropes only, a walk then replaces pairings that cost
    /// more (see `walk`).
    pub(crate) fn join(
        &mut self,
        yuv: bool,
        graph: &Graph,
        skeleton: &Skeleton,
        zones: &mut Zones,
        mask: Option<&BitPlane>,
    ) {
        self.link.clear();
        self.link.resize(2 * graph.edges.len(), NONE);
        self.arm.clear();
        self.arm.resize(2 * graph.edges.len(), NONE);
        let mut from = 0;
        while from < zones.arms.len() {
            let to = zones.zone_end(from);
            self.pair_zone(yuv, from, &zones.arms[from..to], &zones.past);
            from = to;
        }
        self.walk(graph, zones);
        // Each round opens one ring.
        for _ in 0..MOST_RINGS {
            if !self.open_a_ring(yuv, zones) {
                break;
            }
            self.walk(graph, zones);
        }
        if let Some(mask) = mask {
            let ropes = (&mut self.legs, &mut self.strands);
            (self.walker).improve(ropes, (graph, skeleton), zones, mask);
        }
    }

    fn pair_zone(&mut self, yuv: bool, from: usize, arms: &[Arm], past: &Past) {
        for (i, &j) in self.pairing.resolve(arms, past, yuv).iter().enumerate() {
            self.arm[arms[i].slot()] = (from + i) as u32;
            if j != i {
                self.link[arms[i].slot()] = arms[j].slot() as u32;
            }
        }
    }

    /// Number of pixels at the end `slot` that are in a crossing.
    fn trim(&self, slot: usize, zones: &Zones) -> u32 {
        zones
            .arms
            .get(self.arm[slot] as usize)
            .map_or(0, |arm| arm.trim)
    }

    /// Merges a ring with a strand by exchanging their partners in a common zone. Takes the pair
    /// for which this adds the least cost, if that cost is below `RING`. Ropes have ends, so a ring
    /// is likely an error of the pairing. Returns whether it merged a pair.
    fn open_a_ring(&mut self, yuv: bool, zones: &Zones) -> bool {
        let mut best = (RING, [0; 4]);
        for ring in self.strands.iter().filter(|s| s.closed) {
            let legs = &self.legs[ring.from as usize..ring.to as usize];
            let in_ring = |slot: usize| self.strand_of[slot / 2] == ring.from;
            for leg in legs {
                let a = 2 * leg.edge as usize + usize::from(!leg.reversed);
                let Some(arm) = zones.arms.get(self.arm[a] as usize) else {
                    continue;
                };
                let b = self.link[a] as usize;
                for other in &zones.arms[zones.arms_of(arm.zone)] {
                    let c = other.slot();
                    let d = self.link[c];
                    if in_ring(c) || d == NONE {
                        continue;
                    }
                    let d = d as usize;
                    let cost = |i: usize, j: usize| {
                        // Sides are ignored, because tight loops are too close to themselves.
                        let arm = |slot: usize| Arm {
                            side: 0.0,
                            ..zones.arms[self.arm[slot] as usize]
                        };
                        cost(&arm(i), &arm(j), &zones.past, yuv)
                    };
                    let more = cost(a, c) + cost(b, d) - RING_BEND * cost(a, b) - cost(c, d);
                    if more < best.0 {
                        best = (more, [a, b, c, d]);
                    }
                }
            }
        }
        let (more, [a, b, c, d]) = best;
        if more < RING {
            for (i, j) in [(a, c), (b, d)] {
                (self.link[i], self.link[j]) = (j as u32, i as u32);
            }
        }
        more < RING
    }

    /// Builds the strands: follows links from every loose end, then around the remaining rings.
    fn walk(&mut self, graph: &Graph, zones: &Zones) {
        self.legs.clear();
        self.strands.clear();
        self.used.clear();
        self.used.extend_from_slice(&zones.inside);
        self.strand_of.clear();
        self.strand_of.resize(graph.edges.len(), NONE);
        for slot in 0..self.link.len() {
            if self.link[slot] == NONE && graph.edges[slot / 2].nodes[0] != NONE {
                self.follow(slot, graph, zones);
            }
        }
        for slot in (0..self.link.len()).step_by(2) {
            self.follow(slot, graph, zones);
        }
        self.strands
            .sort_unstable_by(|a, b| b.length_px.total_cmp(&a.length_px));
    }

    /// Follows the rope that starts at end `start % 2` of edge `start / 2`, unless its edge is in
    /// use.
    fn follow(&mut self, start: usize, graph: &Graph, zones: &Zones) {
        let from = self.legs.len() as u32;
        let (mut slot, mut length_px) = (start, 0.0);
        let closed = loop {
            let edge = slot / 2;
            if self.used[edge] {
                break true;
            }
            self.used[edge] = true;
            self.strand_of[edge] = from;
            let far = slot ^ 1;
            self.legs.push(Leg {
                edge: edge as u32,
                reversed: slot % 2 == 1,
                trim: [self.trim(slot, zones), self.trim(far, zones)],
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
