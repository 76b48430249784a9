//! A point of a rope that is followed, and what is known of the rope there.

use super::looks::Middle;
use super::rope::Rope;
use crate::vec2::{self, Vec2};

/// Distance between the middles of two strands, in their mean width, below which they overlap.
const TOGETHER: f32 = 0.8;
/// Same distance, below which they cross.
const CROSS: f32 = 0.5;
/// Maximum growth of the overlapping part from one frame to the next, in points.
const CREEP: usize = 3;
/// Maximum sideways movement of ropes since the reference image, in widths, for their crossings to
/// be unchanged.
const STILL: f32 = 1.0;
/// Minimum length along a rope between two of its points that count as different strands, in
/// widths.
pub(super) const APART_WIDTHS: f32 = 2.5;

/// A point of the curve.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Station {
    pub(super) at: Vec2,
    pub(super) normal: Vec2,
    /// Position in the reference image.
    pub(super) from: Vec2,
    pub(super) width_px: f32,
    /// Positions of its edges along the normal. The first is negative.
    pub(super) edges_px: [f32; 2],
    /// Color of the rope.
    pub(super) color: Middle,
    /// Minimum difference from that color that is ground, on either side.
    pub(super) cuts: [f32; 2],
    /// Sideways movement in the last frame.
    pub(super) aside_px: f32,
    /// Number of edges that were read.
    pub(super) edges: u8,
    /// True if an edge could be read here in the reference image.
    pub(super) is_clear: bool,
    /// True if a crossing strand covers its edges.
    pub(super) is_crossed: bool,
    /// True if something covers it.
    pub(super) is_hidden: bool,
    /// True if it overlaps another strand without a known crossing here.
    pub(super) is_together: bool,
    /// True if that strand is near enough to cross.
    pub(super) is_on: bool,
}

/// Sets the directions across the curve.
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

/// Marks where strands overlap in the next frame. Returns whether they newly overlap or cross
/// somewhere, as their edges then mix. Crossings from the reference image are not new while all
/// ropes are about where they were then.
pub(super) fn come_together(ropes: &mut [Rope]) -> bool {
    let mut is_new = false;
    let is_still = ropes.iter().all(is_still);
    for r in 0..ropes.len() {
        for i in 0..ropes[r].next.len() {
            let here = &ropes[r].next[i];
            let is_doubtful = here.edges < 2 && !here.is_crossed;
            let widths = if is_doubtful {
                widths_to_another(ropes, (r, i))
            } else {
                f32::INFINITY
            };
            let is_together = widths < TOGETHER;
            let were = &ropes[r].stations;
            let around = i.saturating_sub(CREEP)..(i + CREEP + 1).min(were.len());
            let is_on = widths < CROSS;
            let is_known = match is_on {
                true => is_still && were[around].iter().any(|s| s.is_on),
                false => were[around].iter().any(|s| s.is_together),
            };
            is_new |= is_together && !is_known;
            let next = &mut ropes[r].next[i];
            (next.is_together, next.is_on) = (is_together, is_on);
        }
    }
    is_new
}

/// Returns whether no point of a rope has moved far aside since the reference image.
fn is_still(rope: &Rope) -> bool {
    let aside_px = |s: &Station| vec2::dot(vec2::sub(s.at, s.from), s.normal).abs();
    let most_px = STILL * rope.width_px;
    rope.next.iter().all(|station| aside_px(station) <= most_px)
}

/// Distance of a station of the next frame from the nearest strand, in their mean width.
fn widths_to_another(ropes: &[Rope], (r, i): (usize, usize)) -> f32 {
    let (rope, here) = (&ropes[r], &ropes[r].next[i]);
    let apart = (APART_WIDTHS * rope.width_px / rope.spacing_px()) as usize + 1;
    let mut least = f32::INFINITY;
    for (o, other) in ropes.iter().enumerate() {
        let n = other.next.len();
        let counts = |j: usize| {
            let between = i.abs_diff(j);
            let around = if rope.closed { n.abs_diff(between) } else { n };
            o != r || between.min(around) > apart
        };
        let places = other.next.iter().enumerate().step_by(2);
        for (_, there) in places.filter(|&(j, there)| !there.is_crossed && counts(j)) {
            let widths =
                vec2::distance(there.at, here.at) / (0.5 * (rope.width_px + other.width_px));
            least = least.min(widths);
        }
    }
    least
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two ropes along x without readable edges, which overlapped in the reference image. Both have
    /// since moved aside.
    fn on_each_other(aside_px: f32) -> [Rope; 2] {
        let rope = |y: f32| {
            let station = |i: u8| Station {
                at: [4.0 * f32::from(i), y],
                from: [4.0 * f32::from(i), y],
                normal: [0.0, 1.0],
                is_together: true,
                is_on: true,
                ..Station::default()
            };
            let stations: Vec<_> = (0..20).map(station).collect();
            let mut next = stations.clone();
            next.iter_mut()
                .for_each(|station| station.at[1] += aside_px);
            let mut rope = Rope::default();
            (rope.stations, rope.next) = (stations, next);
            (rope.width_px, rope.length_px) = (10.0, 76.0);
            rope
        };
        [rope(50.0), rope(53.0)]
    }

    #[test]
    fn ropes_on_each_other_are_looked_at_again_when_they_have_moved_aside_by_a_width() {
        assert!(!come_together(&mut on_each_other(0.0)));
        assert!(!come_together(&mut on_each_other(9.0)));
        assert!(come_together(&mut on_each_other(11.0)));
    }

    #[test]
    fn ropes_that_come_to_lie_on_each_other_are_looked_at_again() {
        let mut ropes = on_each_other(0.0);
        for station in ropes.iter_mut().flat_map(|rope| &mut rope.stations) {
            (station.is_together, station.is_on) = (false, false);
        }
        assert!(come_together(&mut ropes));
    }
}
