//! Edges joined through crossings: each rope as a list of edges in their order.

use super::arm::Arm;
use super::pairing::{Pairing, cost};
use super::walk::Walker;
use super::zones::Zones;
use super::{Graph, double_crossing};
use crate::bitmap::bits::BitPlane;
use crate::past::Past;
use crate::skeleton::{NONE, Skeleton};

/// What more the pairings of a crossing may cost to make one rope of a ring and a strand: a bend by
/// some 35° each.
const RING: f32 = 0.35;
/// How many times a ring's own bend in the crossing counts then. A ring that crosses a strand runs
/// straight there; one that touches it and must bend to close is more likely the loop of a rope.
const RING_BEND: f32 = 1.25;

/// Rings that are opened: no picture of ropes has as many.
const MOST_RINGS: usize = 64;

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
    pub(crate) walker: Walker,
    /// For each end of each edge (2·edge + end) the end that it goes on to, or `NONE`.
    link: Vec<u32>,
    /// The arm there, as an index into `Zones::arms`, or `NONE`.
    arm: Vec<u32>,
    used: Vec<bool>,
    /// For each edge its strand, by where that begins in `legs`.
    strand_of: Vec<u32>,
    pub(crate) legs: Vec<Leg>,
    /// The ropes, the longest first.
    pub(crate) strands: Vec<Strand>,
}

impl Strands {
    /// Makes room for the walks of a tangled rope.
    pub(crate) fn reserve(&mut self) {
        self.walker.reserve();
        self.legs.reserve(256);
        self.strands.reserve(64);
    }

    /// Pairs the arms of each zone and follows each rope from end to end. In a `mask` that is of ropes alone, those that are wound up
    /// are walked through.
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
        double_crossing::resolve(&mut self.link, &self.arm, (graph, skeleton, zones), yuv);
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

    /// Pixels of the end `slot` that lie in a crossing.
    fn trim(&self, slot: usize, zones: &Zones) -> u32 {
        zones
            .arms
            .get(self.arm[slot] as usize)
            .map_or(0, |arm| arm.trim)
    }

    /// Ropes have ends: where a ring touches another strand in a crossing and exchanging their
    /// partners there costs little, they are one rope. Returns whether a pair was exchanged.
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
                        // Tight loops lie too close to themselves for sides.
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

    /// Follows links from every loose end, then around what is left.
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

    /// Follows the rope that starts at end `slot % 2` of edge `slot / 2`, unless it is known.
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
