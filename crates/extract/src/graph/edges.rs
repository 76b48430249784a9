//! The skeleton as a graph: nodes (ends and junctions) joined by edges, without the spurs that a
//! ragged mask leaves.

use crate::past::Past;
use crate::skeleton::{NONE, Pixel, Skeleton};
use crate::vec2;
use std::f32::consts::{PI, SQRT_2};

/// Maximum number of edges. A skeleton with more is treated as noise and gets no graph.
const MOST_EDGES: usize = 4096;
/// Maximum length of a spur, in half-widths at its junction, plus 1 px. A spur is a bump of the
/// rope's edge, or a corner of its tip, which is √2 half-widths away.
const SPUR_HALVES: f32 = 1.5;
/// Same threshold for the shorter of two free ends at one junction. Such ends are the corners of a
/// frayed or hollow tip.
const FORK_HALVES: f32 = 3.0;
/// Minimum length of a stub, in half-widths. A stub is a short edge that may be the tip of a strand
/// over or under another (see `is_stub`). The second number, also in half-widths, is the maximum
/// length of edges that join junctions into one meeting. Strands that arrive at a meeting are at
/// least that long.
const STUB_HALVES: [f32; 2] = [0.5, 5.0];
/// Maximum turn from an arriving strand into the stub, in radians.
const STUB_TURN: f32 = 0.45;
/// Minimum angle, from 0 and from π, between the stub and a strand that runs across it, in radians.
const STUB_ACROSS: f32 = 0.7;
/// Minimum half-width of the stub at its end and in its middle, relative to the arriving strand. A
/// tip is blunt.
const STUB_BLUNT: [f32; 2] = [0.2, 0.6];
/// Maximum number of junctions in one meeting.
const STUB_NODES: usize = 8;
/// Maximum number of edges of a skeleton in which stubs are sought.
const STUB_EDGES: usize = 256;
/// Radius around a rope's known end in which no other free end may be, in widths.
const ALONE_WIDTHS: f32 = 3.0;

/// A skeleton pixel where an edge ends or several meet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Node {
    pub(crate) pixel: u32,
    /// Number of edge ends here.
    pub(crate) degree: u32,
}

/// A chain of skeleton pixels from one node to another.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edge {
    /// The nodes at its two ends; `NONE` twice for a ring without nodes.
    pub(crate) nodes: [u32; 2],
    /// Start of its pixels in `Graph::chain`. They include those of its nodes.
    pub(crate) from: u32,
    pub(crate) to: u32,
    pub(crate) length_px: f32,
}

/// The graph, and the buffers for tracing it.
#[derive(Debug, Default)]
pub(crate) struct Graph {
    pub(crate) nodes: Vec<Node>,
    pub(crate) edges: Vec<Edge>,
    /// Pixels of all edges, edge by edge.
    chain: Vec<u32>,
    /// Node of each pixel, or `NONE`.
    node_of: Vec<u32>,
    visited: Vec<bool>,
    spurs: Vec<u32>,
}

impl Graph {
    /// Reserves memory for the spurs of a rough skeleton.
    pub(crate) fn reserve(&mut self) {
        self.spurs.reserve(256);
    }

    /// Traces `skeleton`. A skeleton with more than `MOST_EDGES` edges gets no graph.
    pub(crate) fn trace(&mut self, skeleton: &Skeleton) {
        let pixels = &skeleton.pixels;
        self.nodes.clear();
        self.edges.clear();
        self.chain.clear();
        self.node_of.clear();
        self.node_of.resize(pixels.len(), NONE);
        self.visited.clear();
        self.visited.resize(pixels.len(), false);
        for (i, pixel) in pixels.iter().enumerate() {
            if pixel.degree != 2 && pixel.degree != 0 {
                self.node_of[i] = self.nodes.len() as u32;
                self.nodes.push(Node {
                    pixel: i as u32,
                    degree: 0,
                });
            }
        }
        for n in 0..self.nodes.len() {
            let start = self.nodes[n].pixel;
            let pixel = &pixels[start as usize];
            for &next in &pixel.neighbors[..usize::from(pixel.degree)] {
                let other = self.node_of[next as usize];
                if !self.visited[next as usize] && (other == NONE || other > n as u32) {
                    self.follow(skeleton, start, next);
                }
            }
        }
        for (i, pixel) in pixels.iter().enumerate() {
            if pixel.degree == 2 && !self.visited[i] {
                self.follow(skeleton, i as u32, pixel.neighbors[0]);
            }
        }
        if self.edges.len() > MOST_EDGES {
            self.nodes.clear();
            self.edges.clear();
        }
    }

    /// Traces the edge that leaves `start` through its neighbor `next`, to the next node or, on a
    /// ring, back to `start`.
    fn follow(&mut self, skeleton: &Skeleton, start: u32, next: u32) {
        let pixels = &skeleton.pixels;
        let from = self.chain.len() as u32;
        self.chain.push(start);
        let (mut before, mut here, mut length_px) = (start, next, 0.0);
        loop {
            self.chain.push(here);
            let (a, b) = (&pixels[before as usize], &pixels[here as usize]);
            // A diagonal step is √2 px long.
            length_px += if (a.x != b.x) & (a.y != b.y) {
                SQRT_2
            } else {
                1.0
            };
            if self.node_of[here as usize] != NONE || here == start {
                break;
            }
            self.visited[here as usize] = true;
            let [a, b, ..] = pixels[here as usize].neighbors;
            (before, here) = (here, if a == before { b } else { a });
        }
        self.visited[start as usize] |= here == start;
        let nodes = [self.node_of[start as usize], self.node_of[here as usize]];
        for node in nodes {
            if node != NONE {
                self.nodes[node as usize].degree += 1;
            }
        }
        self.edges.push(Edge {
            nodes,
            from,
            to: self.chain.len() as u32,
            length_px,
        });
    }

    /// Removes spurs from `skeleton`, the shortest first, and traces it again, until none are left.
    ///
    /// Two kinds of short free ends stay. One is the known end of a rope of the prior, which may be
    /// over another strand. The other, in a skeleton of a mask only, is the tip of a strand that
    /// arrives from the opposite side (`is_stub`).
    pub(crate) fn prune(&mut self, skeleton: &mut Skeleton, past: &Past, is_of_mask: bool) {
        loop {
            self.spurs.clear();
            for e in 0..self.edges.len() {
                if self.is_spur(e, skeleton, past, is_of_mask) {
                    self.spurs.push(e as u32);
                }
            }
            if self.spurs.is_empty() {
                return;
            }
            let edges = &self.edges;
            self.spurs.sort_unstable_by(|&a, &b| {
                edges[a as usize]
                    .length_px
                    .total_cmp(&edges[b as usize].length_px)
            });
            for i in 0..self.spurs.len() {
                let e = self.spurs[i] as usize;
                // An earlier removal may have made this edge the continuation of a strand.
                if self.is_spur(e, skeleton, past, is_of_mask) {
                    self.remove(e, skeleton);
                }
            }
            self.trace(skeleton);
        }
    }

    /// Removes the pixels of spur `e` from the skeleton, except for its junction.
    fn remove(&mut self, e: usize, skeleton: &mut Skeleton) {
        for node in self.edges[e].nodes {
            self.nodes[node as usize].degree -= 1;
        }
        let Edge {
            from, to, nodes, ..
        } = self.edges[e];
        let tip_first = self.nodes[nodes[0] as usize].degree == 0;
        let (from, to) = if tip_first {
            (from, to - 1)
        } else {
            (from + 1, to)
        };
        for &pixel in &self.chain[from as usize..to as usize] {
            skeleton.remove(pixel);
        }
    }

    /// Returns whether edge `e` has one free end, is short, and is neither a known end nor a stub.
    fn is_spur(&self, e: usize, skeleton: &Skeleton, past: &Past, is_of_mask: bool) -> bool {
        let edge = &self.edges[e];
        let [a, b] = edge.nodes;
        if a == NONE || a == b {
            return false;
        }
        let (a, b) = (self.nodes[a as usize], self.nodes[b as usize]);
        let (tip, junction) = match (a.degree, b.degree) {
            (1, 3..) => (a, b),
            (3.., 1) => (b, a),
            _ => return false,
        };
        let half = skeleton.pixels[junction.pixel as usize].half_px;
        let is_short = edge.length_px < SPUR_HALVES * half + 1.0
            || edge.length_px < FORK_HALVES * half && self.is_fork(e, junction.pixel);
        let is_tip = || is_of_mask && self.is_stub(e, half, skeleton);
        is_short && !self.is_known_end(&tip, skeleton, past) && !is_tip()
    }

    /// Returns whether short edge `e`, at a junction of this half-width, is the tip of a strand
    /// that passes over or under another.
    ///
    /// At least two of the strands that arrive at the meeting must run across it. One must point
    /// along it, and must not continue into another strand with less turn. The tip must be blunt.
    /// In a rope that is hollow in the mask, all strands run along the stub, so this rejects them.
    fn is_stub(&self, e: usize, half_px: f32, skeleton: &Skeleton) -> bool {
        let [least_px, near_px] = STUB_HALVES.map(|halves| halves * half_px);
        let foot = 2 * e + usize::from(self.degree(2 * e) == 1);
        let junction = &self.nodes[self.node(foot) as usize];
        let are_many = self.edges.len() > STUB_EDGES;
        if are_many || self.edges[e].length_px < least_px || self.is_fork(e, junction.pixel) {
            return false;
        }
        let [foot_at, middle, tip] = [0.0, self.pixels(e).len() as f32 / 2.0, f32::INFINITY]
            .map(|from_px| self.at(foot, from_px, skeleton));
        let way = vec2::sub(tip.at(), foot_at.at());
        let meeting = self.meeting(self.node(foot), near_px);
        // For each strand that arrives: the turn from it into the stub, and its half-width.
        let strands = || {
            let is_long = |&slot: &usize| self.edges[slot / 2].length_px >= near_px;
            let is_there = |&slot: &usize| meeting.contains(&self.node(slot));
            self.slots().filter(is_long).filter(is_there).map(|slot| {
                let from = self.at(slot, 4.0 * half_px, skeleton);
                let into = vec2::sub(self.at(slot, half_px, skeleton).at(), from.at());
                (vec2::angle(into, way), from.half_px)
            })
        };
        let across = STUB_ACROSS..PI - STUB_ACROSS;
        let is_across = |&(turn, _): &(f32, f32)| across.contains(&turn.abs());
        strands().filter(is_across).count() >= 2
            && strands().any(|(turn, strand_px)| {
                let goes_on =
                    |(other, _): (f32, f32)| (PI - (turn - other).abs()).abs() < turn.abs();
                turn.abs() < STUB_TURN
                    && tip.half_px > STUB_BLUNT[0] * strand_px
                    && middle.half_px > STUB_BLUNT[1] * strand_px
                    && !strands().any(goes_on)
            })
    }

    /// Returns the junctions joined to `node` by edges shorter than `near_px`, including `node`.
    /// Unused entries repeat `node`.
    fn meeting(&self, node: u32, near_px: f32) -> [u32; STUB_NODES] {
        let (mut nodes, mut count, mut looked_at) = ([node; STUB_NODES], 1, 0);
        while looked_at < count {
            let near = nodes[looked_at];
            for slot in self.slots().filter(|&slot| self.node(slot) == near) {
                let far = self.node(slot ^ 1);
                let is_near =
                    self.edges[slot / 2].length_px < near_px && self.degree(slot ^ 1) >= 3;
                if is_near && count < STUB_NODES && !nodes.contains(&far) {
                    nodes[count] = far;
                    count += 1;
                }
            }
            looked_at += 1;
        }
        nodes
    }

    /// Both ends of all edges, as 2·edge + end.
    fn slots(&self) -> std::ops::Range<usize> {
        0..2 * self.edges.len()
    }

    /// Node at an end of an edge, or `NONE` for a ring.
    fn node(&self, slot: usize) -> u32 {
        self.edges[slot / 2].nodes[slot % 2]
    }

    /// Number of remaining edges at the node of this end.
    fn degree(&self, slot: usize) -> u32 {
        self.nodes
            .get(self.node(slot) as usize)
            .map_or(0, |node| node.degree)
    }

    /// Pixel of an edge at this distance from one end, or the edge's other end if that is nearer.
    fn at<'a>(&self, slot: usize, from_px: f32, skeleton: &'a Skeleton) -> &'a Pixel {
        let pixels = self.pixels(slot / 2);
        let i = (from_px as usize).min(pixels.len() - 1);
        let i = if slot.is_multiple_of(2) {
            i
        } else {
            pixels.len() - 1 - i
        };
        &skeleton.pixels[pixels[i] as usize]
    }

    /// Returns whether a rope of the prior ended near free end `tip`, and `tip` is the only free
    /// end there.
    fn is_known_end(&self, tip: &Node, skeleton: &Skeleton, past: &Past) -> bool {
        let at = |node: &Node| skeleton.pixels[node.pixel as usize].at();
        let Some((end, width_px)) = past.end_near(at(tip)) else {
            return false;
        };
        self.nodes.iter().all(|node| {
            let near = vec2::distance(at(node), end) < ALONE_WIDTHS * width_px;
            node.degree != 1 || node.pixel == tip.pixel || !near
        })
    }

    /// Returns whether `junction` has another free end that is longer than edge `e`, but at most
    /// twice as long.
    fn is_fork(&self, e: usize, junction: u32) -> bool {
        let length_px = self.edges[e].length_px;
        self.edges.iter().enumerate().any(|(other, edge)| {
            let [a, b] = edge.nodes;
            if other == e || a == NONE || edge.length_px > 2.0 * length_px {
                return false;
            }
            let (a, b) = (&self.nodes[a as usize], &self.nodes[b as usize]);
            let meets =
                a.pixel == junction && b.degree == 1 || b.pixel == junction && a.degree == 1;
            meets && (edge.length_px, other) > (length_px, e)
        })
    }

    /// Pixels of edge `e`, from its first node to its second.
    pub(crate) fn pixels(&self, e: usize) -> &[u32] {
        &self.chain[self.edges[e].from as usize..self.edges[e].to as usize]
    }
}
