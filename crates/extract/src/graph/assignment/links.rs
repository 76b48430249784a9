//! The assignment of the whole graph: the best combination of the clusters' assignments.

use super::ends::Ends;
use super::features::{self, FEATURES};
use super::joins::Join;
use super::slot_at;
use super::solver::{Choice, Solver};
use crate::graph::Graph;
use crate::skeleton::NONE;

/// Clusters on rings, and combinations of their assignments: maximum number.
const MOST_ON_RING: usize = 8;
const MOST_TRIED: usize = 256;

/// One of the best assignments of a cluster: its cost, and the range of its decisions.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    cost: f32,
    from: u32,
    to: u32,
}

/// The decision at a slot.
#[derive(Clone, Copy, Debug)]
enum Decision {
    End(u32),
    NoLeg(u32),
    /// Index of a join in `joins`.
    Join(u32),
}

/// A cluster: the range of its candidates, cheapest first.
#[derive(Clone, Copy, Debug)]
struct Cluster {
    first: u32,
    count: u32,
}

/// A candidate for each cluster on a ring.
#[derive(Clone, Copy, Debug, Default)]
struct Combination {
    cost: f32,
    ranks: [u8; MOST_ON_RING],
    last: usize,
}

/// Buffers and result of the step.
#[derive(Debug, Default)]
pub(super) struct Links {
    /// For each slot of the graph, the slot at which its strand continues, or `NONE`.
    pub(super) next: Vec<u32>,
    /// For each slot, its join as an index into `joins`, or `NONE`.
    join_of: Vec<u32>,
    is_leg: Vec<bool>,
    joins: Vec<Join>,
    clusters: Vec<Cluster>,
    candidates: Vec<Candidate>,
    decisions: Vec<Decision>,
    /// For each root of a cluster, its index in `clusters`, or `NONE`.
    cluster_of: Vec<u32>,
    used: Vec<bool>,
    on_ring: Vec<u32>,
    on_others: Vec<u32>,
    open: Vec<Combination>,
}

impl Links {
    pub(super) fn reserve(&mut self, edges: usize) {
        for of_ends in [&mut self.next, &mut self.join_of, &mut self.cluster_of] {
            of_ends.reserve(2 * edges);
        }
        self.is_leg.reserve(edges);
        self.used.reserve(edges);
        self.joins.reserve(4 * edges);
        self.clusters.reserve(2 * edges);
        self.candidates.reserve(4 * edges);
        self.decisions.reserve(16 * edges);
        self.on_ring.reserve(edges);
        self.on_others.reserve(edges);
        self.open.reserve(MOST_TRIED * MOST_ON_RING);
    }

    pub(super) fn begin(&mut self, graph: &Graph) {
        let (edges, nodes) = (graph.edges.len(), graph.nodes.len());
        for (of_slots, count) in [
            (&mut self.next, 2 * edges),
            (&mut self.join_of, 2 * edges),
            (&mut self.cluster_of, nodes),
        ] {
            of_slots.clear();
            of_slots.resize(count, NONE);
        }
        self.is_leg.clear();
        self.is_leg.resize(edges, true);
        self.joins.clear();
        self.clusters.clear();
        self.candidates.clear();
        self.decisions.clear();
    }

    /// Keeps the assignments that the solver found for a cluster with these edges and joins.
    pub(super) fn keep(&mut self, solver: &Solver, (edges, joins): (&[u32], &[Join]), root: u32) {
        let first = self.candidates.len() as u32;
        let first_join = self.joins.len() as u32;
        self.joins.extend_from_slice(joins);
        for (k, cost) in solver.costs().enumerate() {
            let from = self.decisions.len() as u32;
            for (local, choice) in solver.choices(k) {
                let slot = slot_at(local, edges);
                self.decisions.push(match choice {
                    Choice::End => Decision::End(slot),
                    Choice::NoLeg => Decision::NoLeg(slot),
                    Choice::Join(j) => Decision::Join(first_join + j),
                });
            }
            let to = self.decisions.len() as u32;
            self.candidates.push(Candidate { cost, from, to });
        }
        self.cluster_of[root as usize] = self.clusters.len() as u32;
        self.clusters.push(Cluster {
            first,
            count: self.candidates.len() as u32 - first,
        });
    }

    /// Join at a slot.
    pub(super) fn join_at(&self, slot: usize) -> Option<&Join> {
        self.joins.get(self.join_of[slot] as usize)
    }

    /// Edges without a leg.
    pub(super) fn passed_edges(&self) -> impl Iterator<Item = usize> {
        (0..self.is_leg.len()).filter(|&e| !self.is_leg[e])
    }

    fn link(&mut self, join: u32) {
        let [a, b] = self.joins[join as usize].slots;
        for (slot, other) in [(a, b), (b, a)] {
            self.is_leg[slot as usize / 2] = true;
            self.next[slot as usize] = other;
            self.join_of[slot as usize] = join;
        }
    }

    fn unlink(&mut self, slot: u32) {
        self.next[slot as usize] = NONE;
        self.join_of[slot as usize] = NONE;
    }

    /// Takes a cluster's candidate with this rank.
    fn take(&mut self, cluster: u32, rank: u8) {
        let first = self.clusters[cluster as usize].first as usize;
        let Candidate { from, to, .. } = self.candidates[first + usize::from(rank)];
        for k in from..to {
            match self.decisions[k as usize] {
                Decision::NoLeg(slot) => self.is_leg[slot as usize / 2] = false,
                Decision::End(slot) => {
                    self.is_leg[slot as usize / 2] = true;
                    self.unlink(slot);
                }
                Decision::Join(join) => self.link(join),
            }
        }
    }

    /// Cost of a cluster's candidate with this rank, minus that of the best one.
    fn excess(&self, cluster: u32, rank: u8) -> f32 {
        let first = self.clusters[cluster as usize].first as usize;
        self.candidates[first + usize::from(rank)].cost - self.candidates[first].cost
    }

    /// Takes the best candidates of each connected piece, given the root of each node's cluster. A
    /// cluster cannot see a ring that runs through several of them.
    pub(super) fn choose(&mut self, graph: &Graph, ends: &Ends, roots: &[u32]) {
        for c in 0..self.clusters.len() as u32 {
            self.take(c, 0);
        }
        let mut on_ring = std::mem::take(&mut self.on_ring);
        if self.count_rings(None, graph, (ends, roots), &mut on_ring) > 0 {
            let is_piece = |&node: &u32| ends.pieces[node as usize] == node;
            for piece in (0..graph.nodes.len() as u32).filter(is_piece) {
                if self.count_rings(Some(piece), graph, (ends, roots), &mut on_ring) > 0 {
                    self.break_rings(piece, graph, (ends, roots), &mut on_ring);
                }
            }
        }
        self.on_ring = on_ring;
    }

    /// Tries combinations of the candidates of the clusters on rings in the order of their costs, until
    /// all others cost more than the best one with its rings.
    fn break_rings(
        &mut self,
        piece: u32,
        graph: &Graph,
        of: (&Ends, &[u32]),
        on_ring: &mut Vec<u32>,
    ) {
        on_ring.retain(|&c| self.clusters[c as usize].count > 1);
        on_ring.sort_unstable_by(|&a, &b| self.excess(a, 1).total_cmp(&self.excess(b, 1)));
        on_ring.truncate(MOST_ON_RING);
        let mut open = std::mem::take(&mut self.open);
        let mut on_others = std::mem::take(&mut self.on_others);
        open.clear();
        open.push(Combination::default());
        let mut best = (f32::INFINITY, [0; MOST_ON_RING]);
        for _ in 0..MOST_TRIED {
            let cost = |k: &usize| open[*k].cost;
            let Some(k) = (0..open.len()).min_by(|a, b| cost(a).total_cmp(&cost(b))) else {
                break;
            };
            let combination = open.swap_remove(k);
            if combination.cost >= best.0 {
                break;
            }
            for (&cluster, rank) in on_ring.iter().zip(combination.ranks) {
                self.take(cluster, rank);
            }
            let rings = self.count_rings(Some(piece), graph, of, &mut on_others);
            let cost = combination.cost + FEATURES[features::RING].1 * rings as f32;
            if cost < best.0 {
                best = (cost, combination.ranks);
            }
            // Each combination is reached in one way: by raising the last rank that is not 0, or a
            // later one.
            for (k, &cluster) in on_ring.iter().enumerate().skip(combination.last) {
                let mut next = combination;
                next.last = k;
                next.ranks[k] += 1;
                if u32::from(next.ranks[k]) < self.clusters[cluster as usize].count {
                    let [old, new] = [combination, next].map(|c| self.excess(cluster, c.ranks[k]));
                    next.cost += new - old;
                    open.push(next);
                }
            }
        }
        for (&cluster, rank) in on_ring.iter().zip(best.1) {
            self.take(cluster, rank);
        }
        (self.open, self.on_others) = (open, on_others);
    }

    /// Counts the rings, of one piece or of all, that run through several clusters, and lists those
    /// clusters.
    fn count_rings(
        &mut self,
        piece: Option<u32>,
        graph: &Graph,
        (ends, roots): (&Ends, &[u32]),
        on_ring: &mut Vec<u32>,
    ) -> usize {
        on_ring.clear();
        self.used.clear();
        self.used.extend(self.is_leg.iter().map(|is_leg| !is_leg));
        let root = |slot: usize| roots[graph.edges[slot / 2].nodes[slot % 2] as usize];
        let mut rings = 0;
        for edge in 0..graph.edges.len() {
            let node = graph.edges[edge].nodes[0];
            let is_other = |piece| ends.pieces[node as usize] != piece;
            if node == NONE || self.used[edge] || piece.is_some_and(is_other) {
                continue;
            }
            let start = 2 * edge;
            let (mut slot, mut is_outer) = (start, false);
            let is_ring = loop {
                self.used[slot / 2] = true;
                is_outer |= root(slot) != root(slot ^ 1);
                match self.next[slot ^ 1] {
                    NONE => break false,
                    next if next as usize == start => break true,
                    next => slot = next as usize,
                }
            };
            if !is_ring {
                let mut slot = start;
                while self.next[slot] != NONE {
                    slot = self.next[slot] as usize ^ 1;
                    self.used[slot / 2] = true;
                }
            } else if is_outer {
                rings += 1;
                slot = start;
                loop {
                    let cluster = self.cluster_of[root(slot ^ 1) as usize];
                    if cluster != NONE && !on_ring.contains(&cluster) {
                        on_ring.push(cluster);
                    }
                    slot = self.next[slot ^ 1] as usize;
                    if slot == start {
                        break;
                    }
                }
            }
        }
        rings
    }

    /// Makes a strand pass an edge that is its leg, if other strands pass it too: none of them is in
    /// its middle.
    pub(super) fn pass_shared(&mut self) {
        self.used.clear();
        self.used.resize(self.is_leg.len(), false);
        for &join in self.join_of.iter().filter(|&&join| join != NONE) {
            for &slot in self.joins[join as usize].passed() {
                self.used[slot as usize / 2] = true;
            }
        }
        for e in 0..self.is_leg.len() {
            if !self.used[e] || !self.is_leg[e] {
                continue;
            }
            let ends = [2 * e, 2 * e + 1];
            let [Some(to), Some(onward)] = ends.map(|slot| self.join_at(slot)) else {
                continue;
            };
            let slots = ends.map(|slot| self.next[slot]);
            let before = to.passed_from(slots[0]);
            let all = before
                .chain([ends[0] as u32])
                .chain(onward.passed_from(ends[1] as u32));
            let Some(whole) = Join::over(slots, all).filter(|_| slots[0] as usize / 2 != e) else {
                continue;
            };
            ends.iter().for_each(|&slot| self.unlink(slot as u32));
            self.joins.push(whole);
            self.link(self.joins.len() as u32 - 1);
            self.is_leg[e] = false;
        }
    }
}
