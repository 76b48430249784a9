//! The path of a rope over the skeleton: the pixels of its legs, and of the overlaps between them.
//!
//! A crossing hides a stretch about as long as the rope is wide, and no pixels are laid there. If
//! two strands run along each other for longer, the pixels of their overlap are laid. Each pixel
//! stores the side of the overlap on which this strand is, so that the strand's center can be found
//! from its outer edge.

use super::line::{Line, OVERLAP, Sample};
use super::source::Source;
use crate::graph::shared::Necks;
use crate::graph::strands::Leg;
use crate::vec2::{self, Vec2};

/// Overlaps shorter than this many half-widths are bridged like any crossing.
const SHORTEST_HALVES: f32 = 3.0;

/// Fills `line` with the pixels of `legs` outside of crossings, in order.
pub(crate) fn lay(source: &Source, legs: &[Leg], closed: bool, half_px: f32, line: &mut Line) {
    line.clear();
    line.closed = closed;
    for (i, leg) in legs.iter().enumerate() {
        let free = |end: usize| {
            let outer = if end == 0 {
                i == 0
            } else {
                i + 1 == legs.len()
            };
            let node = node(source, leg, end);
            let degree = source.graph.nodes.get(node as usize).map(|n| n.degree);
            !closed && outer && degree == Some(1)
        };
        let count = source.graph.pixels(leg.edge as usize).len();
        // Thinning bends the last pixels before a tip toward one of its corners.
        let tip = ((1.4 * half_px) as usize).min(count / 3);
        let trim = [0, 1].map(|end| leg.trim[end] as usize + if free(end) { tip } else { 0 });
        let to = count.saturating_sub(trim[1]).max(trim[0]);
        for k in trim[0]..to {
            let bridge = k == trim[0] && trim[0] > 0 || k + 1 == to && trim[1] > 0;
            let weight = if bridge && legs.len() > 1 { 0.0 } else { 1.0 };
            push(line, pixel(source, leg, k), weight, 0.0, half_px);
        }
        let next = if i + 1 < legs.len() {
            legs.get(i + 1)
        } else {
            legs.first()
        };
        if let Some(next) = next
            && (closed || i + 1 < legs.len())
        {
            lay_overlap(source, leg, next, half_px, line);
        }
    }
    if let (true, Some(first), Some(last)) = (closed, line.samples.first(), line.samples.last())
        && line.samples.len() > 1
        && first.at == last.at
    {
        line.samples.pop();
    }
}

fn push(line: &mut Line, at: Vec2, weight: f32, side: f32, half_px: f32) {
    line.samples.push(Sample {
        at,
        weight,
        width_px: 2.0 * half_px,
        side,
    });
}

/// The node at the start (0) or the end (1) of a leg.
fn node(source: &Source, leg: &Leg, end: usize) -> u32 {
    source.graph.edges[leg.edge as usize].nodes[end ^ usize::from(leg.reversed)]
}

/// Pixel `k` of a leg, from its start.
fn pixel(source: &Source, leg: &Leg, k: usize) -> Vec2 {
    let pixels = source.graph.pixels(leg.edge as usize);
    let k = k.min(pixels.len() - 1);
    let index = if leg.reversed {
        pixels.len() - 1 - k
    } else {
        k
    };
    source.skeleton.pixels[pixels[index] as usize].at()
}

/// Lays the pixels of the stretch between `leg` and `next` that other strands share, if it is long.
fn lay_overlap(source: &Source, leg: &Leg, next: &Leg, half_px: f32, line: &mut Line) {
    let stretch = &source.shared[leg.shared[0] as usize..leg.shared[1] as usize];
    let at = |k: usize| source.skeleton.pixels[stretch[k] as usize].at();
    let count = stretch.len();
    let length_px: f32 = (1..count).map(|k| vec2::distance(at(k - 1), at(k))).sum();
    if count < 3 || length_px < SHORTEST_HALVES * half_px {
        return;
    }
    let reach = ((3.0 * half_px) as usize).max(3).min(count - 1);
    let before = line.samples.last().map_or(at(0), |s| s.at);
    let after = pixel(source, next, next.trim[0] as usize);
    let ahead = [
        vec2::sub(at(reach), at(0)),
        vec2::sub(at(count - 1), at(count - 1 - reach)),
    ];
    let side = [
        vec2::cross(ahead[0], vec2::sub(before, at(0))).signum(),
        vec2::cross(ahead[1], vec2::sub(after, at(count - 1))).signum(),
    ];
    let necks = Necks::of(stretch, source.skeleton, leg.shared_half_px);
    let changes = necks.at().len();
    // The changes of side at the necks must lead from the side where the strand enters to the side
    // where it leaves.
    let agree = necks.are_known && changes.is_multiple_of(2) == (side[0] == side[1]);
    for k in 1..count - 1 {
        let before = necks
            .at()
            .iter()
            .filter(|&&neck| (neck as usize) < k)
            .count();
        let t = k as f32 / (count - 1) as f32;
        let here = match agree {
            true if before.is_multiple_of(2) => side[0],
            true => -side[0],
            false => side[0] + t * (side[1] - side[0]),
        };
        push(line, at(k), OVERLAP, here, half_px);
    }
}
