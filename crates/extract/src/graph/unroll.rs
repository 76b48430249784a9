//! A long overlap, laid straight. This separates the bending of its arms against it from the common
//! bending of both strands.

use super::Graph;
use super::arm::Arm;
use super::necks::Necks;
use crate::skeleton::Skeleton;
use crate::vec2::{self, Vec2};

/// Minimum length of an overlap, in half-widths. In a shorter one, strands that cross at more than
/// 67° are as wide as strands side by side (see `zones`).
const SHORTEST_HALVES: f32 = 1.5;

/// Minimum length of an overlap whose sides are certain, in half-widths.
const SURE_HALVES: f32 = 6.0;

/// The rigid motion that lays the far end of an overlap straight ahead of its near end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Unroll {
    from: Vec2,
    from_tangent: Vec2,
    to: Vec2,
    to_tangent: Vec2,
    length_px: f32,
    /// True if the strands change sides an even number of times (mostly zero), `None` if unknown.
    keeps_sides: Option<bool>,
    /// Certainty of `keeps_sides`, from 0 to 1. In a short overlap it may depend on a single pixel.
    sureness: f32,
}

impl Unroll {
    /// The motion for edge `e`, from its first node to its second, or `None` if the edge is too
    /// short.
    pub(crate) fn of(e: usize, graph: &Graph, skeleton: &Skeleton, half_px: f32) -> Option<Self> {
        let length_px = graph.edges[e].length_px;
        if length_px < SHORTEST_HALVES * half_px {
            return None;
        }
        let pixels = graph.pixels(e);
        let at = |i: usize| skeleton.pixels[pixels[i] as usize].at();
        let last = pixels.len() - 1;
        let reach = ((3.0 * half_px) as usize).clamp(3, last.max(3)).min(last);
        let necks = Necks::of(e, graph, skeleton, half_px);
        Some(Self {
            sureness: (length_px / (SURE_HALVES * half_px)).min(1.0).sqrt(),
            keeps_sides: necks.are_known.then(|| necks.at().len().is_multiple_of(2)),
            from: at(0),
            from_tangent: vec2::unit_or(vec2::sub(at(reach), at(0)), [1.0, 0.0]),
            to: at(last),
            to_tangent: vec2::unit_or(vec2::sub(at(last), at(last - reach)), [1.0, 0.0]),
            length_px,
        })
    }

    /// Moves an arm of the far end, and sets its side.
    pub(crate) fn apply(&self, arm: &mut Arm) {
        let turn = |v: Vec2| {
            let (ahead, aside) = (
                vec2::dot(v, self.to_tangent),
                vec2::cross(self.to_tangent, v),
            );
            vec2::add(
                vec2::scale(self.from_tangent, ahead),
                vec2::scale(vec2::normal(self.from_tangent), aside),
            )
        };
        let end = vec2::along(self.from, self.from_tangent, self.length_px);
        arm.at = vec2::add(end, turn(vec2::sub(arm.at, self.to)));
        arm.into = turn(arm.into);
        self.note_side(arm, true);
    }

    /// Returns whether the strands are known to change sides in the overlap.
    pub(crate) fn changes_sides(&self) -> bool {
        self.keeps_sides == Some(false)
    }

    /// Sets the side of an arm of the near end.
    pub(crate) fn tell_side(&self, arm: &mut Arm) {
        self.note_side(arm, false);
    }

    /// Sets an arm's side. An arm of the (moved) far end gets the side that its strand has at the
    /// near end.
    fn note_side(&self, arm: &mut Arm, is_far: bool) {
        if let Some(keeps_sides) = self.keeps_sides {
            let side = vec2::cross(self.from_tangent, vec2::sub(arm.at, self.from)).signum();
            arm.side = self.sureness * if is_far && !keeps_sides { -side } else { side };
        }
    }
}
