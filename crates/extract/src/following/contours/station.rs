//! A point of a rope that is followed, and what is known of the rope there.

use super::looks::Middle;
use super::rope::Rope;
use crate::vec2::{self, Vec2};

/// How near the middles of two strands come, in their mean width, before they begin to cross.
const TOGETHER: f32 = 0.8;
/// Widths along a rope between two of its points that may come together.
pub(super) const APART_WIDTHS: f32 = 2.5;

/// A point of the curve.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Station {
    pub(super) at: Vec2,
    pub(super) normal: Vec2,
    pub(super) width_px: f32,
    /// Where its edges read along the normal, of which the first is negative.
    pub(super) edges_px: [f32; 2],
    /// The rope's color.
    pub(super) color: Middle,
    /// From which difference from that on it is ground, on either side.
    pub(super) cuts: [f32; 2],
    /// How far it moved aside in the last frame.
    pub(super) aside_px: f32,
    /// By how many of its edges it was read.
    pub(super) edges: u8,
    /// Whether an edge could be read here when the rope was extracted.
    pub(super) is_clear: bool,
    /// Whether a strand that crosses here covers its edges.
    pub(super) is_crossed: bool,
    /// Whether something covers it.
    pub(super) is_hidden: bool,
}

/// The directions across the curve.
pub(super) fn set_normals(stations: &mut [Station], closed: bool) {
    let n = stations.len();
    for i in 0..n {
        let (a, b) = match closed {
            true => ((i + n - 1) % n, (i + 1) % n),
            false => (i.saturating_sub(1), (i + 1).min(n - 1)),
        };
        let tangent = vec2::sub(stations[b].at, stations[a].at);
        stations[i].normal = vec2::normal(vec2::unit_or(tangent, [1.0, 0.0]));
    }
}

/// Whether strands have come to lie on each other where they did not cross: their edges are then no longer their own.
pub(super) fn come_together(ropes: &[Rope]) -> bool {
    ropes.iter().enumerate().any(|(r, rope)| {
        let apart = (APART_WIDTHS * rope.width_px / rope.spacing_px()) as usize + 1;
        let is_doubtful = |station: &Station| station.edges < 2 && !station.is_crossed;
        let mut places = (rope.next.iter().enumerate()).filter(|(_, here)| is_doubtful(here));
        places.any(|(i, here)| {
            ropes.iter().enumerate().any(|(o, other)| {
                let reach_px = 0.5 * TOGETHER * (rope.width_px + other.width_px);
                let (all, n) = (&other.next, other.next.len());
                (0..n).step_by(2).any(|j| {
                    let off = vec2::sub(all[j].at, here.at);
                    if vec2::dot(off, off) >= reach_px * reach_px || all[j].is_crossed {
                        return false;
                    }
                    let mut between = i.abs_diff(j);
                    if rope.closed {
                        between = between.min(n.abs_diff(between));
                    }
                    r != o || between > apart
                })
            })
        })
    })
}
