//! Learns a rope's colors, and how its edges read, in the reference image, which is that of the
//! full extraction.

use super::ends::End;
use super::looks::Looks;
use super::rope::{LEAST_SEEN, Rope};
use super::station::{Station, set_normals};
use crate::image::{Image, color};
use crate::scene::{Curve, Status};
use crate::vec2::{self, Vec2};

/// Range of rope widths, in pixels. A thinner rope lacks a pure color in its middle, and a thicker
/// one cannot be distinguished from its ground in a window of sixteen pixels.
const WIDTHS_PX: std::ops::RangeInclusive<f32> = 3.0..=80.0;
/// Minimum confidence of a rope that is followed, and of one that is partly covered. A rope in
/// doubtful order gets a full extraction in each image.
const LEAST_CONFIDENCE: [f32; 2] = [0.5, 0.3];
/// Minimum number of points for a shape that can be followed.
const LEAST_POINTS: usize = 16;
/// Maximum distance between points, in widths, as the space between them is not read.
const APART_WIDTHS: f32 = 2.0;
/// Maximum difference between the lengths of the rope and of a smooth curve through its points, as
/// a share. A larger one means that the points are too far apart for its bends.
const LENGTH: f32 = 0.005;
/// Number of points on either side over which a color and an edge's place are averaged.
const AROUND: usize = 4;
/// Positions across a rope at which its color is read, in widths from the middle.
const ACROSS: [f32; 3] = [-0.3, 0.0, 0.3];
/// Distances beyond an edge at which the ground is read, in pixels.
const BEYOND_PX: [f32; 2] = [2.0, 4.0];
/// Quantile of the color differences on the rope that still counts as the rope's own color.
const OWN: f32 = 0.9;
/// Additional difference that still counts as the rope's own color, in levels.
const MARGIN: f32 = 6.0;
/// Minimum difference of a color that is not the rope's, as a factor of the sum of both.
const CLEAR: f32 = 1.5;
/// Ridge weight, per edge, that draws the fit of `learn_lamp` toward zero dependence.
const LAMP_STIFF: f32 = 0.03;
/// Maximum distance beyond a tip's true place at which it may be read, in widths.
const BEYOND_TIP: f32 = 0.6;
/// Maximum distance of a tip from its extrapolation, sideways, in widths.
const ASIDE_TIP: f32 = 0.15;
/// Maximum mean error if the rope is followed into its own reference image, in pixels plus widths.
/// Any single point may have four times that.
const OFF: (f32, f32) = (0.2, 0.02);

impl Rope {
    /// Takes over an extracted rope. Returns false if it cannot be followed.
    pub(super) fn anchor(&mut self, curve: &Curve, is_known: bool) -> bool {
        let n = curve.points.len();
        let pieces = n.max(2) - usize::from(!curve.closed);
        let spacing_px = curve.length_px / pieces as f32;
        let fits = n >= LEAST_POINTS
            && WIDTHS_PX.contains(&curve.width_px)
            && spacing_px <= APART_WIDTHS * curve.width_px;
        self.was_hidden = curve.hidden.contains(&true);
        self.given_px = 0.0;
        let least = LEAST_CONFIDENCE[usize::from(self.was_hidden)];
        let is_sure = is_known || self.is_brief || curve.confidence >= least;
        if curve.status == Status::Lost || !is_sure || !fits {
            return false;
        }
        (self.width_px, self.closed) = (curve.width_px, curve.closed);
        self.unseen_frames = 0;
        self.is_part = curve.status == Status::Partial && !self.was_hidden;
        self.ends = curve.border.map(|is_border| End {
            is_border,
            ..End::default()
        });
        self.stations.clear();
        let places = curve.points.iter().zip(&curve.widths_px).zip(&curve.hidden);
        self.stations
            .extend(places.map(|((&at, &width_px), &is_hidden)| Station {
                at,
                from: at,
                width_px,
                is_hidden,
                edges_px: [-0.5 * width_px, 0.5 * width_px],
                ..Station::default()
            }));
        set_normals(&mut self.stations, self.closed);
        let again = self.closed.then(|| curve.points[0]);
        let places = curve.points.iter().copied().chain(again);
        self.length_px = self.lay.measure(places);
        self.whole_px = self.length_px;
        (self.length_px - curve.length_px).abs() <= LENGTH * curve.length_px
    }

    /// Learns the rope's appearance in the reference image. Returns false if that does not
    /// distinguish the rope from its ground.
    pub(super) fn learn(&mut self, image: &Image) -> bool {
        self.is_learning = true;
        self.learn_colors(image);
        self.learn_ground(image);
        let learnt = self.learn_edges(image) && self.learn_tips(image) && self.agrees(image);
        self.is_learning = false;
        learnt
    }

    /// Reads the rope's color at its points, averaged over their neighbors, and its variation.
    fn learn_colors(&mut self, image: &Image) {
        let n = self.stations.len();
        let here = |station: &Station| across(station).map(|at| color::between(image, at));
        self.offs.clear();
        self.offs.extend(self.stations.iter().flat_map(here));
        self.colors.clear();
        for i in 0..n {
            let (mut sum, mut count) = ([0.0f32; 3], 0.0f32);
            for k in self
                .numbers_around(i)
                .filter(|&k| is_seen(&self.stations[k]))
            {
                for off in &self.offs[3 * k..3 * k + 3] {
                    sum.iter_mut().zip(off).for_each(|(sum, c)| *sum += c);
                    count += 1.0;
                }
            }
            // If all neighbors are covered, the color of the previous point is the best estimate.
            let before = self.colors.last().copied().unwrap_or_default();
            let color = if count > 0.0 {
                sum.map(|c| c / count)
            } else {
                before
            };
            self.colors.push(color);
        }
        // Differences between the color at each place and the mean around it.
        let mut kept = 0;
        for i in (0..n).filter(|&i| is_seen(&self.stations[i])) {
            for k in 0..ACROSS.len() {
                let (here, usual) = (self.offs[3 * i + k], self.colors[i]);
                self.offs[kept] = [0, 1, 2].map(|c| here[c] - usual[c]);
                kept += 1;
            }
        }
        self.offs.truncate(kept);
        self.looks = Looks::of(&self.offs, image.format());
        for (station, &color) in self.stations.iter_mut().zip(&self.colors) {
            station.color = self.looks.middle(color);
        }
        let nothing = self.looks.middle([0.0; 3]);
        self.differences.clear();
        let offs = self.offs.iter();
        self.differences
            .extend(offs.map(|&off| self.looks.distance(off, &nothing)));
        let most = (OWN * self.differences.len() as f32) as usize;
        self.differences.sort_unstable_by(f32::total_cmp);
        let own = self.differences.get(most).copied().unwrap_or(0.0);
        self.looks.strange = CLEAR * (own + MARGIN);
    }

    /// Reads the ground's difference from the rope's color, on either side.
    fn learn_ground(&mut self, image: &Image) {
        for (station, &shown) in self.stations.iter_mut().zip(&self.shown) {
            station.is_clear = false;
            for (side, sign) in [(0, -1.0), (1, 1.0)] {
                let levels = BEYOND_PX.map(|px| {
                    let out_px = sign * (0.5 * station.width_px + px);
                    let at = vec2::along(station.at, station.normal, out_px);
                    self.looks
                        .distance(color::between(image, at), &station.color)
                });
                let level = levels[0].min(levels[1]);
                station.is_clear |= shown[side] && level >= self.looks.strange;
                station.cuts[side] = 0.5 * level;
            }
            // Beyond an edge that does not show is another rope, so the other edge's level applies
            // to both.
            if let [true, false] | [false, true] = shown {
                station.cuts = [station.cuts[usize::from(shown[1])]; 2];
            }
        }
    }

    /// Learns where the edges are read.
    fn learn_edges(&mut self, image: &Image) -> bool {
        self.next.clone_from(&self.stations);
        self.read(image);
        self.learn_lamp();
        let n = self.stations.len();
        let mut read = 0;
        for i in 0..n {
            let (mut sums, mut counts) = ([0.0f32; 2], [0.0f32; 2]);
            for k in self.numbers_around(i) {
                let off_px = self.readings[k].off_px;
                for side in 0..2 {
                    // An edge farther off belongs to something else.
                    if let Some(px) = off_px[side].filter(|&px| self.is_own(px)) {
                        (sums[side], counts[side]) = (sums[side] + px, counts[side] + 1.0);
                    }
                }
            }
            let station = &mut self.stations[i];
            for side in 0..2 {
                station.edges_px[side] += sums[side] / counts[side].max(1.0);
            }
            let reading = &self.readings[i];
            read += usize::from(reading.off_px.iter().any(Option::is_some));
            for side in 0..2 {
                if reading.off_px[side].is_some() {
                    station.cuts[side] = reading.levels[side];
                }
            }
        }
        read as f32 >= LEAST_SEEN * n as f32
    }

    /// Returns whether an edge at this distance from its expected place is the rope's.
    fn is_own(&self, off_px: f32) -> bool {
        off_px.abs() < 1.0 + 0.2 * self.width_px
    }

    /// Learns how the place at which an edge is read depends on the direction that it faces, by
    /// ridge regression.
    fn learn_lamp(&mut self) {
        let both = self.stations.iter().zip(&self.readings);
        let own = both.flat_map(|(station, reading)| {
            let [a, b] = reading.off_px;
            let facing = [a.map(|px| (px, -1.0)), b.map(|px| (-px, 1.0))]
                .into_iter()
                .flatten();
            facing.map(|(in_px, sign)| (in_px, vec2::scale(station.normal, sign)))
        });
        let own = || own.clone().filter(|&(in_px, _)| self.is_own(in_px));
        let (mut mean_px, mut mean, mut count) = (0.0f32, [0.0f32; 2], 0.0f32);
        for (in_px, facing) in own() {
            (mean_px, mean, count) = (mean_px + in_px, vec2::add(mean, facing), count + 1.0);
        }
        let count = count.max(1.0);
        (mean_px, mean) = (mean_px / count, vec2::scale(mean, 1.0 / count));
        let stiff = LAMP_STIFF * count;
        let (mut a, mut b, mut d, mut right) = (stiff, 0.0, stiff, [0.0f32; 2]);
        for (in_px, facing) in own() {
            let [x, y] = vec2::sub(facing, mean);
            (a, b, d) = (a + x * x, b + x * y, d + y * y);
            right = vec2::along(right, [x, y], in_px - mean_px);
        }
        let determinant = a * d - b * b;
        let [x, y] = right;
        self.lamp = [d * x - b * y, a * y - b * x].map(|v| v / determinant);
    }

    fn learn_tips(&mut self, image: &Image) -> bool {
        self.next.clone_from(&self.stations);
        if self.measure(image).is_none() {
            return false;
        }
        for end in 0..2 {
            let tip = if end == 0 { 0 } else { self.next.len() - 1 };
            let (now, was) = (&self.next[tip], &self.stations[tip]);
            let inner = if end == 0 { 1 } else { self.next.len() - 2 };
            let out = vec2::unit_or(vec2::sub(was.at, self.stations[inner].at), [1.0, 0.0]);
            let aside_px = vec2::dot(vec2::sub(was.at, now.at), vec2::normal(out));
            self.ends[end].aside_px =
                aside_px.clamp(-ASIDE_TIP * self.width_px, ASIDE_TIP * self.width_px);
        }
        self.next.clone_from(&self.stations);
        let most_px = BEYOND_TIP * self.width_px + 1.0;
        for end in 0..2 {
            self.ends[end].was_against = self.ends[end].is_against;
            if !self.closed && !self.ends[end].is_border && !self.ends[end].is_against {
                let beyond_px = self.tip(image, end);
                self.ends[end].beyond_px = beyond_px.filter(|px| px.abs() <= most_px);
            }
        }
        true
    }

    /// Returns whether the rope stays in place if it is followed into its own reference image.
    fn agrees(&mut self, image: &Image) -> bool {
        self.next.clone_from(&self.stations);
        if self.measure(image).is_none() {
            return false;
        }
        let off = |(next, was): (&Station, &Station)| vec2::distance(next.at, was.at);
        let offs = || self.next.iter().zip(&self.stations).map(off);
        let mean_px = offs().sum::<f32>() / self.stations.len() as f32;
        let most_px = OFF.0 + OFF.1 * self.width_px;
        mean_px <= most_px && offs().all(|px| px <= 4.0 * most_px)
    }

    /// Marks the points that are on another strand in the reference image, as `come_together`
    /// found.
    pub(super) fn keep_together(&mut self) {
        for (station, found) in self.stations.iter_mut().zip(&self.next) {
            (station.is_together, station.is_on) = (found.is_together, found.is_on);
        }
    }

    /// Indices of the points around one, including itself.
    fn numbers_around(&self, i: usize) -> impl Iterator<Item = usize> + use<> {
        let (n, closed) = (self.stations.len(), self.closed);
        (i + n - AROUND..=i + n + AROUND)
            .filter(move |&k| closed || (n..2 * n).contains(&k))
            .map(move |k| k % n)
    }
}

/// Returns whether the rope's own color shows at a point.
fn is_seen(station: &Station) -> bool {
    !station.is_crossed && !station.is_hidden
}

/// Places across a rope at which its color is read.
pub(super) fn across(station: &Station) -> [Vec2; 3] {
    ACROSS.map(|widths| vec2::along(station.at, station.normal, widths * station.width_px))
}
