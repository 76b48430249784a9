//! Decides both crossings together if two strands cross twice with a narrow gap in between.
//!
//! The strands either cross at both ends of the gap or touch at both. Either way they leave on the
//! same sides. The two hypotheses differ only in which strand runs along which side of the gap. The
//! short sides hardly have a direction of their own at each crossing, so the pairing of a single
//! zone is unreliable. Here, each hypothesis is judged over the whole length, and the lower cost
//! wins.
//!
//! The cost of a strand is the bending from its arm, along a side, to the arm at which it leaves
//! (`run`), plus color and the prior at both joints. Width and side do not count. An exchange
//! overrules the pairing.

use super::Graph;
use super::arm::Arm;
use super::pairing::{bending, color_cost};
use super::zones::Zones;
use crate::skeleton::{NONE, Skeleton};
use crate::vec2::{self, Vec2};

/// Maximum length of a side, in half-widths. Longer sides have reliable directions of their own.
const LONGEST_HALVES: f32 = 24.0;

/// One side of the gap: an edge between two zones, as its end at the first zone and its end at the
/// second.
type Side = [usize; 2];

/// Exchanges the partners of the two sides of each gap, at both ends, if that costs less.
///
/// For each end of each edge, `link` is the end at which its strand continues, and `arm` is the
/// index of its arm.
pub(crate) fn resolve(
    link: &mut [u32],
    arm: &[u32],
    (graph, skeleton, zones): (&Graph, &Skeleton, &Zones),
    yuv: bool,
) {
    let arm_of = |slot: usize| zones.arms.get(arm[slot] as usize);
    for (i, first) in zones.arms.iter().enumerate() {
        let Some(a) = side(first, &arm_of, graph, zones) else {
            continue;
        };
        // The other side starts in the same zone. Arms are sorted by zone, so its arm follows.
        for second in zones.arms[i + 1..]
            .iter()
            .take_while(|s| s.zone == first.zone)
        {
            let Some(b) = side(second, &arm_of, graph, zones) else {
                continue;
            };
            let ends = |side: Side| side.map(|slot| arm_of(slot).map(|arm| arm.zone));
            if ends(a) != ends(b) || a[0] / 2 == b[0] / 2 {
                continue;
            }
            let onward = |side: Side| side.map(|slot| link[slot]);
            let ([a0, a1], [b0, b1]) = (onward(a), onward(b));
            let loose = [a0, a1, b0, b1].contains(&NONE);
            let within = |slot: u32| [a[0] / 2, b[0] / 2].contains(&(slot as usize / 2));
            if loose || within(a0) || within(a1) || within(b0) || within(b1) {
                continue;
            }
            let cost = |from: u32, along: Side, to: u32| {
                let ends = (arm_of(from as usize), arm_of(to as usize));
                let (Some(from), Some(to)) = ends else {
                    return f32::INFINITY;
                };
                let join = |a: &Arm, b: &Arm| {
                    let far_px = vec2::distance(a.at, b.at);
                    color_cost(a, b, yuv) + zones.past.against(&a.past, &b.past, far_px)
                };
                let joins = [(from, along[0]), (to, along[1])];
                let joins = joins.map(|(arm, slot)| arm_of(slot).map_or(0.0, |s| join(arm, s)));
                run(from, along, to, graph, skeleton) + joins[0] + joins[1]
            };
            if cost(b0, a, b1) + cost(a0, b, a1) < cost(a0, a, a1) + cost(b0, b, b1) {
                for (side, [from, to]) in [(a, [b0, b1]), (b, [a0, a1])] {
                    link[side[0]] = from;
                    link[from as usize] = side[0] as u32;
                    link[side[1]] = to;
                    link[to as usize] = side[1] as u32;
                }
            }
        }
    }
}

/// Returns the edge of `arm` as a side of a gap, if it is short enough, starts in the arm's zone
/// and ends in a later one.
fn side<'a>(
    arm: &Arm,
    arm_of: &impl Fn(usize) -> Option<&'a Arm>,
    graph: &Graph,
    zones: &Zones,
) -> Option<Side> {
    let slot = arm.slot();
    let far = arm_of(slot ^ 1)?;
    let short = graph.edges[arm.edge as usize].length_px <= LONGEST_HALVES * zones.half_px;
    (short && far.zone > arm.zone).then_some([slot, slot ^ 1])
}

/// Bending energy of a strand that comes from one arm, follows a side and leaves by another arm.
fn run(from: &Arm, along: Side, to: &Arm, graph: &Graph, skeleton: &Skeleton) -> f32 {
    let edge = along[0] / 2;
    let pixels = graph.pixels(edge);
    let last = pixels.len() - 1;
    let at = |share: f32| -> Vec2 {
        let k = (share * last as f32 + 0.5) as usize;
        let k = if along[0].is_multiple_of(2) {
            k
        } else {
            last - k
        };
        skeleton.pixels[pixels[k] as usize].at()
    };
    let enter = vec2::unit_or(vec2::sub(at(0.45), at(0.2)), from.into);
    let leave = vec2::unit_or(vec2::sub(at(0.8), at(0.55)), enter);
    let out = vec2::scale(to.into, -1.0);
    bending(from.at, from.into, at(0.33), enter) + bending(at(0.67), leave, to.at, out)
}
