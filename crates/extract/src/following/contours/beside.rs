//! Finds edges of a rope that are too close to another strand to be distinguished from its edges.

use super::ends::End;
use super::rope::Rope;
use super::station::{APART_WIDTHS, Station};
use crate::following::axis;
use crate::vec2::{self, Vec2};

/// Minimum ground between an edge and another strand for the edge to be read, in pixels.
const GAP_PX: f32 = 2.0;
/// Distances beyond a tip at which another strand hides it, in pixels.
const BEYOND_PX: [f32; 3] = [0.0, 3.0, 6.0];
/// Minimum additional distance of a strand that has left the tip, in pixels.
const OFF_PX: f32 = 3.0;
/// Number of consecutive stations that are skipped if the middle one is far away.
const SOME: usize = 8;

/// Determines which edges of the ropes show, and at which ends another strand is.
pub(super) fn note_neighbors(ropes: &mut [Rope]) {
    for r in 0..ropes.len() {
        let mut shown = std::mem::take(&mut ropes[r].shown);
        shown.clear();
        for (i, station) in ropes[r].stations.iter().enumerate() {
            let axis = axis(station.normal);
            let out_px = station.edges_px.map(|px| px / station.normal[axis]);
            let farthest_px = out_px[0].abs().max(out_px[1].abs());
            // Mostly, no strand is near either edge.
            if !is_near(ropes, (r, i), station.at, farthest_px + GAP_PX) {
                shown.push([true; 2]);
                continue;
            }
            shown.push(out_px.map(|px| {
                let mut edge = station.at;
                edge[axis] += px;
                !is_near(ropes, (r, i), edge, GAP_PX)
            }));
        }
        ropes[r].shown = shown;
        for end in 0..2 {
            let rope = &ropes[r];
            let (tip, out) = rope.tip_and_way(end);
            let station = &rope.stations[tip];
            let is_by = |gap_px: f32| {
                let beyond = |px: &f32| vec2::along(station.at, out, *px);
                (BEYOND_PX.iter()).any(|px| is_near(ropes, (r, tip), beyond(px), gap_px))
            };
            let is_veiled = station.is_crossed || station.is_hidden;
            let is_against = is_veiled || is_by(GAP_PX);
            let has_left = !is_against && !is_by(GAP_PX + OFF_PX);
            let end = &mut ropes[r].ends[end];
            (end.is_against, end.has_left) = (is_against, has_left);
        }
    }
}

impl Rope {
    /// Returns whether nothing fixes the rope's position along itself. This is so if one end does
    /// not show, and the other end does not show or is outside of the image. It is also so if an
    /// end does not show and a part of unknown length is hidden.
    pub(super) fn may_slide(&self) -> bool {
        let [a, b] = &self.ends;
        let is_one = |a: &End, b: &End| a.is_against && (b.is_against || b.is_border);
        let is_loose = self.was_hidden && (a.is_against || b.is_against);
        !self.closed && (is_one(a, b) || is_one(b, a) || is_loose)
    }

    /// Returns whether another strand is along the rope or at one of its ends.
    pub(super) fn touches(&self) -> bool {
        let mut places = self.stations.iter().zip(&self.shown);
        let is_by = |end: &End| !end.is_border && end.is_against;
        !self.closed && self.ends.iter().any(is_by)
            || places.any(|(station, shown)| !station.is_crossed && shown.contains(&false))
    }
}

/// Returns whether a strand is within `gap_px` of a place near station `i` of rope `r`. Parts of
/// the same rope that are near along it do not count.
fn is_near(ropes: &[Rope], (r, i): (usize, usize), place: Vec2, gap_px: f32) -> bool {
    ropes.iter().enumerate().any(|(o, other)| {
        let (n, spacing_px) = (other.stations.len(), other.spacing_px());
        let apart = (APART_WIDTHS * other.width_px / spacing_px) as usize + 1;
        let reach_px = 0.5 * other.width_px + gap_px + 0.25 * spacing_px;
        let is_within = |station: &Station, px: f32| {
            let off = vec2::sub(station.at, place);
            vec2::dot(off, off) < px * px
        };
        let counts = |j: usize| {
            let between = i.abs_diff(j);
            let around = if other.closed { n - between.min(n) } else { n };
            o != r || between.min(around) > apart
        };
        // Checks the middle of several stations first, and each of them only if that is near.
        let some_px = reach_px + (SOME / 2 + 1) as f32 * spacing_px;
        let mut all = other.stations.chunks(SOME).enumerate();
        all.any(|(k, some)| {
            is_within(&some[some.len() / 2], some_px)
                && (some.iter().enumerate())
                    .any(|(l, station)| is_within(station, reach_px) && counts(SOME * k + l))
        })
    })
}
