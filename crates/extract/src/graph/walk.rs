//! One rope, or a few, through all of a piece of the mask.
//!
//! Judging crossings one by one goes wrong where several merge: a ring is cut off that is not there, strands are exchanged, a part of
//! the mask belongs to no rope. A piece of the mask with two tips is mostly one rope. That rope is a walk over the skeleton from one tip
//! to the other. The walk takes each edge that is one strand once, and edges where strands lie on each other as often as it likes. A
//! piece with more tips is several ropes, found one after the other: each begins at the first tip that is left, and ends at another tip
//! or on a strand.
//!
//! The cheapest walk wins, by a beam search. A walk costs what it bends beyond the bends of its strands, what it runs outside of the mask,
//! and what it leaves out of the mask. Several ropes also pay for overlaps where only one strand is seen. The walk replaces what the
//! crossings say if that costs more as a walk, and is several ropes or one that is wound up.

mod piece;

use super::Graph;
use super::strands::{Leg, Strand};
use super::zones::Zones;
use crate::bitmap::bits::BitPlane;
use crate::skeleton::{NONE, Skeleton};
use piece::{Component, Ground, Visited, is_tip};

/// Walks that are kept at a time, walks one step on from them and places of their hash, and steps of all walks.
const BEAM: usize = 128;
const MOST_NEXT: usize = 4096;
const PLACES: usize = 2 * MOST_NEXT;
const MOST_STEPS: usize = 16384;
/// What an end that is no tip costs, and a ring.
const END: f32 = 0.6;
const RING: f32 = 0.6;
/// The most that the joint of two legs costs that do not hang together.
const TORN: f32 = 2.0;
/// How much less a walk must cost than what was there, and one that is several ropes.
const BETTER: f32 = 0.15;
const BETTER_AS_SEVERAL: f32 = 0.3;
/// A walk so far, by its last step.
#[derive(Clone, Copy, Debug)]
struct Step {
    before: u32,
    /// The end of an edge at which the walk comes out of it. A rope begins with an edge whose other end is a tip.
    slot: u32,
    cost: f32,
    seen: Visited,
}

/// Memory and result of the search.
#[derive(Debug, Default)]
pub(crate) struct Walker {
    piece: Component,
    steps: Vec<Step>,
    next: Layer,
    /// The last steps of walks that have arrived, and what they cost in all, the cheapest first.
    done: Vec<(u32, f32)>,
    way: Vec<u32>,
}

impl Walker {
    /// Makes room for the walks of a tangled rope.
    pub(crate) fn reserve(&mut self) {
        self.piece.reserve();
        self.steps.reserve(MOST_STEPS + MOST_NEXT);
        self.next.reserve();
        self.done.reserve(MOST_STEPS + MOST_NEXT);
        self.way.reserve(128);
    }

    /// Puts the best walk in the place of strands that cost more.
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
            // What is one rope crossing by crossing is right more often than the cheapest walk, unless it is wound up.
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

    /// What the strands of the piece cost as they are, how many they are, and whether they have legs that no walk joins.
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

    /// Finds the cheapest walks from tip to tip. What is several ropes is still one walk: where a rope has ended, the next one begins.
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

    /// Enters the walks one step on from step `s`, as far as they cost less than `least`. Returns what the cheapest walk costs now: it may
    /// have ended there.
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
        // Where the tips tell of several ropes, one may end on another.
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

    /// Puts the best walk in the place of the strands of its piece.
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

/// The end of its edge at which a leg begins, and at which it ends.
fn into(leg: &Leg) -> u32 {
    2 * leg.edge + u32::from(leg.reversed)
}

fn out(leg: &Leg) -> u32 {
    into(leg) ^ 1
}

/// A walk on from `step`, where a rope has ended, to the next one: the first edge with a tip that is left, if there is any.
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

/// Walks one step on, each once.
#[derive(Debug, Default)]
struct Layer {
    steps: Vec<Step>,
    /// Where in `steps` a walk is, by a hash of its edges and its end: the lower half; the upper is the layer's number, so that
    /// what former layers left here need not be cleared.
    places: Vec<u32>,
    number: u32,
}

impl Layer {
    fn reserve(&mut self) {
        self.steps.reserve(MOST_NEXT);
        self.places.reserve(PLACES);
    }

    /// Forgets all layers.
    fn restart(&mut self) {
        self.places.clear();
        self.places.resize(PLACES, 0);
        self.number = 0;
    }

    fn clear(&mut self) {
        self.steps.clear();
        self.number += 1;
    }

    /// Enters a walk, unless one is there that has come to the same place over the same edges and is cheaper.
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

/// Fills `way` with the ends at which a walk comes out of its edges, the last first.
fn trace(steps: &[Step], last: u32, way: &mut Vec<u32>) {
    way.clear();
    let mut at = last;
    while let Some(step) = steps.get(at as usize) {
        way.push(step.slot);
        at = step.before;
    }
}
