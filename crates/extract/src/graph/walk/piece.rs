//! A connected piece of the skeleton that may be one rope, or a few: its edges, and the costs of
//! going from one to another.
//!
//! A walk takes an edge as a leg, which is a single strand, or passes over it, as one of several
//! strands. An edge is wide if it looks like more than one strand. Passing over a wide edge and
//! taking a narrow one as a leg are free.

use crate::bitmap::bits::BitPlane;
use crate::graph::Graph;
use crate::graph::arm::Arm;
use crate::graph::pairing::bending_of;
use crate::graph::zones::Zones;
use crate::skeleton::{NONE, Skeleton};
use crate::vec2;

/// Maximum number of edges of a piece. A larger one is not just a few ropes.
pub(super) const MOST_EDGES: usize = 96;
/// Maximum number of tips of a piece.
const MOST_TIPS: usize = 6;
/// Maximum number of pieces.
pub(super) const MOST_PIECES: usize = 8;
/// Maximum number of ways from one end to another, in all.
const MOST_ONWARD: usize = 8192;
/// Maximum number of edges passed in a row.
const MOST_PASSES: usize = 6;
/// Maximum length of edges passed in a row, in widths.
const LONGEST_PASS: f32 = 14.0;
/// Upper bound on the cost of edges passed in a row.
const DEAREST_PASS: f32 = 1.0;
/// Maximum length of a way over passed edges, relative to its chord, plus a width. It allows an arc
/// of two fifths of a turn.
const DETOUR: f32 = 1.3;
/// Minimum mean half-width of a wide edge, that is, of more than one strand: a factor of the usual
/// half-width, plus pixels for whole-pixel doubt.
const WIDE: (f32, f32) = (1.25, 0.2);
/// Minimum number of wide edges of a rope that is wound up: three loops have eight wide edges, five
/// crossings have five.
const WOUND: usize = 7;
/// Cost per width of passing over a narrow edge.
const NARROW_PASS: f32 = 0.15;
/// Cost per width, plus half a width, of taking a wide edge as a leg, in a piece of one rope and of
/// several.
const WIDE_LEG: [f32; 2] = [0.25, 0.05];
/// Cost per width of leaving out an edge.
const LEFT_OUT: f32 = 0.3;
/// Cost per width of running only once over a wide edge, in a piece of several ropes.
const HALF_LEFT_OUT: f32 = 0.15;
/// Cost per width of a joint outside of the mask.
const OUTSIDE: f32 = 0.5;
/// Share of a joint's bending that counts in full. The rest counts only as far as it exceeds the
/// bending of the arc given by the strands' curvatures.
const ALL_BENDING: f32 = 0.25;
/// Length over which a strand's curvature is measured, and minimum length of a strand for this, in
/// half-widths.
const CURVED: (f32, f32) = (9.0, 4.0);

/// Data for judging a piece.
#[derive(Clone, Copy)]
pub(super) struct Ground<'a> {
    pub(super) graph: &'a Graph,
    pub(super) skeleton: &'a Skeleton,
    pub(super) zones: &'a Zones,
    pub(super) mask: &'a BitPlane,
}

/// An end of an edge, as a strand that comes out of a crossing.
#[derive(Clone, Copy, Debug)]
struct Mouth {
    arm: Arm,
    /// Curvature of the strand toward the crossing, in radians per pixel.
    curvature: f32,
}

/// A way from an end of an edge to the next leg: the end at which that leg starts, the cost
/// including the leg's own, and the edges passed on the way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Onward {
    pub(super) slot: u32,
    pub(super) cost: f32,
    pub(super) passed: u128,
}

/// A connected set of edges. Ends of edges are named by 2·edge + end.
#[derive(Debug, Default)]
pub(super) struct Component {
    /// Ends of edges at each node, node by node. `from` holds each node's start.
    slots: Vec<u32>,
    from: Vec<u32>,
    /// For each edge, the first edge of its piece.
    first: Vec<u32>,
    waiting: Vec<u32>,
    /// First edges of the pieces that may be a few ropes.
    pub(super) candidates: Vec<u32>,
    /// Edges of the current piece. For each edge of the graph, `place` is its index here, or
    /// `NONE`.
    pub(super) edges: Vec<u32>,
    place: Vec<u32>,
    /// Ends of the piece's edges that are tips.
    pub(super) tips: Vec<u32>,
    mouths: Vec<Mouth>,
    is_wide: Vec<bool>,
    /// Cost of each edge if it is run over never, once, or more often.
    left_out: Vec<[f32; 3]>,
    /// Ways from each end, end by end. `onward_from` holds each end's start.
    onward: Vec<Onward>,
    onward_from: Vec<u32>,
    /// For each end, index in `onward` of the way to it from the current end.
    reached: Vec<u32>,
}

impl Component {
    pub(super) fn reserve(&mut self) {
        self.candidates.reserve(MOST_PIECES);
        self.edges.reserve(MOST_EDGES);
        self.tips.reserve(MOST_TIPS);
        self.mouths.reserve(2 * MOST_EDGES);
        self.is_wide.reserve(MOST_EDGES);
        self.left_out.reserve(MOST_EDGES);
        self.onward.reserve(MOST_ONWARD);
        self.onward_from.reserve(2 * MOST_EDGES + 1);
        self.reached.reserve(2 * MOST_EDGES);
        for edges in [&mut self.first, &mut self.place, &mut self.waiting] {
            edges.reserve(1024);
        }
        for nodes in [&mut self.from, &mut self.slots] {
            nodes.reserve(2048);
        }
    }

    /// Lists the connected pieces of 2 to `MOST_TIPS` tips and 4 to `MOST_EDGES` edges. With fewer
    /// edges, the pairing cannot go wrong.
    pub(super) fn find(&mut self, graph: &Graph) {
        self.list_slots(graph);
        self.candidates.clear();
        self.first.clear();
        self.first.resize(graph.edges.len(), NONE);
        for e in 0..graph.edges.len() {
            if graph.edges[e].nodes[0] == NONE || self.first[e] != NONE {
                continue;
            }
            let (mut edges, mut tips) = (0, 0);
            self.first[e] = e as u32;
            self.waiting.clear();
            self.waiting.push(e as u32);
            while let Some(edge) = self.waiting.pop() {
                edges += 1;
                for node in graph.edges[edge as usize].nodes {
                    tips += usize::from(graph.nodes[node as usize].degree == 1);
                    for k in self.at(node) {
                        let other = self.slots[k] / 2;
                        if self.first[other as usize] == NONE {
                            self.first[other as usize] = e as u32;
                            self.waiting.push(other);
                        }
                    }
                }
            }
            let may_be = (2..=MOST_TIPS).contains(&tips) && (4..=MOST_EDGES).contains(&edges);
            if may_be && self.candidates.len() < MOST_PIECES {
                self.candidates.push(e as u32);
            }
        }
    }

    fn list_slots(&mut self, graph: &Graph) {
        self.from.clear();
        self.from.resize(graph.nodes.len() + 1, 0);
        let edges = || graph.edges.iter().enumerate();
        let joined = || edges().filter(|(_, edge)| edge.nodes[0] != NONE);
        for node in joined().flat_map(|(_, edge)| edge.nodes) {
            self.from[node as usize] += 1;
        }
        // These are the ends of each node's range. The ranges are filled from the back.
        for n in 1..self.from.len() {
            self.from[n] += self.from[n - 1];
        }
        let all = self.from.last().map_or(0, |&all| all as usize);
        self.slots.clear();
        self.slots.resize(all, NONE);
        for (e, edge) in joined() {
            for (end, &node) in edge.nodes.iter().enumerate() {
                self.from[node as usize] -= 1;
                self.slots[self.from[node as usize] as usize] = (2 * e + end) as u32;
            }
        }
    }

    fn at(&self, node: u32) -> std::ops::Range<usize> {
        self.from[node as usize] as usize..self.from[node as usize + 1] as usize
    }

    /// Reads the edges of a piece, and the costs of all ways between them.
    pub(super) fn gather(&mut self, first: u32, of: Ground) {
        let (graph, zones) = (of.graph, of.zones);
        self.edges.clear();
        self.mouths.clear();
        self.is_wide.clear();
        self.tips.clear();
        self.place.clear();
        self.place.resize(graph.edges.len(), NONE);
        for e in first as usize..graph.edges.len() {
            if self.first[e] != first {
                continue;
            }
            self.place[e] = self.edges.len() as u32;
            self.edges.push(e as u32);
            let ends = [2 * e as u32, 2 * e as u32 + 1];
            let tips = ends.into_iter().filter(|&slot| is_tip(slot, graph));
            self.tips.extend(tips);
            (0..2).for_each(|end| self.mouths.push(mouth(e, end, of)));
            let pixels = graph.pixels(e);
            let half = |&p: &u32| of.skeleton.pixels[p as usize].half_px;
            let mean_px = pixels.iter().map(half).sum::<f32>() / pixels.len() as f32;
            let is_wide = mean_px > WIDE.0 * zones.half_px + WIDE.1;
            self.is_wide.push(is_wide || zones.inside[e]);
        }
        self.left_out.clear();
        for (k, &e) in self.edges.iter().enumerate() {
            let is_two = self.is_wide[k] && self.is_several();
            let once = if is_two { HALF_LEFT_OUT } else { 0.0 };
            let widths = self.widths(e, of);
            self.left_out.push([LEFT_OUT * widths, once * widths, 0.0]);
        }
        self.find_onward(of);
    }

    /// Finds the cheapest way from each end to each other end that it reaches.
    fn find_onward(&mut self, of: Ground) {
        let mut onward = std::mem::take(&mut self.onward);
        let mut reached = std::mem::take(&mut self.reached);
        onward.clear();
        reached.clear();
        reached.resize(2 * self.edges.len(), NONE);
        self.onward_from.clear();
        for k in 0..2 * self.edges.len() {
            let from = onward.len();
            self.onward_from.push(from as u32);
            let slot = 2 * self.edges[k / 2] + (k % 2) as u32;
            let at = self.mouths[k].arm.at;
            self.pass(slot, Pass::default(), of, &mut |to, pass| {
                let straight_px = vec2::distance(at, self.mouth(to).arm.at);
                if pass.widths > DETOUR * straight_px / (2.0 * of.zones.half_px) + 1.0 {
                    return;
                }
                let new = Onward {
                    slot: to,
                    cost: pass.cost,
                    passed: pass.passed,
                };
                let known = &mut reached[self.local(to)];
                if let Some(old) = onward.get_mut(*known as usize) {
                    if new.cost < old.cost {
                        *old = new;
                    }
                } else if onward.len() < MOST_ONWARD {
                    *known = onward.len() as u32;
                    onward.push(new);
                }
            });
            for way in &mut onward[from..] {
                reached[self.local(way.slot)] = NONE;
                way.cost += self.joint(slot, way.slot, of.mask) + self.costs(way.slot / 2, of)[1];
            }
        }
        self.onward_from.push(onward.len() as u32);
        (self.onward, self.reached) = (onward, reached);
    }

    /// Ways from the end `slot`.
    pub(super) fn onward(&self, slot: u32) -> &[Onward] {
        let k = self.local(slot);
        &self.onward[self.onward_from[k] as usize..self.onward_from[k + 1] as usize]
    }

    /// Index of an end among those of the piece.
    fn local(&self, slot: u32) -> usize {
        2 * self.place[slot as usize / 2] as usize + slot as usize % 2
    }

    /// Bit of an edge of the piece in a bit set, or `None` for other edges.
    pub(super) fn bit(&self, edge: u32) -> Option<u128> {
        let place = self.place[edge as usize];
        (place != NONE).then(|| 1 << place)
    }

    /// Returns whether the piece has more tips than one rope.
    fn is_several(&self) -> bool {
        self.tips.len() > 2
    }

    /// Returns whether strands overlap in as many places as in a rope that is wound up.
    pub(super) fn is_wound(&self) -> bool {
        self.is_wide.iter().filter(|&&is_wide| is_wide).count() >= WOUND
    }

    /// Returns whether a strand at a tip is as wide as overlaps are. Widths then do not show which
    /// edges are several strands.
    pub(super) fn has_wide_tip(&self) -> bool {
        let place = |slot: &u32| self.place[*slot as usize / 2] as usize;
        self.tips.iter().any(|slot| self.is_wide[place(slot)])
    }

    /// Number of pixels at an end of an edge that belong to the crossing there.
    pub(super) fn trim(&self, slot: u32) -> u32 {
        self.mouth(slot).arm.trim
    }

    fn mouth(&self, slot: u32) -> &Mouth {
        &self.mouths[self.local(slot)]
    }

    /// Cost of continuing from one end of an edge to another: bending, difference in width, and the
    /// part outside of the mask.
    fn joint(&self, from: u32, to: u32, mask: &BitPlane) -> f32 {
        let (a, b) = (self.mouth(from), self.mouth(to));
        let chord = vec2::sub(b.arm.at, a.arm.at);
        let px = vec2::norm(chord);
        let chord = vec2::unit_or(chord, a.arm.into);
        let alpha = vec2::angle(chord, a.arm.into);
        let beta = vec2::angle(chord, vec2::scale(b.arm.into, -1.0));
        // Half the turn of an arc with the mean of both curvatures. The curvature of b is negated,
        // because the strand runs out of b.
        let turn = 0.25 * px * (a.curvature - b.curvature);
        let (wa, wb) = (a.arm.half_px, b.arm.half_px);
        let width = (wa - wb) / (wa + wb);
        ALL_BENDING * bending_of(alpha, beta)
            + (1.0 - ALL_BENDING) * bending_of(alpha + turn, beta - turn)
            + width * width * (wa + wb).min(10.0) / 10.0
            + OUTSIDE * px * outside(&a.arm, &b.arm, px, mask) / (wa + wb)
    }

    /// Length of an edge, in widths.
    pub(super) fn widths(&self, e: u32, of: Ground) -> f32 {
        of.graph.edges[e as usize].length_px / (2.0 * of.zones.half_px)
    }

    /// Cost of passing over an edge, and of taking it as a leg.
    pub(super) fn costs(&self, e: u32, of: Ground) -> [f32; 2] {
        let widths = self.widths(e, of);
        match self.is_wide[self.place[e as usize] as usize] {
            true => [
                0.0,
                WIDE_LEG[usize::from(self.is_several())] * (0.5 + widths),
            ],
            false => [NARROW_PASS * widths, 0.0],
        }
    }

    /// Cost of the edges that are left out, wholly or by one of their strands.
    pub(super) fn left_out(&self, seen: &Visited) -> f32 {
        let edges = self.left_out.iter().enumerate();
        edges.map(|(k, costs)| costs[seen.times(k)]).sum()
    }

    /// Calls `reach` with each end at which a strand that leaves at `last` can continue, and with
    /// the edges passed on the way.
    fn pass(&self, last: u32, so_far: Pass, of: Ground, reach: &mut impl FnMut(u32, Pass)) {
        for k in self.at(node(last, of.graph)) {
            let slot = self.slots[k];
            if slot == last {
                continue;
            }
            reach(slot, so_far);
            let bit = 1 << self.place[slot as usize / 2];
            let further = Pass {
                cost: so_far.cost + self.costs(slot / 2, of)[0],
                widths: so_far.widths + self.widths(slot / 2, of),
                count: so_far.count + 1,
                passed: so_far.passed | bit,
            };
            let is_short = further.count <= MOST_PASSES && further.widths <= LONGEST_PASS;
            let is_new = so_far.passed & bit == 0 && !is_tip(slot ^ 1, of.graph);
            if is_short && is_new && further.cost < DEAREST_PASS {
                self.pass(slot ^ 1, further, of, reach);
            }
        }
    }
}

/// Bit sets of the edges of a walk: those taken as legs, those passed, and those passed again.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Visited {
    pub(super) used: u128,
    passed: u128,
    again: u128,
}

impl Visited {
    pub(super) fn pass(&mut self, edges: u128) {
        self.again |= self.passed & edges;
        self.passed |= edges;
    }

    /// Number of times that edge `k` of the piece is run over, at most 2.
    fn times(&self, k: usize) -> usize {
        let seen = [self.used, self.passed, self.again].map(|edges| (edges >> k) as usize & 1);
        seen.iter().sum::<usize>().min(2)
    }
}

/// Edges passed on a way, and their cost.
#[derive(Clone, Copy, Default)]
struct Pass {
    cost: f32,
    widths: f32,
    count: usize,
    passed: u128,
}

/// Returns whether an end of an edge is a tip.
pub(super) fn is_tip(slot: u32, graph: &Graph) -> bool {
    graph.nodes[node(slot, graph) as usize].degree == 1
}

/// Node at an end of an edge.
fn node(slot: u32, graph: &Graph) -> u32 {
    graph.edges[slot as usize / 2].nodes[slot as usize % 2]
}

/// Share of the way from one arm to another that is outside of the mask. The way is the cubic that
/// leaves both arms in their own directions.
fn outside(a: &Arm, b: &Arm, px: f32, mask: &BitPlane) -> f32 {
    const ASKED: usize = 8;
    let out = (1..ASKED).filter(|&k| {
        let t = k as f32 / ASKED as f32;
        let (s, u) = (t * t * (3.0 - 2.0 * t), 1.0 - t);
        let straight = vec2::along(a.at, vec2::sub(b.at, a.at), s);
        let leaving = vec2::along(straight, a.into, px * t * u * u);
        let [x, y] = vec2::along(leaving, b.into, px * t * t * u);
        !mask.get(x as i32, y as i32)
    });
    out.count() as f32 / (ASKED - 1) as f32
}

/// Measures one end of an edge.
fn mouth(e: usize, end: u8, of: Ground) -> Mouth {
    let arm = of.zones.arm(e, end, 0, of.graph, of.skeleton);
    let pixels = of.graph.pixels(e);
    let at = |i: usize| {
        let i = if end == 0 { i } else { pixels.len() - 1 - i };
        of.skeleton.pixels[pixels[i] as usize].at()
    };
    let from = arm.trim as usize;
    let to = (from + (CURVED.0 * arm.half_px) as usize).min(pixels.len() - 1);
    if ((to - from) as f32) < CURVED.1 * arm.half_px {
        let curvature = 0.0;
        return Mouth { arm, curvature };
    }
    let middle = (from + to) / 2;
    let halves = [
        vec2::sub(at(middle), at(to)),
        vec2::sub(at(from), at(middle)),
    ];
    let px = 0.5 * (vec2::norm(halves[0]) + vec2::norm(halves[1]));
    let curvature = vec2::angle(halves[0], halves[1]) / px.max(1.0);
    // The fitted line has the arc's direction in the middle of the fit, so it is turned to the
    // direction at the arc's end.
    let reach_px = arm.reach_px().min(pixels.len() - from) as f32;
    let (sin, cos) = libm::sincosf(0.5 * curvature * reach_px);
    let [x, y] = arm.into;
    let into = [cos * x - sin * y, sin * x + cos * y];
    let arm = Arm { into, ..arm };
    Mouth { arm, curvature }
}
