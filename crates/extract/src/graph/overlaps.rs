//! Overlaps that width alone does not show: an edge between two junctions of three arms each.
//!
//! A junction of three arms is rare: it needs an end on a rope, and a rope has only two ends. Two
//! such junctions joined by an edge are far more often one crossing at a flat angle, or two strands
//! that run along each other. The edge is then both strands at once.
//!
//! For each such edge, the costs of two hypotheses are compared. The first, apart, pairs the arms
//! of each junction by itself. The second, overlap, pairs the four outer arms as if the overlap
//! were straight, and adds a cost per width of its length. The overlap is taken if it costs less.
//! If candidates share a zone, only the one with the largest gain can be taken.
//!
//! If two edges join the same two junctions, the longer one is the loop of a strand and is never
//! the overlap. Otherwise a rope would be on top of itself all the way around.

use super::Graph;
use super::arm::Arm;
use super::pairing::{ALONE, ALONE_TOO, Pairing};
use super::unroll::Unroll;
use super::zones::Zones;
use crate::image::{Image, color};
use crate::skeleton::{NONE, Skeleton};

/// Maximum length of an overlap that does not show in the mask's width, in widths.
const LONGEST_WIDTHS: f32 = 12.0;
/// Cost of an overlap per width of its length: a longer one is less likely.
const PER_WIDTH: f32 = 0.04;

/// Buffers for comparing hypotheses.
#[derive(Debug, Default)]
pub(crate) struct Overlaps {
    pairing: Pairing,
    arms: Vec<Arm>,
    candidates: Vec<Candidate>,
    /// For each zone, true if a candidate with a larger gain has used it.
    asked: Vec<bool>,
}

#[derive(Clone, Copy, Debug)]
struct Candidate {
    gain: f32,
    edge: usize,
    zones: [u32; 2],
}

impl Overlaps {
    /// Reserves memory for the overlaps of ropes.
    pub(crate) fn reserve(&mut self) {
        const MOST: usize = 256;
        self.pairing.reserve();
        self.arms.reserve(MOST);
        self.candidates.reserve(MOST);
        self.asked.reserve(MOST);
    }

    /// Joins zones of three arms whose common edge costs less as an overlap.
    pub(crate) fn join(
        &mut self,
        image: &Image,
        graph: &Graph,
        skeleton: &Skeleton,
        zones: &mut Zones,
    ) {
        let yuv = color::is_yuv(image.format());
        self.candidates.clear();
        for e in 0..graph.edges.len() {
            let edge = &graph.edges[e];
            let widths = edge.length_px / (2.0 * zones.half_px);
            if zones.inside[e] || edge.nodes[0] == NONE {
                continue;
            }
            if widths > LONGEST_WIDTHS {
                continue;
            }
            let unroll = Unroll::of(e, graph, skeleton, zones.widest_half_px(e, graph));
            if let Some(candidate) = self.weigh(e, graph, unroll, widths, yuv, zones) {
                self.candidates.push(candidate);
            }
        }
        self.candidates
            .sort_unstable_by(|a, b| b.gain.total_cmp(&a.gain));
        self.asked.clear();
        self.asked.resize(graph.nodes.len(), false);
        for candidate in &self.candidates {
            let ends = candidate.zones.map(|zone| zone as usize);
            if !ends.iter().any(|&zone| self.asked[zone]) {
                zones.join(candidate.edge, graph);
            }
            ends.into_iter().for_each(|zone| self.asked[zone] = true);
        }
        if !self.candidates.is_empty() {
            zones.collect_arms(image, graph, skeleton);
        }
    }

    /// Returns edge `e` as a candidate, with its gain, if it costs less as an overlap.
    fn weigh(
        &mut self,
        e: usize,
        graph: &Graph,
        unroll: Option<Unroll>,
        widths: f32,
        yuv: bool,
        zones: &Zones,
    ) -> Option<Candidate> {
        let ends = [zones.arm_at(2 * e)?, zones.arm_at(2 * e + 1)?].map(|i| zones.arms[i].zone);
        if ends[0] == ends[1] {
            return None;
        }
        let arms = ends.map(|zone| &zones.arms[zones.arms_of(zone)]);
        if arms.iter().any(|arms| arms.len() != 3) {
            return None;
        }
        let detour = detour(e, arms);
        let length_px = |e: u32| graph.edges[e as usize].length_px;
        if detour.is_some_and(|detour| length_px(detour) < length_px(e as u32)) {
            return None;
        }
        self.arms.clear();
        let (mut apart, mut detour_alone) = (0.0, 0);
        for (zone, arms) in ends.into_iter().zip(arms) {
            for (i, &partner) in self
                .pairing
                .resolve(arms, &zones.past, yuv)
                .iter()
                .enumerate()
            {
                detour_alone += usize::from(partner == i && Some(arms[i].edge) == detour);
            }
            apart += self.pairing.best_cost;
            let kept = arms.iter().filter(|arm| arm.edge as usize != e);
            self.arms
                .extend(kept.map(|arm| laid_straight(*arm, unroll.as_ref(), zone == ends[1])));
        }
        if detour_alone == 2 {
            // If both ends of the detour stay alone, they are not two ends on two ropes, but both
            // ends of one rope at one place.
            apart += ALONE_TOO - ALONE;
        }
        self.pairing.resolve(&self.arms, &zones.past, yuv);
        let gain = apart - self.pairing.best_cost - PER_WIDTH * widths;
        (gain > 0.0).then_some(Candidate {
            gain,
            edge: e,
            zones: ends,
        })
    }
}

/// An arm of the overlap, as if the overlap were straight.
fn laid_straight(mut arm: Arm, unroll: Option<&Unroll>, is_far: bool) -> Arm {
    let Some(unroll) = unroll else { return arm };
    if is_far {
        unroll.apply(&mut arm);
    } else {
        unroll.tell_side(&mut arm);
    }
    // Sides are not compared yet, because tight loops bend too much for that.
    if unroll.changes_sides() {
        arm.side = 0.0;
    }
    arm
}

/// Returns another edge, if any, that joins the same two zones as edge `e`. `arms` are those zones'
/// arms.
fn detour(e: usize, arms: [&[Arm]; 2]) -> Option<u32> {
    let mut others = arms[0].iter().map(|arm| arm.edge);
    others.find(|&edge| edge as usize != e && arms[1].iter().any(|arm| arm.edge == edge))
}
