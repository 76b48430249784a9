//! Ends of a rope: at a tip, or where it leaves the image.

use super::edge::{self, WINDOW};
use super::rope::Rope;
use crate::image::ray::LANES;
use crate::image::{Image, color};
use crate::vec2::{self, Vec2};

/// Maximum movement of a tip along the rope from one frame to the next, in widths.
const TIP_WIDTHS: f32 = 0.75;
/// Maximum extrapolation to where the rope leaves the image, in widths.
const ON_WIDTHS: f32 = 1.5;
/// Length before a tip, in widths, over which the bend is measured, twice, to extrapolate to the
/// tip.
const BEFORE_TIP: f32 = 1.0;
/// Maximum length of the extrapolation, in widths.
const RUNS_ON: f32 = 1.5;
/// Maximum bend of the extrapolation, in radians over `BEFORE_TIP`.
const SHARPEST: f32 = 0.8;
/// Maximum unread length before the rope leaves the image, in widths.
const UNREAD_WIDTHS: f32 = 2.0;

/// Positions across a rope at which its tip is read, in widths from the middle.
const ACROSS: [f32; 3] = [-0.2, 0.0, 0.2];

/// An end of a rope.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct End {
    /// True if the rope leaves the image there.
    pub(super) is_border: bool,
    /// True if another strand is at the tip or something covers it, so that it does not show.
    pub(super) is_against: bool,
    /// True if no strand or cover is at the tip any longer, by some margin.
    pub(super) has_left: bool,
    /// True if `is_against` was set in the reference image.
    pub(super) was_against: bool,
    /// Distance beyond a tip's true place at which its edge is read. `None` if it is not read.
    pub(super) beyond_px: Option<f32>,
    /// Sideways distance of a tip from its extrapolation.
    pub(super) aside_px: f32,
}

impl End {
    /// Returns whether the tip is missing although nothing would hide it.
    pub(super) fn is_unseen(&self) -> bool {
        !self.is_border && !self.is_against && self.beyond_px.is_none()
    }
}

impl Rope {
    /// Distances that the rope extends beyond its first and its last station in the next frame,
    /// negative if it ends before. `None` if an end jumped or was uncovered.
    ///
    /// A visible tip or the image's border determines an end. If neither end is at the border,
    /// hidden ends follow from the rope's length. If one is, hidden ends stay.
    pub(super) fn find_ends(&mut self, image: &Image) -> Option<[f32; 2]> {
        if self.closed {
            return Some([0.0; 2]);
        }
        let mut found = [None; 2];
        for (end, found) in found.iter_mut().enumerate() {
            let known = &self.ends[end];
            if known.is_border {
                *found = Some(self.to_border(image, end)?);
            } else if known.was_against {
                // The obstacle has gone, so the tip is visible again.
                if known.has_left {
                    return None;
                }
            } else if let Some(beyond_px) = known.beyond_px
                && !known.is_against
                && self.out_within(image, end).is_some()
            {
                // A tip that is no longer read has jumped beyond the search range.
                let far_px = self.tip(image, end)? - beyond_px;
                if far_px.abs() > TIP_WIDTHS * self.width_px {
                    return None;
                }
                *found = Some(far_px);
            }
        }
        let leaves = self.ends.iter().any(|end| end.is_border);
        if leaves || found.iter().all(Option::is_some) {
            return Some(found.map(|far_px| far_px.unwrap_or(0.0)));
        }
        // The rope keeps its length if an end is hidden. Both lengths use the same measure, since
        // another one would make it grow from frame to frame.
        let places = self.next.iter().map(|station| station.at);
        let missing_px = self.length_px - self.lay.measure(places);
        let most_px = TIP_WIDTHS * self.width_px;
        let rest = |px: f32| px.clamp(-most_px, most_px);
        Some(match found {
            [Some(first), _] => [first, rest(missing_px - first)],
            [None, Some(last)] => [rest(missing_px - last), last],
            [None, None] => [rest(0.5 * missing_px); 2],
        })
    }

    /// Moves unread stations before a tip, in the next frame, toward the arc through those after
    /// them. `pace` is the share of the distance.
    pub(super) fn run_on(&mut self, pace: f32) {
        for end in 0..2 {
            if self.closed || self.ends[end].is_border {
                continue;
            }
            let n = self.next.len();
            let read = |i: usize| self.next[self.place(end, i)].edges > 0;
            let back =
                ((BEFORE_TIP * self.width_px / self.spacing_px()).round() as usize).clamp(1, n / 4);
            let Some(unread) = (0..n - 2 * back).find(|&i| read(i)) else {
                continue;
            };
            let way_px = unread as f32 * self.spacing_px();
            if way_px <= RUNS_ON * self.width_px && (unread..=unread + 2 * back).all(read) {
                self.lay_arc(end, [unread, back], pace);
            }
        }
    }

    fn lay_arc(&mut self, end: usize, [unread, back]: [usize; 2], pace: f32) {
        let at = |i: usize| self.next[self.place(end, i)].at;
        let here = at(unread);
        let new = vec2::sub(here, at(unread + back));
        let old = vec2::sub(at(unread + back), at(unread + 2 * back));
        let turn = vec2::angle(old, new).clamp(-SHARPEST, SHARPEST);
        let way_px = vec2::norm(new).max(0.1);
        let direction = vec2::unit_or(new, [1.0, 0.0]);
        let aside_px = self.ends[end].aside_px;
        for i in 0..unread {
            let far_px = (unread - i) as f32 * self.spacing_px();
            // The chord to a point on a circle is at half the angle from the tangent.
            let (sin, cos) = libm::sincosf(0.5 * turn * (1.0 + far_px / way_px));
            let across = vec2::normal(direction);
            let ahead = vec2::along(vec2::scale(direction, cos), across, sin);
            let share = far_px / (unread as f32 * self.spacing_px());
            let place = self.place(end, i);
            let arc = vec2::along(here, ahead, far_px);
            let arc = vec2::along(arc, across, share * aside_px);
            let carried = self.next[place].at;
            self.next[place].at = vec2::along(carried, vec2::sub(arc, carried), pace);
        }
    }

    /// Index of the `i`-th station of the next frame from an end.
    fn place(&self, end: usize, i: usize) -> usize {
        if end == 0 { i } else { self.next.len() - 1 - i }
    }

    /// Index of the station at an end, and the direction out of the rope there.
    pub(super) fn tip_and_way(&self, end: usize) -> (usize, Vec2) {
        let n = self.stations.len();
        let (tip, back) = if end == 0 {
            (0, 2.min(n - 1))
        } else {
            (n - 1, n.saturating_sub(3))
        };
        let way = vec2::sub(self.stations[tip].at, self.stations[back].at);
        (tip, vec2::unit_or(way, [1.0, 0.0]))
    }

    fn out(&self, end: usize) -> Vec2 {
        let back =
            ((0.5 * self.width_px / self.spacing_px()) as usize).clamp(1, self.next.len() / 4);
        let [tip, before] = [0, back].map(|i| self.next[self.place(end, i)].at);
        vec2::unit_or(vec2::sub(tip, before), [1.0, 0.0])
    }

    /// Direction out of the rope at an end, if the window for its tip is inside the image.
    fn out_within(&self, image: &Image, end: usize) -> Option<Vec2> {
        let at = self.next[self.place(end, 0)].at;
        let limits = [image.width(), image.height()].map(|side| (side - 1) as f32);
        let (out, half) = (self.out(end), (WINDOW / 2) as f32);
        let mut ends = [-half, half - 2.0]
            .map(|px| vec2::along(at, out, px))
            .into_iter();
        let is_within = ends.all(|at| (0..2).all(|c| (0.0..=limits[c]).contains(&at[c])));
        is_within.then_some(out)
    }

    /// Distance beyond the last station at an end at which the rope's tip is read.
    pub(super) fn tip(&self, image: &Image, end: usize) -> Option<f32> {
        let out = self.out_within(image, end)?;
        let (station, half) = (&self.next[self.place(end, 0)], (WINDOW / 2) as f32);
        let mut differences = [0; WINDOW];
        let across = vec2::normal(out);
        let cut = 0.5 * (station.cuts[0] + station.cuts[1]);
        for (k, differences) in differences
            .as_chunks_mut::<LANES>()
            .0
            .iter_mut()
            .enumerate()
        {
            let far_px = |l: usize| (LANES * k + l) as f32 - half;
            let mut sums = [0.0f32; LANES];
            for widths in ACROSS {
                let from = vec2::along(station.at, across, widths * station.width_px);
                let places = [0, 1].map(|c| std::array::from_fn(|l| from[c] + far_px(l) * out[c]));
                let colors = color::between_each(image, &places);
                for (l, sum) in sums.iter_mut().enumerate() {
                    let color = colors.map(|channel| channel[l]);
                    *sum += self.looks.distance(color, &station.color);
                }
            }
            for (difference, sum) in differences.iter_mut().zip(sums) {
                *difference = (sum / ACROSS.len() as f32) as u8;
            }
        }
        let cut = edge::cut(&differences, [half - self.width_px, half], cut);
        let found = edge::find(edge::ground(&differences, cut), &differences, half);
        found.map(|edge| edge.at - half)
    }

    /// Distance from the last station at an end to the image's border, negative from outside.
    fn to_border(&self, image: &Image, end: usize) -> Option<f32> {
        let limits = [image.width(), image.height()].map(|side| (side - 1) as f32);
        let inside = |at: Vec2| (0..2).all(|c| at[c] >= 0.0 && at[c] <= limits[c]);
        let at = |i: usize| self.next[self.place(end, i)].at;
        let read = |i: usize| self.next[self.place(end, i)].edges > 0;
        let n = self.next.len();
        let first = (0..n / 2).find(|&i| inside(at(i)))?;
        let unread = (first..n / 2).find(|&i| read(i))? - first;
        if unread as f32 * self.spacing_px() > UNREAD_WIDTHS * self.width_px {
            return None;
        }
        // Distance at which a direction leaves the image.
        let way_px = |from: Vec2, out: Vec2| {
            let sides = (0..2).map(|c| match out[c] {
                v if v > 1e-3 => (limits[c] - from[c]) / v,
                v if v < -1e-3 => -from[c] / v,
                _ => f32::INFINITY,
            });
            sides.fold(f32::INFINITY, f32::min)
        };
        if first == 0 {
            let way_px = way_px(at(0), self.out(end));
            return (way_px <= ON_WIDTHS * self.width_px + self.spacing_px()).then_some(way_px);
        }
        let before: f32 = (1..first).map(|i| vec2::distance(at(i - 1), at(i))).sum();
        let last_px = vec2::distance(at(first), at(first - 1)).max(0.1);
        let out = vec2::scale(vec2::sub(at(first - 1), at(first)), 1.0 / last_px);
        Some(-(before + last_px - way_px(at(first), out).min(last_px)))
    }
}
