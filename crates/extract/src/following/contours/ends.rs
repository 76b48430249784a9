//! Where a rope ends: at a tip, or where it leaves the image.

use super::edge::{self, WINDOW};
use super::rope::Rope;
use crate::image::ray::LANES;
use crate::image::{Image, color};
use crate::vec2::{self, Vec2};

/// A tip may move so far along the rope from one frame to the next, in widths, and as far it may be from where it is sought.
const TIP_WIDTHS: f32 = 0.75;
/// The rope runs on to where it leaves the image for so many widths at most.
const ON_WIDTHS: f32 = 1.5;
/// The rope runs on to its tip as it bends over twice this way, in widths, before it; for no longer than this way, and no
/// sharper than so many radians over it.
const BEFORE_TIP: f32 = 1.0;
const RUNS_ON: f32 = 1.5;
const SHARPEST: f32 = 0.8;
/// Widths before where it leaves the image that may go unread.
const UNREAD_WIDTHS: f32 = 2.0;

/// Where across a rope its tip is read, in widths from the middle.
const ACROSS: [f32; 3] = [-0.2, 0.0, 0.2];

/// An end of a rope.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct End {
    /// Whether the rope leaves the image there.
    pub(super) is_border: bool,
    /// Whether another strand lies at a tip or something covers it, so that it does not show; whether neither is any longer; and
    /// whether it was so when the rope was extracted.
    pub(super) is_against: bool,
    pub(super) has_left: bool,
    pub(super) was_against: bool,
    /// How far beyond a tip's true place its edge reads; nothing where it does not.
    pub(super) beyond_px: Option<f32>,
    /// How far beside the way that the rope runs on to it a tip lies.
    pub(super) aside_px: f32,
}

impl End {
    /// Whether it does not show, and nothing is there that would hide it.
    pub(super) fn is_unseen(&self) -> bool {
        !self.is_border && !self.is_against && self.beyond_px.is_none()
    }
}

impl Rope {
    /// How far the rope runs on beyond its first and its last station in the next frame, or ends before; nothing where they
    /// have jumped.
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
                // It has come off: where it ends is seen again.
                if known.has_left {
                    return None;
                }
            } else if let Some(beyond_px) = known.beyond_px
                && !known.is_against
                && self.out_within(image, end).is_some()
            {
                // A tip that no longer reads has jumped farther than it is looked for.
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
        // What is not seen of it is as long as it was, by the same measure: by another one it would grow from frame to frame.
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

    /// Moves the stations of the next frame before a tip that are not read by that share of their way to the arc that those
    /// after them lie on.
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
            // The chord to a point on a circle lies half the angle off the tangent.
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

    /// The `i`-th station of the next frame from an end.
    fn place(&self, end: usize, i: usize) -> usize {
        if end == 0 { i } else { self.next.len() - 1 - i }
    }

    /// The number of the station at an end, and the way that the rope runs out there.
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

    /// The way out of the rope at an end, if the window in which its tip is read lies within the image.
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

    /// How far beyond the last station at an end the rope's tip reads.
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

    /// How far it is from the last station at an end to the image's border, less than nothing from beyond it.
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
        // To where a way leaves the image.
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
