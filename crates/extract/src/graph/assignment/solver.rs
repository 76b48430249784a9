//! Finds the cheapest assignments of a cluster: which ends of edges continue into which.
//!
//! The solver knows no geometry. It takes the slots of a cluster in turn. At each one, the strand
//! ends or continues into another slot, or its edge is not a leg. The best partial
//! assignments are kept after each slot (a beam). Two that leave the same choices open and connect
//! the same ends differ only in cost, so the cheaper one continues.

#[cfg(test)]
mod tests;

/// Maximum number of edges in a cluster.
pub(crate) const MOST_EDGES: usize = 120;
/// Number of assignments that are found.
const KEPT: usize = 32;
/// Number of partial assignments that leave the same choices open, but connect other ends.
const SAME: usize = 8;
/// Number of partial assignments kept after each slot.
const BEAM: usize = 512;
/// Maximum number of partial assignments made at a slot.
const MOST_NEXT: usize = 16384;
/// Costs above the cheapest partial assignment at which others are given up.
const MARGIN: f32 = 12.0;
/// Size of the hash table of those.
const PLACES: usize = 2 * MOST_NEXT;
/// Maximum cost that is charged at once for an edge without a leg that may still be passed.
const ADVANCE: f32 = 3.0;
/// Far end of a strand that ends.
const ENDED: u8 = u8::MAX;

/// Costs of an edge by the number of strands that run over it: none, one, or more,
/// and if one strand only passes it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct EdgeCosts(pub(crate) [f32; 4]);

/// A possible continuation from one slot to another, over the `passed` edges.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Join {
    pub(crate) slots: [u8; 2],
    pub(crate) cost: f32,
    pub(crate) passed: u128,
}

/// A choice at a slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Choice {
    /// The strand ends here.
    End,
    /// Index of a join.
    Join(u32),
    /// The edge is not a leg. It may be passed.
    NoLeg,
}

/// The choices in a cluster. Slot 2·k + end belongs to edge k.
#[derive(Debug, Default)]
pub(crate) struct Problem {
    pub(crate) edges: Vec<EdgeCosts>,
    /// Cost of an end at each slot; infinite where no strand can end.
    pub(crate) end_costs: Vec<f32>,
    /// True for the slots that belong to this cluster. Edges with another one leave the cluster, and
    /// are always legs.
    pub(crate) is_inside: Vec<bool>,
    pub(crate) joins: Vec<Join>,
    /// Slots in the order in which they are decided.
    pub(crate) order: Vec<u8>,
    /// Cost of a closed strand.
    pub(crate) ring_cost: f32,
}

impl Problem {
    pub(crate) fn reserve(&mut self) {
        self.edges.reserve(MOST_EDGES);
        self.end_costs.reserve(2 * MOST_EDGES);
        self.is_inside.reserve(2 * MOST_EDGES);
        self.joins.reserve(4096);
        self.order.reserve(2 * MOST_EDGES);
    }

    /// Starts a problem with this number of edges, and this cost of a closed strand.
    pub(crate) fn begin(&mut self, edges: usize, ring_cost: f32) {
        self.edges.clear();
        self.joins.clear();
        self.order.clear();
        self.end_costs.clear();
        self.end_costs.resize(2 * edges, f32::INFINITY);
        self.is_inside.clear();
        self.is_inside.resize(2 * edges, false);
        self.ring_cost = ring_cost;
    }

    /// Adds a slot of this cluster.
    pub(crate) fn add_slot(&mut self, slot: u8, end_cost: f32) {
        self.is_inside[usize::from(slot)] = true;
        self.end_costs[usize::from(slot)] = end_cost;
        self.order.push(slot);
    }
}

/// A partial assignment without the courses of its strands.
#[derive(Clone, Copy, Debug)]
struct State {
    cost: f32,
    /// The partial assignment that it continues, as an index into `Solver::states`, and how.
    before: u32,
    choice: Choice,
    /// Slots that are decided.
    decided: [u128; 2],
    /// Edges without a leg, and those passed once and more often. Edges that can no longer change
    /// are left out.
    no_leg: u128,
    once: u128,
    again: u128,
    /// Hash of the pairs of ends that strands lead to.
    pairs: u64,
}

/// Far end of the strand at each open slot.
type FarEnds = [u8; 2 * MOST_EDGES];

#[derive(Clone, Copy, Debug)]
struct Record {
    before: u32,
    slot: u8,
    choice: Choice,
}

const NONE: u32 = u32::MAX;

/// Buffers and results of the search.
#[derive(Debug, Default)]
pub(crate) struct Solver {
    /// Partial assignments, with the far ends of their strands and their last choices as indices into
    /// `records`.
    states: Vec<State>,
    far: Vec<FarEnds>,
    last: Vec<u32>,
    /// Those of the next turn, and their order.
    next: Vec<State>,
    next_far: Vec<FarEnds>,
    next_last: Vec<u32>,
    sorted: Vec<u32>,
    /// Least cost in `next`.
    cheapest: f32,
    /// Hash table of `next`: the number of the turn, counted from the last clearing, and the index.
    places: Vec<u32>,
    age: u32,
    records: Vec<Record>,
    /// For each slot, its joins: `joins_of[from[slot]..from[slot + 1]]`.
    joins_of: Vec<u32>,
    from: Vec<u32>,
    /// For each edge, the turn after which its number of strands is final.
    last_turn: Vec<u32>,
    turn_of: Vec<u32>,
    /// For each edge, what a choice against a leg costs at once: all that it leaves unexplained, or
    /// less if the edge may still be passed. Otherwise such choices would crowd out others.
    advances: Vec<f32>,
    /// For each slot, the least that any choice costs there. A join's cost is divided among its slots.
    /// The sum over the open slots is part of a partial assignment's cost, so that those compare
    /// which have decided different slots.
    least: Vec<f32>,
    order: Vec<u32>,
    /// Last records and costs of the best assignments, cheapest first.
    found: Vec<(u32, f32)>,
}

impl Solver {
    pub(crate) fn reserve(&mut self) {
        self.states.reserve(BEAM);
        self.next.reserve(MOST_NEXT);
        for far in [&mut self.far, &mut self.next_far] {
            far.reserve(BEAM);
        }
        self.sorted.reserve(MOST_NEXT);
        self.places.reserve(PLACES);
        self.records.reserve(2 * MOST_EDGES * BEAM);
        self.joins_of.reserve(8192);
        for of_slots in [&mut self.from, &mut self.last_turn, &mut self.turn_of] {
            of_slots.reserve(2 * MOST_EDGES + 1);
        }
        self.advances.reserve(MOST_EDGES);
        self.least.reserve(2 * MOST_EDGES);
        self.order.reserve(MOST_EDGES);
        self.found.reserve(KEPT);
    }

    /// Finds the cheapest assignments.
    pub(crate) fn solve(&mut self, problem: &Problem) {
        self.index(problem);
        self.records.clear();
        self.found.clear();
        self.begin(problem);
        for turn in 0..problem.order.len() {
            self.age += 1;
            if self.age > u32::from(u16::MAX) || self.places.is_empty() {
                self.age = 1;
                self.places.clear();
                self.places.resize(PLACES, 0);
            }
            self.next.clear();
            self.cheapest = f32::INFINITY;
            for k in 0..self.states.len() {
                self.choose(problem, turn, k);
            }
            self.go_on(problem, turn);
        }
        let finals = self.last.iter().zip(&self.states);
        let finals = finals.map(|(&last, state)| (last, state.cost));
        self.found.extend(finals.take(KEPT));
    }

    fn begin(&mut self, problem: &Problem) {
        let mut state = State {
            cost: 0.0,
            before: NONE,
            choice: Choice::End,
            decided: [0; 2],
            no_leg: 0,
            once: 0,
            again: 0,
            pairs: 0,
        };
        let mut far = [ENDED; 2 * MOST_EDGES];
        for (slot, &is_inside) in problem.is_inside.iter().enumerate() {
            far[slot] = slot as u8 ^ 1;
            if is_inside {
                state.cost += self.least[slot];
            } else {
                state.decided[slot >> 7] |= 1 << (slot & 127);
            }
        }
        self.states.clear();
        self.far.clear();
        self.last.clear();
        self.states.push(state);
        self.far.push(far);
        self.last.push(NONE);
    }

    /// Makes the cheapest of `next` the new partial assignments.
    fn go_on(&mut self, problem: &Problem, turn: usize) {
        let slot = problem.order[turn];
        let most = self.cheapest + MARGIN;
        self.sorted.clear();
        let next = &self.next;
        (self.sorted).extend((0..next.len() as u32).filter(|&k| next[k as usize].cost <= most));
        let cost = |&k: &u32| next[k as usize].cost;
        (self.sorted).sort_unstable_by(|a, b| cost(a).total_cmp(&cost(b)).then(a.cmp(b)));
        self.sorted.truncate(BEAM);
        self.next_far.clear();
        self.next_last.clear();
        for &k in &self.sorted {
            let State { before, choice, .. } = self.next[k as usize];
            let mut far = self.far[before as usize];
            let mut last = self.last[before as usize];
            let is_new = !has(&self.states[before as usize].decided, slot);
            if is_new {
                let ends = match choice {
                    Choice::Join(j) => problem.joins[j as usize]
                        .slots
                        .map(|slot| far[usize::from(slot)]),
                    Choice::End => [far[usize::from(slot)], ENDED],
                    Choice::NoLeg => [ENDED; 2],
                };
                for (end, other) in [(ends[0], ends[1]), (ends[1], ends[0])] {
                    if end != ENDED {
                        far[usize::from(end)] = other;
                    }
                }
                self.records.push(Record {
                    before: last,
                    slot,
                    choice,
                });
                last = self.records.len() as u32 - 1;
            }
            self.next_far.push(far);
            self.next_last.push(last);
        }
        self.states.clear();
        self.states
            .extend(self.sorted.iter().map(|&k| self.next[k as usize]));
        std::mem::swap(&mut self.far, &mut self.next_far);
        std::mem::swap(&mut self.last, &mut self.next_last);
    }

    /// Costs of the found assignments, cheapest first.
    pub(crate) fn costs(&self) -> impl Iterator<Item = f32> {
        self.found.iter().map(|&(_, cost)| cost)
    }

    /// Choices of the found assignment `k`, at each slot that was decided by one.
    pub(crate) fn choices(&self, k: usize) -> impl Iterator<Item = (u8, Choice)> {
        let mut at = self.found[k].0;
        std::iter::from_fn(move || {
            let record = self.records.get(at as usize)?;
            at = record.before;
            Some((record.slot, record.choice))
        })
    }

    /// Lists the joins of each slot, and the last turn that changes each edge.
    fn index(&mut self, problem: &Problem) {
        let slots = 2 * problem.edges.len();
        self.turn_of.clear();
        self.turn_of.resize(slots, 0);
        for (turn, &slot) in problem.order.iter().enumerate() {
            self.turn_of[usize::from(slot)] = turn as u32;
        }
        self.from.clear();
        self.from.resize(slots + 1, 0);
        self.last_turn.clear();
        self.last_turn.resize(problem.edges.len(), 0);
        for (slot, &turn) in self.turn_of.iter().enumerate() {
            let last = &mut self.last_turn[slot / 2];
            *last = (*last).max(turn);
        }
        self.advances.clear();
        self.advances
            .extend(problem.edges.iter().map(|edge| edge.0[0]));
        for join in &problem.joins {
            join.slots
                .iter()
                .for_each(|&slot| self.from[usize::from(slot)] += 1);
            let turns = join.slots.map(|slot| self.turn_of[usize::from(slot)]);
            let mut passed = join.passed;
            while passed != 0 {
                let edge = passed.trailing_zeros() as usize;
                let last = &mut self.last_turn[edge];
                *last = (*last).max(turns[0].min(turns[1]));
                let advance = &mut self.advances[edge];
                *advance = advance.min(ADVANCE);
                passed &= passed - 1;
            }
        }
        let mut sum = 0;
        for from in &mut self.from {
            sum += *from;
            *from = sum;
        }
        self.joins_of.clear();
        self.joins_of.resize(sum as usize, 0);
        for (j, join) in problem.joins.iter().enumerate().rev() {
            for slot in join.slots {
                let from = &mut self.from[usize::from(slot)];
                *from -= 1;
                self.joins_of[*from as usize] = j as u32;
            }
        }
        self.least.clear();
        self.least.extend((0..slots).map(|slot| {
            let is_both = problem.is_inside[slot] && problem.is_inside[slot ^ 1];
            let none = if is_both {
                0.5 * self.advances[slot / 2]
            } else {
                f32::INFINITY
            };
            let range = self.from[slot] as usize..self.from[slot + 1] as usize;
            let joins = self.joins_of[range]
                .iter()
                .map(|&j| 0.5 * problem.joins[j as usize].cost);
            joins.fold(none.min(problem.end_costs[slot]), f32::min)
        }));
        self.tighten(problem);
        // Edges in the order of their last turns.
        self.order.clear();
        self.order.extend(0..problem.edges.len() as u32);
        let last_turn = &self.last_turn;
        self.order
            .sort_unstable_by_key(|&edge| (last_turn[edge as usize], edge));
    }

    /// Raises the least costs: a join or an edge without a leg costs two slots at once, so one of them
    /// may account for all that the other does not.
    fn tighten(&mut self, problem: &Problem) {
        for slot in 0..self.least.len() {
            if !problem.is_inside[slot] {
                continue;
            }
            let range = self.from[slot] as usize..self.from[slot + 1] as usize;
            let joins = self.joins_of[range].iter().map(|&j| {
                let Join { slots, cost, .. } = problem.joins[j as usize];
                let [a, b] = slots.map(usize::from);
                cost - self.least[a + b - slot]
            });
            let none = match problem.is_inside[slot ^ 1] {
                true => self.advances[slot / 2] - self.least[slot ^ 1],
                false => f32::INFINITY,
            };
            let least = joins.fold(none.min(problem.end_costs[slot]), f32::min);
            self.least[slot] = self.least[slot].max(least);
        }
    }

    /// Makes all choices at the slot of this turn for one partial assignment.
    fn choose(&mut self, problem: &Problem, turn: usize, before: usize) {
        let slot = problem.order[turn];
        let other = slot ^ 1;
        let old = State {
            before: before as u32,
            choice: Choice::End,
            ..self.states[before]
        };
        if has(&old.decided, slot) {
            self.enter(problem, turn, old);
            return;
        }
        let leaves = !problem.is_inside[usize::from(other)];
        if !leaves && !has(&old.decided, other) {
            let edge = usize::from(slot / 2);
            let mut new = old;
            new.choice = Choice::NoLeg;
            self.decide(&mut new, [slot, other], self.advances[edge]);
            new.no_leg |= 1 << edge;
            new.pairs ^= pair(slot, other);
            self.enter(problem, turn, new);
        }
        let end_cost = problem.end_costs[usize::from(slot)];
        if end_cost < f32::INFINITY {
            let mut new = old;
            self.decide(&mut new, [slot, slot], end_cost);
            let far = self.far[before][usize::from(slot)];
            new.pairs ^= pair(slot, far) ^ pair(far, ENDED);
            self.enter(problem, turn, new);
        }
        let range = self.from[usize::from(slot)]..self.from[usize::from(slot) + 1];
        for k in range {
            let j = self.joins_of[k as usize];
            let join = &problem.joins[j as usize];
            let [a, b] = join.slots;
            let to = if a == slot { b } else { a };
            if has(&old.decided, to) || to == slot {
                continue;
            }
            let mut new = old;
            new.choice = Choice::Join(j);
            let is_ring = self.far[before][usize::from(slot)] == to;
            let ring_cost = if is_ring { problem.ring_cost } else { 0.0 };
            self.decide(&mut new, [slot, to], join.cost + ring_cost);
            new.again |= new.once & join.passed;
            new.once |= join.passed;
            let far = [slot, to].map(|slot| self.far[before][usize::from(slot)]);
            if !is_ring {
                new.pairs ^= pair(slot, far[0]) ^ pair(to, far[1]) ^ pair(far[0], far[1]);
            } else {
                new.pairs ^= pair(slot, to);
            }
            self.enter(problem, turn, new);
        }
    }

    /// Marks slots as decided, at this cost.
    fn decide(&self, state: &mut State, slots: [u8; 2], cost: f32) {
        state.cost += cost - self.least[usize::from(slots[0])];
        if slots[1] != slots[0] {
            state.cost -= self.least[usize::from(slots[1])];
        }
        for slot in slots {
            state.decided[usize::from(slot >> 7)] |= 1 << (slot & 127);
        }
    }

    /// Adds the costs of the edges that can no longer change.
    fn finish(&self, problem: &Problem, turn: usize, state: &mut State) {
        let first = self
            .order
            .partition_point(|&edge| self.last_turn[edge as usize] < turn as u32);
        for &edge in &self.order[first..] {
            if self.last_turn[edge as usize] != turn as u32 {
                break;
            }
            let count = |edges: u128| (edges >> edge & 1) as usize;
            let strands = 1 - count(state.no_leg) + count(state.once) + count(state.again);
            let is_only_passed = strands == 1 && count(state.no_leg) == 1;
            let kind = if is_only_passed { 3 } else { strands.min(2) };
            state.cost += problem.edges[edge as usize].0[kind];
            if count(state.no_leg) == 1 {
                state.cost -= self.advances[edge as usize];
            }
            let others = !(1u128 << edge);
            state.no_leg &= others;
            state.once &= others;
            state.again &= others;
        }
    }

    /// Adds a partial assignment, unless enough cheaper ones leave the same choices open.
    fn enter(&mut self, problem: &Problem, turn: usize, mut new: State) {
        self.finish(problem, turn, &mut new);
        if new.cost > self.cheapest + MARGIN {
            return;
        }
        self.cheapest = self.cheapest.min(new.cost);
        let mix = |sum: u64, word: u128| {
            let folded = word as u64 ^ (word >> 64) as u64;
            (sum ^ folded)
                .wrapping_mul(0x9e37_79b9_7f4a_7c15)
                .rotate_left(29)
        };
        let words = [
            new.decided[0],
            new.decided[1],
            new.no_leg,
            new.once,
            new.again,
        ];
        let key = words
            .into_iter()
            .fold(1, mix)
            .wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let mut k = (key >> 40) as usize % PLACES;
        let number = self.age << 16;
        let (mut same, mut dearest) = (0, (NONE, new.cost));
        loop {
            let place = self.places[k];
            if place & 0xffff_0000 != number {
                break;
            }
            let at = place & 0xffff;
            let old = &self.next[at as usize];
            if is_same(old, &new) {
                if old.pairs == new.pairs {
                    if old.cost > new.cost {
                        self.next[at as usize] = new;
                    }
                    return;
                }
                same += 1;
                if old.cost > dearest.1 {
                    dearest = (at, old.cost);
                }
            }
            k = (k + 1) % PLACES;
        }
        let kept = if turn + 1 == problem.order.len() {
            KEPT
        } else {
            SAME
        };
        if same >= kept {
            if let Some(old) = self.next.get_mut(dearest.0 as usize) {
                *old = new;
            }
        } else if self.next.len() < MOST_NEXT {
            self.places[k] = number | self.next.len() as u32;
            self.next.push(new);
        }
    }
}

fn is_same(a: &State, b: &State) -> bool {
    a.decided == b.decided && a.no_leg == b.no_leg && a.once == b.once && a.again == b.again
}

/// Hash of two slots, in any order.
fn pair(a: u8, b: u8) -> u64 {
    let both = u64::from(a.min(b)) << 8 | u64::from(a.max(b));
    let mixed = (both + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    (mixed ^ mixed >> 29).wrapping_mul(0xbf58_476d_1ce4_e5b9)
}

fn has(decided: &[u128; 2], slot: u8) -> bool {
    decided[usize::from(slot >> 7)] >> (slot & 127) & 1 == 1
}
