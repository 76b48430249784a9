//! Occluders over a rope between its tips, known from the reference image: their present extent,
//! and the rope's way under them.

use super::ends::End;
use super::learn::across;
use super::motion::Move;
use super::read::Measurement;
use super::rope::{LENGTH, Rope};
use crate::graph::bending;
use crate::image::{Image, color};
use crate::occlusion::way;
use crate::vec2;
use std::ops::Range;

/// Minimum color difference between an occluder and the rope, in levels, to tell them apart.
const TOLD: f32 = 12.0;
/// Maximum growth of the covered part, at each end, from one frame to the next, in widths.
const CREEP_WIDTHS: f32 = 1.5;
/// Length before a hidden part over which the rope's direction is measured, in widths.
const POINTS_WIDTHS: f32 = 1.0;
/// Maximum change in length of hidden parts, as a share of the rope. With a larger one, it is more
/// likely that the rope slid along itself.
const GIVEN: f32 = 0.5 * LENGTH;

impl Rope {
    /// Finds how much of the rope its occluders cover in the next frame. Edges read there are
    /// theirs and are dropped.
    pub(super) fn find_cover(&mut self, image: &Image) {
        if !self.was_hidden {
            return;
        }
        let (n, mut from) = (self.next.len(), 0);
        while let Some(first) = (from..n).find(|&i| self.stations[i].is_hidden) {
            from = (first..n)
                .find(|&i| !self.stations[i].is_hidden)
                .unwrap_or(n);
            for i in self.reach_of_cover(image, first..from) {
                self.readings[i] = Measurement {
                    is_covered: true,
                    ..Measurement::default()
                };
            }
        }
    }

    /// Extent of an occluder, searched outward from the middle of the part that was hidden. A
    /// station is covered if its color is nearer to the occluder's than to the rope's, or if it is
    /// outside of the image.
    fn reach_of_cover(&self, image: &Image, was: Range<usize>) -> Range<usize> {
        let yuv = color::is_yuv(image.format());
        let limits = [image.width(), image.height()].map(|side| (side - 1) as f32);
        let is_out = |i: usize| {
            let at = self.next[i].at;
            !(0..2).all(|c| (0.0..=limits[c]).contains(&at[c]))
        };
        let color = |i: usize| {
            let colors = across(&self.next[i]).map(|at| color::between(image, at));
            [0, 1, 2]
                .map(|c| colors.iter().map(|color| color[c]).sum::<f32>() / colors.len() as f32)
        };
        let middle = was.start.midpoint(was.end);
        let (cover, leaves) = (color(middle), is_out(middle));
        if !leaves && color::distance(cover, self.colors[middle], yuv) < TOLD {
            return 0..0;
        }
        let is_hidden = |i: usize| {
            let here = color(i);
            let [rope, cover] = [self.colors[i], cover].map(|of| color::distance(here, of, yuv));
            is_out(i) || !leaves && cover < rope
        };
        let creep = (CREEP_WIDTHS * self.width_px / self.spacing_px()) as usize + 1;
        let least = was.start.saturating_sub(creep);
        let most = (was.end + creep).min(self.next.len());
        let first = (least..middle).rev().find(|&i| !is_hidden(i));
        let end = (middle..most).find(|&i| !is_hidden(i));
        first.map_or(least, |i| i + 1)..end.unwrap_or(most)
    }

    /// Extends a hidden part over all unread stations next to it. There, a single edge does not
    /// count, as it may be the occluder's.
    pub(super) fn spread_cover(&mut self) {
        if !self.was_hidden {
            return;
        }
        let (n, mut from) = (self.next.len(), 0);
        while from < n {
            let is_read = |i: &usize| self.next[*i].edges == 2 || self.next[*i].is_crossed;
            let to = (from..n).find(is_read).unwrap_or(n);
            let is_hidden = |i: usize| self.next[i].is_hidden || self.stations[i].is_hidden;
            if (from..to).any(is_hidden) {
                for i in from..to {
                    self.next[i].is_hidden |= self.next[i].edges == 0;
                    self.motion.moves[i] = Move::default();
                }
            }
            from = to + 1;
        }
    }

    /// Changes the longest hidden part of a rope with two visible tips to keep the rope's length.
    /// Returns false if the sum of these changes is too large.
    pub(super) fn keep_length(&mut self, ends_px: [f32; 2]) -> bool {
        let shows = |end: &End| !end.is_border && end.beyond_px.is_some();
        let back = ((POINTS_WIDTHS * self.width_px / self.spacing_px()) as usize).max(2);
        let run = self.longest_hidden();
        let is_between = run.start > back && run.end + back < self.next.len();
        let is_asked = self.was_hidden && !self.closed && self.ends.iter().all(shows);
        if !is_asked || !is_between || run.is_empty() {
            return true;
        }
        let places = self.next.iter().map(|station| station.at);
        let spare_px = self.lay.measure(places) + ends_px[0] + ends_px[1] - self.whole_px;
        self.given_px -= spare_px;
        self.bend_hidden(run, back, spare_px);
        self.given_px.abs() <= GIVEN * self.whole_px
    }

    /// Makes a hidden part shorter by `spare_px`, or longer if that is negative. It is drawn in
    /// toward the cubic that continues the visible parts, or bent farther from its chord. The
    /// visible direction is measured over `back` stations.
    fn bend_hidden(&mut self, run: Range<usize>, back: usize, spare_px: f32) {
        let (i, j) = (run.start - 1, run.end);
        let at = |k: usize| self.next[k].at;
        let t = |k: usize| (k - i) as f32 / (j - i) as f32;
        let bent = |times: f32, k: usize| {
            let straight = vec2::along(at(i), vec2::sub(at(j), at(i)), t(k));
            vec2::along(straight, vec2::sub(at(k), straight), times)
        };
        let way_px = |times: f32| -> f32 {
            let step = |k: usize| vec2::distance(bent(times, k), bent(times, k + 1));
            (i..j).map(step).sum()
        };
        let known_px = way_px(1.0);
        let out = |k: usize, inner: usize| vec2::unit_or(vec2::sub(at(k), at(inner)), [1.0, 0.0]);
        let cubic = bending::cubic([at(i), out(i, i - back)], [at(j), out(j, j + back)]);
        let share = way::drawn_in(spare_px, known_px, way::length_px(&cubic));
        let times = match spare_px < 0.0 {
            true => way::stretching(known_px - spare_px, way_px),
            false => 1.0,
        };
        let shifts = &mut self.motion.shifts;
        shifts.clear();
        shifts.extend(run.clone().map(|k| {
            let place = bent(times, k);
            vec2::along(place, vec2::sub(cubic(t(k)), place), share)
        }));
        for (station, &at) in self.next[run].iter_mut().zip(&self.motion.shifts) {
            station.at = at;
        }
    }

    /// The longest hidden part of the next frame, or an empty range.
    fn longest_hidden(&self) -> Range<usize> {
        let (mut from, mut longest) = (0, 0..0);
        for run in self.next.split(|station| !station.is_hidden) {
            if run.len() > longest.len() {
                longest = from..from + run.len();
            }
            from += run.len() + 1;
        }
        longest
    }
}
