//! Walks: one rope, or a few, through a whole connected piece of the mask.
//!
//! Deciding each crossing by itself fails where several merge. It cuts off rings that do not exist,
//! exchanges strands, or leaves a part of the mask to no rope. A piece of the mask with two tips is
//! mostly one rope, that is, a walk over the skeleton from one tip to the other. The walk takes
//! each edge that is a single strand once, and passes edges where strands overlap any number of
//! times. A piece with more tips is several ropes, found one after the other. Each starts at the
//! first unused tip, and ends at another tip or on a strand.
//!
//! A beam search looks for the cheapest walk. Its cost is the sum of:
//!
//! - the joints between edges: bending beyond that of the strands themselves, difference in width,
//!   and the part outside of the mask;
//! - edges passed although they are a single strand, and overlaps taken as a single strand;
//! - edges of the piece that it leaves out, and, with several ropes, overlaps that only one strand
//!   runs over;
//! - ends that are not tips.
//!
//! The result of the pairing is scored by the same cost. The walk replaces that result if the
//! result costs more by a margin (`BETTER`). The piece must also be several ropes, a rope that is
//! wound up, or a rope that the pairing split. See `Walker::improve` for the exceptions.

mod piece;

use super::Graph;
use super::strands::{Leg, Strand};
use super::zones::Zones;
use crate::bitmap::bits::BitPlane;
use crate::skeleton::{NONE, Skeleton};
use piece::{Component, Ground, Visited, is_tip};

/// Number of walks kept after each step.
const BEAM: usize = 128;
/// Maximum number of walks after a step, before only the cheapest are kept.
const MOST_NEXT: usize = 4096;
/// Size of the hash table of those walks.
const PLACES: usize = 2 * MOST_NEXT;
/// Number of steps, over all walks, at which the search stops.
const MOST_STEPS: usize = 16384;
/// Cost of an end that is not a tip.
const END: f32 = 0.6;
/// Cost of a ring.
const RING: f32 = 0.6;
/// Maximum cost of a joint between two legs, without the cost of the second leg. It is also the
/// cost if no way joins them.
const TORN: f32 = 2.0;
/// Minimum gain for which a walk of one rope replaces the result of the pairing.
const BETTER: f32 = 0.15;
/// Same minimum for a walk of several ropes.
const BETTER_AS_SEVERAL: f32 = 0.3;
/// The last step of a walk. `before` leads to the others.
#[derive(Clone, Copy, Debug)]
struct Step {
    before: u32,
    /// End of an edge at which the walk leaves it. A rope starts with an edge whose other end is a
    /// tip.
    slot: u32,
    cost: f32,
    seen: Visited,
}

/// Buffers and result of the search.
#[derive(Debug, Default)]
pub(crate) struct Walker {
    piece: Component,
    steps: Vec<Step>,
    next: Layer,
    /// Last steps and total costs of the finished walks, the cheapest first.
    done: Vec<(u32, f32)>,
    way: Vec<u32>,
}

impl Walker {
    /// Reserves memory for the walks of a tangled rope.
    pub(crate) fn reserve(&mut self) {
        self.piece.reserve();
        self.steps.reserve(MOST_STEPS + MOST_NEXT);
        self.next.reserve();
        self.done.reserve(MOST_STEPS + MOST_NEXT);
        self.way.reserve(128);
    }

    /// Replaces the strands of each piece by its best walk if the strands cost more.
    ///
    /// Some pieces are not changed. A piece with two tips is kept if it is a single strand that is
    /// not wound up. A piece with more tips is kept if its strands have legs that no way joins, or
    /// if an edge with a tip is wide. In the latter case, widths do not show overlaps.
    pub(crate) fn improve(
        &mut self,
        (legs, strands): (&mut Vec<Leg>, &mut Vec<Strand>),
        (graph, skeleton): (&Graph, &Skeleton),
        zones: &mut Zones,
        mask: &BitPlane,
    ) {
        self.piece.find(graph);
        for k in 0..self.piece.candidates.len() {
            let of = Ground {
                graph,
                skeleton,
                zones,
                mask,
            };
            self.piece.gather(self.piece.candidates[k], of);
            // A rope that the pairing found as one strand is right more often than the cheapest
            // walk, unless it is wound up.
            let (before, ropes, is_torn) = self.cost_of(legs, strands, of);
            let is_one = self.piece.tips.len() == 2;
            let is_left = match is_one {
                true => ropes == 1 && !self.piece.is_wound(),
                false => is_torn || self.piece.has_wide_tip(),
            };
            if is_left {
                continue;
            }
            self.search(of);
            let Some(&(_, cost)) = self.done.first() else {
                continue;
            };
            let better = if is_one { BETTER } else { BETTER_AS_SEVERAL };
            if cost + better < before {
                self.take(legs, strands, graph, zones);
            }
        }
    }

    /// Returns the cost of the piece's strands as a walk, their number, and whether they have legs
    /// that no way joins.
    fn cost_of(&self, legs: &[Leg], strands: &[Strand], of: Ground) -> (f32, usize, bool) {
        let (mut cost, mut seen, mut ropes, mut is_torn) = (0.0, Visited::default(), 0, false);
        for strand in strands {
            let legs = &legs[strand.from as usize..strand.to as usize];
            let bits = legs.iter().map(|leg| self.piece.bit(leg.edge));
            let Some(bits) = bits.sum::<Option<u128>>() else {
                continue;
            };
            seen.used |= bits;
            ropes += 1;
            let leg = |leg: &Leg| self.piece.costs(leg.edge, of)[1];
            let mut join = |a: &Leg, b: &Leg| {
                let ways = self.piece.onward(out(a)).iter();
                let way = ways.copied().find(|way| way.slot == into(b));
                seen.pass(way.map_or(0, |way| way.passed));
                is_torn |= way.is_none();
                cost += way.map_or(f32::INFINITY, |way| way.cost).min(TORN + leg(b));
            };
            legs.windows(2).for_each(|pair| join(&pair[0], &pair[1]));
            let (first, last) = (&legs[0], &legs[legs.len() - 1]);
            if strand.closed {
                join(last, first);
                cost += RING;
            } else {
                let ends = [into(first), out(last)].into_iter();
                let loose = ends.filter(|&slot| !is_tip(slot, of.graph));
                cost += END * loose.count() as f32 + leg(first);
            }
        }
        (cost + self.piece.left_out(&seen), ropes, is_torn)
    }

    /// Searches for the cheapest walks. Several ropes are one walk: where one rope ends, the next
    /// one starts.
    fn search(&mut self, of: Ground) {
        self.steps.clear();
        self.next.restart();
        self.done.clear();
        let nowhere = Step {
            before: NONE,
            slot: NONE,
            cost: 0.0,
            seen: Visited::default(),
        };
        self.steps.extend(begin(&self.piece, nowhere, of));
        let (mut layer, mut least) = (0..self.steps.len(), f32::INFINITY);
        while !layer.is_empty() && self.steps.len() < MOST_STEPS {
            self.next.clear();
            for s in layer {
                least = self.go_on(s as u32, least, of);
            }
            let Self {
                piece,
                steps,
                next,
                done,
                ..
            } = self;
            let next = next.sorted();
            let from = steps.len();
            for step in next.iter().filter(|step| is_tip(step.slot, of.graph)) {
                let cost = step.cost + piece.left_out(&step.seen);
                least = least.min(cost);
                done.push((steps.len() as u32, cost));
                steps.push(*step);
            }
            let goes_on = |step: &&Step| !is_tip(step.slot, of.graph) && step.cost < least;
            steps.extend(next.iter().filter(goes_on).take(BEAM));
            layer = from..steps.len();
        }
        (self.done).sort_unstable_by(|a, b| a.1.total_cmp(&b.1));
    }

    /// Adds the walks that continue step `s` by one more step, if they cost less than `least`.
    /// Returns the new least cost, as a walk may have ended here.
    fn go_on(&mut self, s: u32, least: f32, of: Ground) -> f32 {
        let piece = &self.piece;
        let step = Step {
            before: s,
            ..self.steps[s as usize]
        };
        if is_tip(step.slot, of.graph) {
            if let Some(first) = begin(piece, step, of) {
                self.next.enter(first);
            }
            return least;
        }
        for way in piece.onward(step.slot) {
            let bit = piece.bit(way.slot / 2).unwrap_or(0);
            let cost = step.cost + way.cost;
            if step.seen.used & bit == 0 && cost < least {
                let mut seen = step.seen;
                seen.used |= bit;
                seen.pass(way.passed);
                self.next.enter(Step {
                    slot: way.slot ^ 1,
                    cost,
                    seen,
                    ..step
                });
            }
        }
        // With more than two tips there are several ropes, so one may end on another.
        if piece.tips.len() == 2 {
            return least;
        }
        let cost = step.cost + END;
        if let Some(first) = begin(piece, Step { cost, ..step }, of) {
            self.next.enter(first);
            return least;
        }
        let cost = cost + piece.left_out(&step.seen);
        self.done.push((s, cost));
        least.min(cost)
    }

    /// Replaces the strands of the piece by the best walk.
    fn take(
        &mut self,
        legs: &mut Vec<Leg>,
        strands: &mut Vec<Strand>,
        graph: &Graph,
        zones: &mut Zones,
    ) {
        let piece = &self.piece;
        let last = self.done[0].0;
        let used = self.steps[last as usize].seen.used;
        strands.retain(|strand| piece.bit(legs[strand.from as usize].edge).is_none());
        for (k, &e) in piece.edges.iter().enumerate() {
            zones.inside[e as usize] = used >> k & 1 == 0;
        }
        let way = &mut self.way;
        trace(&self.steps, last, way);
        way.reverse();
        let trim = |slot: u32| match is_tip(slot, graph) {
            true => 0,
            false => piece.trim(slot),
        };
        let length = |slot: &u32| graph.edges[*slot as usize / 2].length_px;
        for rope in way.chunk_by(|_, next| !is_tip(next ^ 1, graph)) {
            let from = legs.len() as u32;
            legs.extend(rope.iter().map(|&slot| Leg {
                edge: slot / 2,
                reversed: slot.is_multiple_of(2),
                trim: [trim(slot ^ 1), trim(slot)],
            }));
            strands.push(Strand {
                from,
                to: legs.len() as u32,
                closed: false,
                length_px: rope.iter().map(length).sum(),
            });
        }
        strands.sort_unstable_by(|a, b| b.length_px.total_cmp(&a.length_px));
    }
}

/// End of a leg's edge at which the leg starts.
fn into(leg: &Leg) -> u32 {
    2 * leg.edge + u32::from(leg.reversed)
}

/// End of a leg's edge at which the leg ends.
fn out(leg: &Leg) -> u32 {
    into(leg) ^ 1
}

/// Continues a walk at the start of the next rope, on the first edge with an unused tip, if any.
/// `step` is the end of the previous rope.
fn begin(piece: &Component, step: Step, of: Ground) -> Option<Step> {
    let bit = |slot: u32| piece.bit(slot / 2).unwrap_or(0);
    let &tip = (piece.tips.iter()).find(|&&tip| step.seen.used & bit(tip) == 0)?;
    let mut seen = step.seen;
    seen.used |= bit(tip);
    Some(Step {
        slot: tip ^ 1,
        cost: step.cost + piece.costs(tip / 2, of)[1],
        seen,
        ..step
    })
}

/// Walks that are one step longer, without duplicates.
#[derive(Debug, Default)]
struct Layer {
    steps: Vec<Step>,
    /// Hash table, by a walk's edges and end. The low 16 bits are an index in `steps`. The high
    /// bits are the layer's number, so that entries of earlier layers need not be cleared.
    places: Vec<u32>,
    number: u32,
}

impl Layer {
    fn reserve(&mut self) {
        self.steps.reserve(MOST_NEXT);
        self.places.reserve(PLACES);
    }

    /// Clears all layers.
    fn restart(&mut self) {
        self.places.clear();
        self.places.resize(PLACES, 0);
        self.number = 0;
    }

    fn clear(&mut self) {
        self.steps.clear();
        self.number += 1;
    }

    /// Adds a walk, unless another one has reached the same end over the same edges at no greater
    /// cost.
    fn enter(&mut self, new: Step) {
        let used = new.seen.used;
        let mixed = (used as u64 ^ (used >> 64) as u64).wrapping_add(u64::from(new.slot) << 40);
        let mut k = (mixed.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 48) as usize % PLACES;
        loop {
            let place = self.places[k];
            if place >> 16 != self.number {
                if self.steps.len() < MOST_NEXT {
                    self.places[k] = self.number << 16 | self.steps.len() as u32;
                    self.steps.push(new);
                }
                return;
            }
            let old = &mut self.steps[place as usize & 0xffff];
            if old.seen.used == used && old.slot == new.slot {
                if new.cost < old.cost {
                    *old = new;
                }
                return;
            }
            k = (k + 1) % PLACES;
        }
    }

    /// The walks, the cheapest first.
    fn sorted(&mut self) -> &[Step] {
        self.steps
            .sort_unstable_by(|a, b| a.cost.total_cmp(&b.cost));
        &self.steps
    }
}

/// Fills `way` with the ends at which a walk leaves its edges, the last first.
fn trace(steps: &[Step], last: u32, way: &mut Vec<u32>) {
    way.clear();
    let mut at = last;
    while let Some(step) = steps.get(at as usize) {
        way.push(step.slot);
        at = step.before;
    }
}
