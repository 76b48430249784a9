//! Zones: groups of junctions that are one crossing, and the arms that leave them. The edges inside
//! a zone are only passed by strands (see `assignment`).

use super::Graph;
use super::arm::{Arm, reach_px};
use super::forest;
use crate::image::{Image, color};
use crate::past::{FormerPlaces, Past};
use crate::skeleton::{NONE, Skeleton};
use crate::statistics::quantile_of_positive;
use crate::vec2::{self, Vec2};

/// Minimum half-width of a strand that counts as wider than most, relative to the usual one.
const WIDER: f32 = 1.25;

/// Half-width at a pixel, relative to that of its edge, above which the pixel is part of a
/// crossing. `SWOLLEN_PX` is added for whole pixels.
const SWOLLEN: f32 = 1.12;
const SWOLLEN_PX: f32 = 0.3;
/// Range ahead, in half-widths, that tells a rising strand from a crossing. A strand that rises
/// toward the camera widens gradually, so it is still as wide in this range. At a crossing, the
/// width falls.
const AHEAD_HALVES: [f32; 2] = [4.0, 8.0];
/// Maximum half-width of a rising strand, relative to its edge. Two strands side by side are wider.
const RISEN: f32 = 1.6;

/// Buffers and result of the step.
#[derive(Debug, Default)]
pub(crate) struct Zones {
    /// For each node, another node of its zone. A root points to itself.
    parent: Vec<u32>,
    halves: Vec<f32>,
    /// Half the rope's width along each edge, away from crossings.
    pub(crate) edge_half_px: Vec<f32>,
    /// For each edge, true if it is an overlap inside a zone.
    pub(crate) inside: Vec<bool>,
    /// Arms sorted by zone.
    pub(crate) arms: Vec<Arm>,
    /// Arm of each end of each edge (2·edge + end), as an index into `arms`, or `NONE`.
    arm_of: Vec<u32>,
    /// For each node, the two widest edges that end there, with their half-widths.
    widest: Vec<[(u32, f32); 2]>,
    /// Usual half-width of a strand in the image.
    pub(crate) half_px: f32,
    /// The prior: the ropes of the last image.
    pub(crate) past: Past,
}

impl Zones {
    /// Measures the widths of strands. Each junction is a zone of its own.
    pub(crate) fn begin(&mut self, graph: &Graph, skeleton: &Skeleton) {
        self.measure_halves(graph, skeleton);
        self.parent.clear();
        self.parent.extend(0..graph.nodes.len() as u32);
        self.inside.clear();
        self.inside.resize(graph.edges.len(), false);
        self.list_widest(graph);
    }

    /// Usual half-width of a strand at edge `e`: next to a strand that is wider than most, that
    /// strand's.
    pub(crate) fn usual_half_px(&self, e: usize, graph: &Graph) -> f32 {
        let widest = self.widest_half_px(e, graph);
        match widest > WIDER * self.half_px {
            true => widest,
            false => self.half_px,
        }
    }

    /// Makes edge `e` the inside of a zone, and merges the zones of its two nodes.
    pub(crate) fn join(&mut self, e: usize, graph: &Graph) {
        self.inside[e] = true;
        forest::join(&mut self.parent, graph.edges[e].nodes);
    }

    /// Finds the arms of all zones.
    pub(crate) fn collect_arms(&mut self, image: &Image, graph: &Graph, skeleton: &Skeleton) {
        self.arms.clear();
        self.list_widest(graph);
        for e in 0..graph.edges.len() {
            let edge = &graph.edges[e];
            if self.inside[e] || edge.nodes[0] == NONE {
                continue;
            }
            for end in 0..2u8 {
                let node = edge.nodes[usize::from(end)];
                if graph.nodes[node as usize].degree >= 2 {
                    let zone = forest::root(&mut self.parent, node);
                    let mut arm = self.arm(e, end, zone, graph, skeleton);
                    arm.color = strand_color(image, graph, &arm, skeleton);
                    arm.past = self.past.recall(arm.at, arm.into);
                    self.arms.push(arm);
                }
            }
        }
        self.arms
            .sort_unstable_by_key(|arm| (arm.zone, arm.edge, arm.end));
        self.arm_of.clear();
        self.arm_of.resize(2 * graph.edges.len(), NONE);
        for (i, arm) in self.arms.iter().enumerate() {
            self.arm_of[arm.slot()] = i as u32;
        }
    }

    /// Index of the arm at end `slot` (2·edge + end).
    pub(crate) fn arm_at(&self, slot: usize) -> Option<usize> {
        let arm = *self.arm_of.get(slot)?;
        (arm != NONE).then_some(arm as usize)
    }

    /// Range of a zone's arms in `arms`.
    pub(crate) fn arms_of(&self, zone: u32) -> std::ops::Range<usize> {
        let from = self.arms.partition_point(|arm| arm.zone < zone);
        from..from + self.arms[from..].partition_point(|arm| arm.zone == zone)
    }

    fn list_widest(&mut self, graph: &Graph) {
        self.widest.clear();
        self.widest.resize(graph.nodes.len(), [(NONE, 0.0); 2]);
        let free = |e: &usize| !self.inside[*e] && graph.edges[*e].nodes[0] != NONE;
        for e in (0..graph.edges.len()).filter(free) {
            let new = (e as u32, self.edge_half_px[e]);
            let [a, b] = graph.edges[e].nodes;
            for node in [a].into_iter().chain((b != a).then_some(b)) {
                let [first, second] = &mut self.widest[node as usize];
                if new.1 > first.1 {
                    (*first, *second) = (new, *first);
                } else if new.1 > second.1 {
                    *second = new;
                }
            }
        }
    }

    /// Returns whether strands meet anywhere: in a crossing, or an end on a strand.
    pub(crate) fn has_meeting(&self) -> bool {
        let zones = self.arms.chunk_by(|a, b| a.zone == b.zone);
        zones.into_iter().any(|arms| arms.len() >= 3)
    }

    /// Half-width of the widest strand at either node of edge `e`.
    pub(crate) fn widest_half_px(&self, e: usize, graph: &Graph) -> f32 {
        let nodes = graph.edges[e].nodes.into_iter();
        let strands = nodes.flat_map(|node| self.widest.get(node as usize).into_iter().flatten());
        strands
            .filter(|&&(edge, _)| edge != NONE && edge as usize != e)
            .map(|&(_, half_px)| half_px)
            .reduce(f32::max)
            .unwrap_or(self.half_px)
    }

    /// Measures the half-width over all edges, and along each edge of more than six half-widths.
    fn measure_halves(&mut self, graph: &Graph, skeleton: &Skeleton) {
        let half = |&p: &u32| skeleton.pixels[p as usize].half_px;
        self.halves.clear();
        for e in 0..graph.edges.len() {
            self.halves.extend(graph.pixels(e).iter().map(half));
        }
        self.half_px = quantile_of_positive(&mut self.halves, 0.45).max(0.5);
        self.edge_half_px.clear();
        for e in 0..graph.edges.len() {
            let mut value = self.half_px;
            if graph.edges[e].length_px > 6.0 * self.half_px {
                self.halves.clear();
                self.halves.extend(graph.pixels(e).iter().map(half));
                value = quantile_of_positive(&mut self.halves, 0.35).max(0.5);
            }
            self.edge_half_px.push(value);
        }
    }

    /// The arm at one end of edge `e`: how much of it belongs to the crossing, and its direction.
    pub(super) fn arm(
        &self,
        e: usize,
        end: u8,
        zone: u32,
        graph: &Graph,
        skeleton: &Skeleton,
    ) -> Arm {
        let pixels = graph.pixels(e);
        let half_px = self.edge_half_px[e];
        let pixel = |i: usize| {
            let i = if end == 0 { i } else { pixels.len() - 1 - i };
            &skeleton.pixels[pixels[i] as usize]
        };
        let junction = graph.edges[e].nodes[usize::from(end)];
        let crossing = graph.nodes[junction as usize].degree >= 3;
        let most = (pixels.len().saturating_sub(3)) / 2;
        let mut trim = 0;
        if crossing {
            let swollen = |half_px: f32| SWOLLEN * half_px + SWOLLEN_PX;
            let [from, to] = AHEAD_HALVES.map(|halves| (halves * half_px) as usize + 1);
            let is_risen = |trim: usize| {
                let window = trim + from..trim + to;
                // There may be another crossing at the far end of the edge.
                if window.end + to > pixels.len() {
                    return false;
                }
                let sum: f32 = window.map(|i| pixel(i).half_px).sum();
                let ahead_px = (sum / (to - from) as f32).min(RISEN * half_px);
                ahead_px > swollen(half_px) && pixel(trim).half_px <= swollen(ahead_px)
            };
            while trim < most
                && (pixel(trim).half_px > swollen(half_px) && !is_risen(trim)
                    || vec2::distance(pixel(trim).at(), pixel(0).at()) < 0.7 * half_px)
            {
                trim += 1;
            }
            trim = (trim + (0.3 * half_px) as usize).min(most);
        }
        let last = (trim + reach_px(half_px)).min(pixels.len() - 1);
        let into = line_direction((trim..=last).map(|i| pixel(i).at()), pixel(last).at());
        let at = pixel(trim).at();
        Arm {
            edge: e as u32,
            end,
            zone,
            trim: trim as u32,
            at,
            into,
            half_px,
            color: [0.0; 3],
            past: FormerPlaces::default(),
        }
    }
}

/// Mean color along the arm's strand, just outside of the crossing.
pub(crate) fn strand_color(
    image: &Image,
    graph: &Graph,
    arm: &Arm,
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

/// Direction of the least-squares line through `points`, away from `far`, which is the last point.
fn line_direction(points: impl Iterator<Item = Vec2> + Clone, far: Vec2) -> Vec2 {
    let (mut count, mut sum) = (0.0, [0.0; 2]);
    let first = points.clone().next().unwrap_or(far);
    for p in points.clone() {
        (count, sum) = (count + 1.0, vec2::add(sum, p));
    }
    let mean = vec2::scale(sum, 1.0 / f32::max(count, 1.0));
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for p in points {
        let d = vec2::sub(p, mean);
        (xx, xy, yy) = (xx + d[0] * d[0], xy + d[0] * d[1], yy + d[1] * d[1]);
    }
    let turn = 0.5 * libm::atan2f(2.0 * xy, xx - yy);
    let (sin, cos) = libm::sincosf(turn);
    let axis = [cos, sin];
    let outward = vec2::sub(first, far);
    if vec2::dot(axis, outward) < 0.0 {
        vec2::scale(axis, -1.0)
    } else {
        axis
    }
}
