//! Joins: which slots a strand can run between, over which passed edges, and at what cost.

use super::Ground;
use super::ends::{Ends, Strands, node};
use super::features::{self, Features, cost};
use super::mouth::{CURVED, Mouth};
use crate::bitmap::bits::BitPlane;
use crate::graph::Graph;
use crate::graph::arm::Arm;
use crate::graph::bending::{bending_of, cubic};
use crate::graph::shared;
use crate::graph::zones::Zones;
use crate::image::color;
use crate::vec2;

/// Maximum number of edges passed in a row.
pub(super) const MOST_PASSES: usize = 6;
/// Maximum length of several edges passed in a row, in widths.
const LONGEST_CHAIN: f32 = 14.0;
/// Maximum length of passed edges relative to their chord, plus a width. It allows an arc of two
/// fifths of a turn.
const DETOUR: f32 = 1.3;
/// Minimum mean half-width of a wide edge, relative to the usual one.
const WIDE: f32 = 1.2;
/// Cap of a bending energy: all sharper bends are as unlikely.
const MOST_BEND: f32 = 2.5;
/// Joins of each slot: maximum number, and maximum cost. Dearer joins never beat
/// two ends.
const MOST_JOINS: usize = 16;
const DEAREST: f32 = 20.0;
/// Difference in color of one unit, and its cap.
const LEVELS: f32 = 60.0;
const MOST_COLOR: f32 = 0.9;

/// Maximum length of passed edges in a row, in widths: of those as narrow as one strand, and of each
/// wider one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    pub(super) narrow: f32,
    pub(super) wide: f32,
}

impl Limits {
    /// Returns whether strands may pass edge `e`.
    pub(super) fn allow(&self, e: usize, ends: &Ends, graph: &Graph) -> bool {
        let [a, b] = graph.edges[e].nodes;
        let is_junction = |node: u32| graph.nodes[node as usize].degree >= 3;
        let most = match ends.ratio[e] >= WIDE {
            true => self.wide,
            false => self.narrow,
        };
        a != b && is_junction(a) && is_junction(b) && ends.widths[e] <= most
    }
}

/// A join between two slots of the graph.
#[derive(Clone, Copy, Debug)]
pub(super) struct Join {
    pub(super) slots: [u32; 2],
    pub(super) cost: f32,
    passed: [u32; MOST_PASSES],
    count: u8,
}

impl Join {
    /// Ends at which edges are passed on the way from the first slot.
    pub(super) fn passed(&self) -> &[u32] {
        &self.passed[..usize::from(self.count)]
    }

    /// Ends at which edges are passed on the way from one of its slots.
    pub(super) fn passed_from(&self, slot: u32) -> impl Iterator<Item = u32> {
        let is_ahead = self.slots[0] == slot;
        let count = usize::from(self.count);
        (0..count).map(move |k| match is_ahead {
            true => self.passed[k],
            false => self.passed[count - 1 - k] ^ 1,
        })
    }

    /// The join from `slots[0]` over all of the given ends to `slots[1]`. `None` if these are too
    /// many.
    pub(super) fn over(slots: [u32; 2], all: impl Iterator<Item = u32>) -> Option<Self> {
        let (mut passed, mut count) = ([0; MOST_PASSES], 0);
        for slot in all {
            *passed.get_mut(count)? = slot;
            count += 1;
        }
        Some(Self {
            slots,
            cost: 0.0,
            passed,
            count: count as u8,
        })
    }

    /// Turns the join so that its first slot is the smaller one.
    fn sort(&mut self) {
        if self.slots[0] > self.slots[1] {
            self.slots.swap(0, 1);
            let passed = &mut self.passed[..usize::from(self.count)];
            passed.reverse();
            passed.iter_mut().for_each(|slot| *slot ^= 1);
        }
    }
}

/// Passed edges, by the ends at which they are entered.
#[derive(Clone, Copy, Debug, Default)]
struct Pass {
    edges: [u32; MOST_PASSES],
    count: usize,
    widths: f32,
    narrow_widths: f32,
}

/// Buffers and result of the step.
#[derive(Debug, Default)]
pub(super) struct Joins {
    pub(super) found: Vec<Join>,
    /// Pixels of the passed edges.
    stretch: Vec<u32>,
}

impl Joins {
    pub(super) fn reserve(&mut self) {
        self.found.reserve(4096);
        self.stretch.reserve(4096);
    }

    /// Lists the cheapest joins between the slots of some nodes.
    pub(super) fn list(
        &mut self,
        nodes: &[u32],
        limits: Limits,
        ends: &Ends,
        (of, zones): (Ground, &Zones),
    ) {
        let Self { found, stretch } = self;
        found.clear();
        stretch.clear();
        let mut search = Search {
            ends,
            of,
            zones,
            limits,
            found,
            stretch,
        };
        let junctions = nodes
            .iter()
            .filter(|&&n| of.graph.nodes[n as usize].degree >= 2);
        for &slot in junctions.flat_map(|&node| ends.at(node)) {
            let from = search.found.len();
            search.go_on(slot, slot, Pass::default());
            search.found[from..].sort_unstable_by(|a, b| a.cost.total_cmp(&b.cost));
            search.found.truncate(from + MOST_JOINS);
        }
        // Each join was found from both of its slots, unless it is among the cheapest of only one.
        found.iter_mut().for_each(Join::sort);
        found.sort_unstable_by(|a, b| a.slots.cmp(&b.slots).then(a.cost.total_cmp(&b.cost)));
        found.dedup_by_key(|join| join.slots);
    }
}

/// A search from one slot.
struct Search<'a> {
    ends: &'a Ends,
    of: Ground<'a>,
    zones: &'a Zones,
    limits: Limits,
    found: &'a mut Vec<Join>,
    stretch: &'a mut Vec<u32>,
}

impl Search<'_> {
    /// Adds joins from slot `from` to all that are reached over passed edges; the last one ends at
    /// slot `last`.
    fn go_on(&mut self, from: u32, last: u32, so_far: Pass) {
        let graph = self.of.graph;
        for &slot in self.ends.at(node(last, graph)) {
            let passed = &so_far.edges[..so_far.count];
            let is_used = passed.iter().any(|passed| passed / 2 == slot / 2);
            let is_own = slot / 2 == from / 2;
            if slot == last || slot == from || is_used || is_own && so_far.count > 0 {
                continue;
            }
            self.reach(from, slot, &so_far);
            let e = slot as usize / 2;
            let may_pass = !is_own && self.limits.allow(e, self.ends, graph);
            if so_far.count == MOST_PASSES || !may_pass {
                continue;
            }
            let widths = self.ends.widths[e];
            let mut further = so_far;
            further.edges[so_far.count] = slot;
            further.count += 1;
            further.widths += widths;
            if self.ends.ratio[e] < WIDE {
                further.narrow_widths += widths;
            }
            let is_short = further.count == 1 || further.widths <= LONGEST_CHAIN;
            if further.narrow_widths <= self.limits.narrow && is_short {
                let before = self.stretch.len();
                extend(self.stretch, slot, graph);
                self.go_on(from, slot ^ 1, further);
                self.stretch.truncate(before);
            }
        }
    }

    /// Adds the join from one slot to another, if it is likely enough.
    fn reach(&mut self, from: u32, to: u32, pass: &Pass) {
        let [a, b] = [from, to].map(|slot| &self.ends.mouths[slot as usize]);
        let is_detour = pass.count > 1 || pass.narrow_widths > 0.0;
        let straight_px = vec2::distance(a.arm.at, b.arm.at);
        let most = DETOUR * straight_px / (2.0 * self.zones.half_px) + 1.0;
        if is_detour && pass.widths > most {
            return;
        }
        let passed = &pass.edges[..pass.count];
        let of = (self.of, self.zones);
        let cost_of_it = cost(&join_features([a, b], passed, self.stretch, of));
        let together = |&slot: &u32| {
            let features = (self.ends).edge_features(slot as usize / 2, Strands::Several);
            cost(&features)
        };
        let narrow: f32 = passed.iter().map(together).sum();
        if cost_of_it + narrow <= DEAREST {
            self.found.push(Join {
                slots: [from, to],
                cost: cost_of_it,
                passed: pass.edges,
                count: pass.count as u8,
            });
        }
    }
}

/// Appends the pixels of an edge, from one of its ends. The first is that of its node, which the
/// edge before has too.
pub(super) fn extend(stretch: &mut Vec<u32>, slot: u32, graph: &Graph) {
    let pixels = graph.pixels(slot as usize / 2);
    let skip = usize::from(!stretch.is_empty());
    if slot.is_multiple_of(2) {
        stretch.extend(pixels.iter().skip(skip));
    } else {
        stretch.extend(pixels.iter().rev().skip(skip));
    }
}

/// Features of a join over `passed` edges with these pixels.
pub(super) fn join_features(
    [a, b]: [&Mouth; 2],
    passed: &[u32],
    stretch: &[u32],
    (of, zones): (Ground, &Zones),
) -> Features {
    let yuv = color::is_yuv(of.image.format());
    let (mut from, mut to) = (a.arm, b.arm);
    let (mut is_laid, mut sides) = (false, 0.0);
    if let &[slot] = passed {
        let e = slot as usize / 2;
        let stretch = (stretch, of.graph.edges[e].length_px);
        let widest_px = zones.widest_half_px(e, of.graph);
        let straight = shared::lay_straight([from, to], stretch, of.skeleton, widest_px);
        if let Some((arms, changes)) = straight {
            ([from, to], sides) = (arms, changes);
            is_laid = true;
        }
    }
    let chord = vec2::sub(to.at, from.at);
    let px = vec2::norm(chord);
    let chord = vec2::unit_or(chord, from.into);
    let alpha = vec2::angle(chord, from.into);
    let beta = vec2::angle(chord, vec2::scale(to.into, -1.0));
    let (wa, wb) = (from.half_px, to.half_px);
    // Half the turn of an arc with the mean of both curvatures. The curvature of b is negated,
    // because the strand runs out of b. Far along a shared stretch, the curvature before it tells
    // nothing.
    let arc_px = match is_laid {
        true => px.min(0.5 * CURVED.0 * (wa + wb)),
        false => px,
    };
    let sine = 0.25 * arc_px * (a.curvature - b.curvature);
    let turn = libm::asinf(sine.clamp(-1.0, 1.0));
    let width = (wa - wb) / (wa + wb);
    let levels = (color::distance(from.color, to.color, yuv) / LEVELS).min(MOST_COLOR);
    let curving = 3.0 * (wa + wb) * (a.curvature + b.curvature);
    let straight_px = vec2::distance(a.arm.at, b.arm.at);
    let mut features = [0.0; features::COUNT];
    features[features::BEND] = bending_of(alpha, beta).min(MOST_BEND);
    features[features::OFF_ARC] = bending_of(alpha + turn, beta - turn).min(MOST_BEND);
    features[features::S_BEND] = ((alpha + beta) * (alpha + beta)).min(MOST_BEND);
    features[features::CURVATURE] = (curving * curving).min(MOST_BEND);
    // Whole pixels say little about the widths of thin strands.
    features[features::WIDTH] = width * width * (wa + wb).min(10.0) / 10.0;
    features[features::COLOR] = levels * levels;
    // A stretch that was laid straight is inside the mask.
    if !is_laid {
        let out = outside(&a.arm, &b.arm, of.mask);
        features[features::OUTSIDE] = straight_px * out / (wa + wb);
    }
    features[features::SIDES] = sides;
    let far_px = straight_px.max(px);
    features[features::PRIOR] = (zones.past).against(&a.arm.past, &b.arm.past, far_px);
    features
}

/// Share of the way from one arm to another that is outside of the mask. The way is the cubic that
/// leaves both arms in their own directions.
fn outside(a: &Arm, b: &Arm, mask: &BitPlane) -> f32 {
    const ASKED: usize = 8;
    let way = cubic([a.at, a.into], [b.at, b.into]);
    let out = (1..ASKED).filter(|&k| {
        let [x, y] = way(k as f32 / ASKED as f32);
        !mask.get(x as i32, y as i32)
    });
    out.count() as f32 / (ASKED - 1) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{Image, PixelFormat};
    use crate::skeleton::Skeleton;

    /// An end at `at` of a strand that leads into a crossing in the direction `deg`.
    fn mouth(at: [f32; 2], deg: f32) -> Mouth {
        let (sin, cos) = libm::sincosf(deg.to_radians());
        let mut mouth = Mouth::NONE;
        mouth.arm.at = at;
        mouth.arm.into = [cos, sin];
        mouth.arm.half_px = 4.0;
        mouth.arm.color = [120.0; 3];
        mouth
    }

    /// Features of a join without passed edges, in a mask of this many columns of the picture.
    fn features_of(a: &Mouth, b: &Mouth, covered: u32) -> Features {
        let mut mask = BitPlane::default();
        mask.resize(64, 64);
        for y in 0..64 {
            mask.row_mut(y)[0] = u64::MAX.unbounded_shr(64 - covered);
        }
        let rgb = vec![0; 64 * 64 * 3];
        let of = Ground {
            image: &Image::new(&rgb, 64, 64, 192, PixelFormat::Rgb8).unwrap(),
            graph: &Graph::default(),
            skeleton: &Skeleton::default(),
            mask: &mask,
        };
        join_features([a, b], &[], &[], (of, &Zones::default()))
    }

    /// Asserts that a feature and the cost of the whole join rise.
    fn assert_rises(feature: usize, joins: impl Iterator<Item = Features>) {
        let joins: Vec<_> = joins.collect();
        for pair in joins.windows(2) {
            assert!(pair[1][feature] > pair[0][feature], "{pair:?}");
            assert!(cost(&pair[1]) > cost(&pair[0]), "{pair:?}");
        }
        assert!(joins[0][feature] < 1e-6);
    }

    #[test]
    fn a_join_costs_more_the_more_it_bends() {
        let a = mouth([20.0, 32.0], 0.0);
        let bent = |deg: f32| features_of(&a, &mouth([44.0, 32.0], 180.0 - deg), 64);
        let degrees = [0.0, 10.0, 20.0, 40.0, 70.0];
        assert_rises(features::BEND, degrees.into_iter().map(bent));
        let degrees = [0.0, 10.0, 20.0, 40.0, 70.0];
        assert_rises(features::S_BEND, degrees.into_iter().map(bent));
    }

    #[test]
    fn a_join_costs_more_the_more_its_strands_differ() {
        let a = mouth([20.0, 32.0], 0.0);
        let other = |change: &dyn Fn(&mut Mouth)| {
            let mut b = mouth([44.0, 32.0], 180.0);
            change(&mut b);
            features_of(&a, &b, 64)
        };
        let wider = [0.0, 0.5, 1.0, 2.0].map(|px| other(&|b| b.arm.half_px += px));
        assert_rises(features::WIDTH, wider.into_iter());
        let lighter = [0.0, 5.0, 10.0, 20.0].map(|by| other(&|b| b.arm.color = [120.0 + by; 3]));
        assert_rises(features::COLOR, lighter.into_iter());
        let curved = [0.0, 0.01, 0.02, 0.04].map(|by| other(&|b| b.curvature = by));
        assert_rises(features::CURVATURE, curved.into_iter());
    }

    #[test]
    fn a_join_costs_more_the_less_of_it_is_in_the_mask() {
        let (a, b) = (mouth([20.0, 32.0], 0.0), mouth([44.0, 32.0], 180.0));
        let inside = [64, 40, 32, 24].map(|covered| features_of(&a, &b, covered));
        assert_rises(features::OUTSIDE, inside.into_iter());
    }

    #[test]
    fn an_arc_costs_less_than_the_same_bend_of_straight_strands() {
        let [mut a, mut b] = [mouth([20.0, 32.0], -20.0), mouth([44.0, 32.0], 200.0)];
        let straight = features_of(&a, &b, 64);
        (a.curvature, b.curvature) = (0.028, -0.028);
        let arc = features_of(&a, &b, 64);
        assert!(cost(&arc) < cost(&straight), "{arc:?} {straight:?}");
        (a.curvature, b.curvature) = (-0.028, 0.028);
        let against = features_of(&a, &b, 64);
        assert!(cost(&against) > cost(&straight), "{against:?}");
    }
}
