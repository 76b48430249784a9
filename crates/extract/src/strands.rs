//! Edges joined through crossings: each rope as a list of edges in their order.

use crate::Image;
use crate::color;
use crate::graph::Graph;
use crate::pairing::{ColoredArm, Pairing};
use crate::skeleton::{NONE, Skeleton};
use crate::zones::Zones;

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
    zone_arms: Vec<ColoredArm>,
    /// For each end of each edge (2·edge + end) the end that it goes on to, or `NONE`.
    link: Vec<u32>,
    /// The pixels to leave out there.
    trim: Vec<u32>,
    used: Vec<bool>,
    pub(crate) legs: Vec<Leg>,
    /// The ropes, the longest first.
    pub(crate) strands: Vec<Strand>,
}

impl Strands {
    /// Pairs the arms of each zone and follows each rope from end to end.
    pub(crate) fn join(
        &mut self,
        image: &Image,
        graph: &Graph,
        zones: &Zones,
        skeleton: &Skeleton,
    ) {
        self.link.clear();
        self.link.resize(2 * graph.edges.len(), NONE);
        self.trim.clear();
        self.trim.resize(2 * graph.edges.len(), 0);
        let arms = &zones.arms;
        let mut from = 0;
        while from < arms.len() {
            let zone = arms[from].zone;
            let to = from
                + arms[from..]
                    .iter()
                    .take_while(|arm| arm.zone == zone)
                    .count();
            self.pair_zone(image, graph, &arms[from..to], skeleton);
            from = to;
        }
        self.walk(graph, zones);
    }

    fn pair_zone(
        &mut self,
        image: &Image,
        graph: &Graph,
        arms: &[crate::zones::Arm],
        skeleton: &Skeleton,
    ) {
        self.zone_arms.clear();
        self.zone_arms.extend(arms.iter().map(|&arm| ColoredArm {
            arm,
            color: strand_color(image, graph, &arm, skeleton),
        }));
        let yuv = color::is_yuv(image.format());
        let partners = self.pairing.resolve(&self.zone_arms, yuv);
        let slot = |i: usize| 2 * arms[i].edge as usize + usize::from(arms[i].end);
        for (i, &j) in partners.iter().enumerate() {
            self.trim[slot(i)] = arms[i].trim;
            if j != i {
                self.link[slot(i)] = slot(j) as u32;
            }
        }
    }

    /// Follows links from every loose end, then around what is left.
    fn walk(&mut self, graph: &Graph, zones: &Zones) {
        self.legs.clear();
        self.strands.clear();
        self.used.clear();
        self.used.extend(
            graph
                .edges
                .iter()
                .zip(&zones.inside)
                .map(|(edge, &inside)| !edge.alive || inside),
        );
        for slot in 0..self.link.len() {
            if self.link[slot] == NONE && graph.edges[slot / 2].nodes[0] != NONE {
                self.follow(slot, graph);
            }
        }
        for slot in (0..self.link.len()).step_by(2) {
            self.follow(slot, graph);
        }
        self.strands
            .sort_unstable_by(|a, b| b.length_px.total_cmp(&a.length_px));
    }

    /// Follows the rope that starts at end `slot % 2` of edge `slot / 2`, unless it is known.
    fn follow(&mut self, start: usize, graph: &Graph) {
        let from = self.legs.len() as u32;
        let (mut slot, mut length_px) = (start, 0.0);
        let closed = loop {
            let edge = slot / 2;
            if self.used[edge] {
                break true;
            }
            self.used[edge] = true;
            let far = slot ^ 1;
            self.legs.push(Leg {
                edge: edge as u32,
                reversed: slot % 2 == 1,
                trim: [self.trim[slot], self.trim[far]],
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

/// The mean color along the arm's strand, just outside of the crossing.
fn strand_color(
    image: &Image,
    graph: &Graph,
    arm: &crate::zones::Arm,
    skeleton: &Skeleton,
) -> [f32; 3] {
    let pixels = graph.pixels(arm.edge as usize);
    let from = arm.trim as usize;
    let to = (from + (4.0 * arm.half_px) as usize + 3).min(pixels.len());
    let mut sum = [0.0; 3];
    for i in from..to {
        let i = if arm.end == 0 {
            i
        } else {
            pixels.len() - 1 - i
        };
        let pixel = &skeleton.pixels[pixels[i] as usize];
        let color = color::native(image, usize::from(pixel.x), usize::from(pixel.y));
        for (s, c) in sum.iter_mut().zip(color) {
            *s += f32::from(c);
        }
    }
    sum.map(|s| s / (to - from).max(1) as f32)
}
