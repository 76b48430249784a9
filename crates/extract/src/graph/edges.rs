//! The skeleton as a graph: ends and junctions joined by strands of pixels, without the spurs that
//! a ragged edge leaves.

use crate::past::Past;
use crate::skeleton::{NONE, Skeleton};
use crate::vec2;

/// Strands beyond which an image is taken for noise.
const MOST_EDGES: usize = 4096;
/// A free end nearer to its junction than this many half-widths is a bump of the rope's edge or a
/// corner of its tip (which lies √2 half-widths off), not a rope.
const SPUR_HALVES: f32 = 1.5;
/// The same for two free ends at one junction: the corners of a frayed or hollow tip.
const FORK_HALVES: f32 = 3.0;
/// Widths around a rope's known end in which it is the only free end.
const ALONE_WIDTHS: f32 = 3.0;

/// A skeleton pixel where a strand ends or several meet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Node {
    pub(crate) pixel: u32,
    /// Ends of edges here.
    pub(crate) degree: u32,
}

/// A strand of skeleton pixels from one node to another.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edge {
    /// The nodes at its two ends; `NONE` twice for a ring without nodes.
    pub(crate) nodes: [u32; 2],
    /// Where its pixels, those of the nodes included, lie in `Graph::chain`.
    pub(crate) from: u32,
    pub(crate) to: u32,
    pub(crate) length_px: f32,
}

/// Memory and result of the tracing.
#[derive(Debug, Default)]
pub(crate) struct Graph {
    pub(crate) nodes: Vec<Node>,
    pub(crate) edges: Vec<Edge>,
    /// Pixels of all edges, edge by edge.
    chain: Vec<u32>,
    /// For each pixel its node, or `NONE`.
    node_of: Vec<u32>,
    visited: Vec<bool>,
    spurs: Vec<u32>,
}

impl Graph {
    /// Makes room for the spurs of a rough skeleton.
    pub(crate) fn reserve(&mut self) {
        self.spurs.reserve(256);
    }

    /// Traces `skeleton`. An image that is noise gets no edges.
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

    /// Follows the strand that leaves `start` by its neighbor `next`, to the next node or, on a ring,
    /// back to `start`.
    fn follow(&mut self, skeleton: &Skeleton, start: u32, next: u32) {
        let pixels = &skeleton.pixels;
        let from = self.chain.len() as u32;
        self.chain.push(start);
        let (mut before, mut here, mut length_px) = (start, next, 0.0);
        loop {
            self.chain.push(here);
            let (a, b) = (&pixels[before as usize], &pixels[here as usize]);
            // Neighbors by a corner or by a side.
            length_px += if (a.x != b.x) & (a.y != b.y) {
                std::f32::consts::SQRT_2
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

    /// Takes spurs out of `skeleton`, the shortest first, and traces again, until there are none. What
    /// sticks out where a rope of the past ended is no spur but that end, on its way over a strand.
    pub(crate) fn prune(&mut self, skeleton: &mut Skeleton, past: &Past) {
        loop {
            self.spurs.clear();
            for e in 0..self.edges.len() {
                if self.is_spur(e, skeleton, past) {
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
                // An earlier removal may have made this one the continuation of a strand.
                if self.is_spur(e, skeleton, past) {
                    self.remove(e, skeleton);
                }
            }
            self.trace(skeleton);
        }
    }

    /// Takes the pixels of spur `e` out of the skeleton, all but its junction.
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

    fn is_spur(&self, e: usize, skeleton: &Skeleton, past: &Past) -> bool {
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
        is_short && !self.is_known_end(&tip, skeleton, past)
    }

    /// Whether a rope of the past ended near free end `tip`, and no other free end is near that could
    /// be its end.
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

    /// Whether another free end, no shorter than edge `e` but about as short, is at `junction`.
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

    /// The pixels of edge `e` from its first node to its second.
    pub(crate) fn pixels(&self, e: usize) -> &[u32] {
        &self.chain[self.edges[e].from as usize..self.edges[e].to as usize]
    }
}
