//! One assignment: which strand continues into which, for all crossings at once.
//!
//! An edge of the skeleton is one strand (a leg), several strands on top of each other or side by
//! side (then it is passed by them), or none. At each end of a leg, the strand ends or continues
//! into another leg, possibly over passed edges. The cost of an assignment A is
//!
//! ```text
//! E(A) = Σ joins w·f(a, b) + Σ ends w·f(a) + Σ edges w·f(e, strands on e) + w_ring · rings
//! ```
//!
//! `features` lists each f with its weight w. Eight weights are learned, which makes E a negative
//! log-probability up to a constant. The other nine are set by hand, which only approximates this.
//!
//! Edges too long to be passed divide the graph into clusters. `solver` finds the cheapest
//! assignments of each, and `links` the cheapest combination of all, with its rings.

mod alternatives;
mod ends;
pub(crate) mod features;
mod joins;
mod links;
mod mouth;
mod ropes;
pub(crate) mod solver;

pub use alternatives::Alternative;

use std::ops::Range;

use super::Graph;
use super::forest::{join, root};
use super::strands::{Leg, Strand};
use super::zones::Zones;
use crate::bitmap::bits::BitPlane;
use crate::image::Image;
use crate::skeleton::{NONE, Skeleton};
use ends::{Ends, Strands, node};
use features::{FEATURES, cost};
use joins::{Joins, Limits};
use links::Links;
use ropes::Ropes;
use solver::{EdgeCosts, MOST_EDGES, Problem, Solver};

/// Limits for passed edges. Clusters that are too large are divided with the next ones. With the last
/// ones, each node is a cluster.
const LIMITS: [Limits; 5] = [
    Limits {
        narrow: 6.0,
        wide: f32::INFINITY,
    },
    Limits {
        narrow: 2.0,
        wide: f32::INFINITY,
    },
    Limits {
        narrow: 1.0,
        wide: 16.0,
    },
    Limits {
        narrow: 0.5,
        wide: 2.0,
    },
    Limits {
        narrow: 0.0,
        wide: 0.0,
    },
];
/// Cost of an end where only two edges meet: without other edges, the strand continues.
const END_OF_PAIR: f32 = 50.0;
/// Number of edges for which buffers are reserved.
const RESERVED: usize = 1024;

/// Data for an assignment.
#[derive(Clone, Copy)]
pub(crate) struct Ground<'a> {
    pub(crate) image: &'a Image<'a>,
    pub(crate) graph: &'a Graph,
    pub(crate) skeleton: &'a Skeleton,
    pub(crate) mask: &'a BitPlane,
}

/// Buffers and result of the step.
#[derive(Debug, Default)]
pub(crate) struct Assigner {
    ends: Ends,
    /// For each node, the root of its cluster, the index of the cluster's limits, and whether it is too
    /// large. For each root, the number of its edges.
    parent: Vec<u32>,
    level: Vec<usize>,
    is_large: Vec<bool>,
    count: Vec<usize>,
    /// Nodes sorted by cluster.
    nodes: Vec<u32>,
    /// Index of each of the graph's edges in the cluster, or `NONE`.
    place: Vec<u32>,
    edges: Vec<u32>,
    joins: Joins,
    problem: Problem,
    solver: Solver,
    links: Links,
    ropes: Ropes,
    alternatives: Vec<Vec<Alternative>>,
    is_studied: bool,
}

impl Assigner {
    pub(crate) fn reserve(&mut self) {
        self.ends.reserve(RESERVED);
        let nodes = 2 * RESERVED;
        self.parent.reserve(nodes);
        self.level.reserve(nodes);
        self.is_large.reserve(nodes);
        self.count.reserve(nodes);
        self.nodes.reserve(nodes);
        self.place.reserve(RESERVED);
        self.edges.reserve(RESERVED);
        self.joins.reserve();
        self.problem.reserve();
        self.solver.reserve();
        self.links.reserve(RESERVED);
        self.ropes.reserve(RESERVED);
    }

    /// Edges along the ropes.
    pub(crate) fn legs(&self) -> &[Leg] {
        &self.ropes.legs
    }

    /// The ropes, the longest first.
    pub(crate) fn strands(&self) -> &[Strand] {
        &self.ropes.strands
    }

    /// Pixels of the edges that the ropes pass, to which the legs refer.
    pub(crate) fn shared(&self) -> &[u32] {
        &self.ropes.shared
    }

    /// Finds the ropes of the best assignment. Edges without a leg become the inside of zones.
    pub(crate) fn assign(&mut self, of: Ground, zones: &mut Zones) {
        self.ends.measure(of, zones);
        self.divide(of.graph);
        self.place.clear();
        self.place.resize(of.graph.edges.len(), NONE);
        self.links.begin(of.graph);
        let mut from = 0;
        while from < self.nodes.len() {
            let root = self.parent[self.nodes[from] as usize];
            let all = self.nodes[from..].iter();
            let count = all
                .take_while(|&&n| self.parent[n as usize] == root)
                .count();
            self.solve(from..from + count, of, zones);
            from += count;
        }
        self.is_studied = false;
        self.links.choose(of.graph, &self.ends, &self.parent);
        self.links.pass_shared();
        let trim = |slot: usize| match of.graph.edges[slot / 2].nodes[slot % 2] {
            NONE => 0,
            node if of.graph.nodes[node as usize].degree < 2 => 0,
            _ => self.ends.mouths[slot].arm.trim,
        };
        let half_px = |e: usize| zones.widest_half_px(e, of.graph);
        (self.ropes).follow_all(&self.links, (trim, half_px), of.graph);
        for e in self.links.passed_edges() {
            zones.join(e, of.graph);
        }
    }

    /// Divides the nodes into clusters of a size that the solver takes.
    fn divide(&mut self, graph: &Graph) {
        let nodes = graph.nodes.len();
        self.parent.clear();
        self.parent.resize(nodes, 0);
        self.level.clear();
        self.level.resize(nodes, 0);
        self.is_large.clear();
        self.is_large.resize(nodes, true);
        for (level, limits) in LIMITS.iter().enumerate() {
            for node in (0..nodes).filter(|&node| self.is_large[node]) {
                self.parent[node] = node as u32;
                self.level[node] = level;
            }
            for (e, edge) in graph.edges.iter().enumerate() {
                let is_large = |&node: &u32| node != NONE && self.is_large[node as usize];
                if edge.nodes.iter().all(is_large) && limits.allow(e, &self.ends, graph) {
                    join(&mut self.parent, edge.nodes);
                }
            }
            self.find_large(graph);
            if !self.is_large.contains(&true) {
                break;
            }
        }
        self.nodes.clear();
        self.nodes.extend(0..nodes as u32);
        let parent = &self.parent;
        (self.nodes).sort_unstable_by_key(|&node| (parent[node as usize], node));
    }

    /// Points each node to its cluster's root, and finds the nodes of clusters that are too large.
    fn find_large(&mut self, graph: &Graph) {
        let nodes = self.parent.len();
        for node in 0..nodes as u32 {
            self.parent[node as usize] = root(&mut self.parent, node);
        }
        self.count.clear();
        self.count.resize(nodes, 0);
        for edge in graph.edges.iter().filter(|edge| edge.nodes[0] != NONE) {
            let [a, b] = edge.nodes.map(|node| self.parent[node as usize] as usize);
            self.count[a] += 1;
            self.count[b] += usize::from(a != b);
        }
        for node in 0..nodes {
            self.is_large[node] = self.count[self.parent[node] as usize] > MOST_EDGES;
        }
    }

    /// Solves a cluster, given by a range of `nodes`.
    fn solve(&mut self, range: Range<usize>, of: Ground, zones: &Zones) {
        let nodes = &self.nodes[range];
        let degree = |&node: &u32| of.graph.nodes[node as usize].degree;
        if nodes.iter().map(degree).sum::<u32>() < 2 {
            return;
        }
        let first = nodes[0] as usize;
        list_edges(nodes, &self.ends, (&mut self.edges, &mut self.place));
        let limits = LIMITS[self.level[first]];
        (self.joins).list(nodes, limits, &self.ends, (of, zones));
        let cluster = Cluster {
            nodes,
            edges: &self.edges,
            place: &self.place,
            ends: &self.ends,
            joins: &self.joins,
            of,
            zones,
        };
        cluster.state(&mut self.problem);
        self.solver.solve(&self.problem);
        if self.is_studied {
            self.alternatives.push(cluster.alternatives(&self.solver));
        }
        let of = (&self.edges[..], &self.joins.found[..]);
        self.links.keep(&self.solver, of, self.parent[first]);
        self.edges
            .iter()
            .for_each(|&e| self.place[e as usize] = NONE);
    }

    /// Lists the alternatives of each cluster in the next trace.
    pub(crate) fn study(&mut self) {
        self.is_studied = true;
        self.alternatives.clear();
    }

    pub(crate) fn alternatives(&self) -> &[Vec<Alternative>] {
        &self.alternatives
    }
}

/// Lists the edges at some nodes, and the place of each in this list.
fn list_edges(nodes: &[u32], ends: &Ends, (edges, place): (&mut Vec<u32>, &mut Vec<u32>)) {
    edges.clear();
    for slot in nodes.iter().flat_map(|&node| ends.at(node)) {
        let place = &mut place[*slot as usize / 2];
        if *place == NONE {
            *place = edges.len() as u32;
            edges.push(slot / 2);
        }
    }
}

/// A cluster, as it is stated for the solver.
struct Cluster<'a> {
    nodes: &'a [u32],
    edges: &'a [u32],
    /// Index of each of the graph's edges in the cluster, or `NONE`.
    place: &'a [u32],
    ends: &'a Ends,
    joins: &'a Joins,
    of: Ground<'a>,
    zones: &'a Zones,
}

impl Cluster<'_> {
    /// Index of a slot in the cluster.
    fn local(&self, slot: u32) -> u8 {
        (2 * self.place[slot as usize / 2] + slot % 2) as u8
    }

    /// Slot of the graph at an index in the cluster.
    fn slot(&self, local: u8) -> u32 {
        slot_at(local, self.edges)
    }

    /// States the problem of this cluster.
    fn state(&self, problem: &mut Problem) {
        let graph = self.of.graph;
        problem.begin(self.edges.len(), FEATURES[features::RING].1);
        for &slot in self.nodes.iter().flat_map(|&node| self.ends.at(node)) {
            let end_cost = match graph.nodes[node(slot, graph) as usize].degree {
                2 => END_OF_PAIR,
                _ => cost(&self.ends.end_features(slot, graph, self.zones)),
            };
            problem.add_slot(self.local(slot), end_cost);
        }
        for &e in self.edges {
            let costs =
                Strands::ALL.map(|strands| cost(&self.ends.edge_features(e as usize, strands)));
            problem.edges.push(EdgeCosts(costs));
        }
        for join in &self.joins.found {
            let passed = join.passed().iter();
            problem.joins.push(solver::Join {
                slots: join.slots.map(|slot| self.local(slot)),
                cost: join.cost,
                passed: passed.fold(0, |all, &slot| all | 1 << self.place[slot as usize / 2]),
            });
        }
        // A sweep along the longer side of the cluster keeps few strands open at a time.
        let at = |&local: &u8| self.ends.mouths[self.slot(local) as usize].arm.at;
        let span = |c: usize| {
            let all = problem.order.iter().map(|local| at(local)[c]);
            all.clone().fold(f32::MIN, f32::max) - all.fold(f32::MAX, f32::min)
        };
        let c = usize::from(span(1) > span(0));
        (problem.order).sort_unstable_by(|a, b| at(a)[c].total_cmp(&at(b)[c]).then(a.cmp(b)));
    }
}

/// Slot of the graph at an index in a cluster with these edges.
fn slot_at(local: u8, edges: &[u32]) -> u32 {
    2 * edges[usize::from(local / 2)] + u32::from(local % 2)
}
