//! A rope that is followed by its edges.

use super::edge::WINDOW;
use super::ends::End;
use super::looks::Looks;
use super::motion::Motion;
use super::read::{Measurement, ReadAll};
use super::station::{Station, set_normals};
use crate::centerline::line::{Line, Sample};
use crate::centerline::smooth::Smoother;
use crate::following::axis;
use crate::following::crossings::{Crossed, Over};
use crate::following::lay::Lay;
use crate::image::Image;
use crate::scene::{Curve, Status};
use crate::vec2::{self, Vec2};
use lariat_portable::Arch;

/// Minimum share of read points among those whose edges could be read in the reference image and
/// that nothing covers.
const LEAST_READ: f32 = 0.6;
/// Minimum share of read points among all.
pub(super) const LEAST_SEEN: f32 = 0.35;
/// Maximum unread length between read parts, or before an end that is at another strand or covered,
/// in widths.
const MOST_BRIDGED: f32 = 10.0;
/// Maximum unread length before an end that shows, in widths.
const MOST_AT_END: f32 = 4.0;
/// Maximum unread length on a plain table, where nothing is known to cover the edges, in widths.
const MOST_BLIND: f32 = 2.5;
/// Maximum length along a rope over which a crossing may prevent its edges from being read, in
/// widths. Strands that cross at a flat angle show their edges farther on.
const CROSSED: f32 = 3.0;
/// Maximum number of frames for which a rope is followed with a new object over it, or with a tip
/// that is missing although nothing hides it.
const MOST_UNSEEN_FRAMES: u32 = 12;
/// Distance from a tip, in widths, within which the edges are the tip's own.
const AT_TIP: f32 = 0.35;
/// Distance that a slanting row runs along the rope, in widths, per unit of slant.
const ALONG: f32 = 0.5;
/// Reach of the tip's blur, in pixels.
const CLEAR_PX: f32 = 1.0;
/// Reach of smoothing, in points.
const SMOOTH: f32 = 0.6;
/// Weight of points that move with others.
const CARRIED: f32 = 0.1;
/// Share of their distance from the extrapolation that unread points before a tip move in each
/// frame.
const RUN_ON_PACE: f32 = 0.25;
/// Maximum mean sideways movement, in pixels. A rope that moved farther is read once more at its
/// new place.
const FAR_PX: f32 = 1.0;
/// Maximum change of a rope's length between its tips, as a share.
pub(super) const LENGTH: f32 = 0.025;
/// Rate at which the level of an edge follows its readings.
const PACE: f32 = 0.3;

/// A rope, and its appearance in the reference image.
#[derive(Debug, Default)]
pub(super) struct Rope {
    pub(super) stations: Vec<Station>,
    /// Stations in the current frame, until it is accepted, and their readings.
    pub(super) next: Vec<Station>,
    pub(super) readings: Vec<Measurement>,
    wanted: Vec<bool>,
    /// For each station, which edges show, because no other strand is there.
    pub(super) shown: Vec<[bool; 2]>,
    pub(super) closed: bool,
    pub(super) ends: [End; 2],
    pub(super) width_px: f32,
    pub(super) length_px: f32,
    /// Length in the reference image.
    pub(super) whole_px: f32,
    pub(super) looks: Looks,
    /// Color at each station.
    pub(super) colors: Vec<[f32; 3]>,
    /// Differences of the colors across the rope from that color.
    pub(super) offs: Vec<[f32; 3]>,
    pub(super) unseen_frames: u32,
    /// True if a part was hidden in the reference image.
    pub(super) was_hidden: bool,
    /// Change in length of that part since.
    pub(super) given_px: f32,
    /// True if only a part of the rope was seen, although no point is marked as hidden.
    pub(super) is_part: bool,
    /// True if it is on a plain table.
    pub(super) is_on_table: bool,
    /// True if it is followed for a moment only.
    pub(super) is_brief: bool,
    /// True if the current image is the reference image.
    pub(super) is_learning: bool,
    /// Distance by which an edge is read farther inward, per unit of the direction that it faces.
    /// The cause is light from one side.
    pub(super) lamp: Vec2,
    pub(super) lay: Lay,
    pub(super) motion: Motion,
    pub(super) differences: Vec<f32>,
    line: Line,
    smoother: Smoother,
}

impl Rope {
    /// Allocates all buffers for this many points.
    pub(super) fn reserve(&mut self, points: usize) {
        self.stations.reserve(points);
        self.next.reserve(points);
        self.readings.reserve(points);
        self.wanted.reserve(points);
        self.shown.reserve(points);
        self.colors.reserve(points);
        self.offs.reserve(3 * points);
        self.differences.reserve(3 * points);
        self.motion.reserve(points);
        // The smoother and `Lay` allocate their own buffers when they run, here on an open and a
        // closed line.
        let places = (0..=points).map(|i| [i as f32, 0.0]);
        self.lay.lay(places.clone(), [1.0; 2]);
        for closed in [true, false] {
            self.line.closed = closed;
            self.line.samples.clear();
            self.line.samples.extend(places.clone().map(|at| Sample {
                at,
                weight: 1.0,
                width_px: 1.0,
                side: 0.0,
            }));
            self.smoother.smooth(&mut self.line, SMOOTH);
        }
    }

    /// Index of the station at normalized arc length `rho`.
    fn number(&self, rho: f32) -> usize {
        let n = self.stations.len();
        let pieces = if self.closed { n } else { n - 1 };
        let number = (rho * pieces as f32).round() as usize;
        if self.closed {
            number % n
        } else {
            number.min(n - 1)
        }
    }

    pub(super) fn spacing_px(&self) -> f32 {
        let pieces = self.stations.len() - usize::from(!self.closed);
        (self.length_px / pieces as f32).max(0.1)
    }

    /// Distance from the rope's points within which something may be the rope itself, before or
    /// after moving.
    pub(super) fn reach_px(&self) -> f32 {
        0.5 * self.width_px + WINDOW as f32 + self.spacing_px()
    }

    /// Prefetches the pixels around the rope's edges, where they are expected in the next frame.
    pub(super) fn fetch(&self, image: &Image) {
        let size = [image.width(), image.height()];
        for station in self.stations.iter().filter(|station| !station.is_crossed) {
            let axis = axis(station.normal);
            let at = vec2::along(station.at, station.normal, station.aside_px);
            let line = (at[1 - axis] + 0.5).clamp(0.0, (size[1 - axis] - 1) as f32) as usize;
            for edge_px in station.edges_px {
                let from = at[axis] + edge_px / station.normal[axis] - (WINDOW / 2) as f32;
                let from = from.max(0.0) as usize;
                image.fetch(axis, line, from..from + WINDOW + 1);
            }
        }
    }

    /// Reads the edges at the stations of the next frame.
    pub(super) fn read(&mut self, image: &Image) {
        let (n, spacing_px) = (self.next.len(), self.spacing_px());
        self.wanted.clear();
        for (i, station) in self.next.iter().enumerate() {
            let axis = axis(station.normal);
            let slant = (station.normal[1 - axis] / station.normal[axis]).abs();
            let beside_px = (AT_TIP + ALONG * slant) * self.width_px + CLEAR_PX;
            let clear = |end: usize, from_end: usize| {
                self.closed || self.ends[end].is_border || from_end as f32 * spacing_px >= beside_px
            };
            let clear = clear(0, i) && clear(1, n - 1 - i);
            let is_own = !station.is_crossed && !station.is_on;
            self.wanted.push(clear && is_own);
        }
        self.readings.resize(n, Measurement::default());
        Arch::new().dispatch(ReadAll {
            image,
            looks: &self.looks,
            stations: &self.next,
            wanted: &self.wanted,
            shown: &self.shown,
            readings: &mut self.readings,
        });
    }

    /// Moves the stations of the next frame to where their edges show the rope. Returns the mean
    /// distance, or `None` if too little was seen.
    pub(super) fn measure(&mut self, image: &Image) -> Option<f32> {
        self.read(image);
        self.find_cover(image);
        let shape = (self.closed, self.spacing_px(), self.width_px);
        self.motion.agree(&self.next, &self.readings, shape);
        let [mut asked, mut read] = [0usize; 2];
        let said = self
            .readings
            .iter()
            .zip(&self.motion.moves)
            .zip(&self.wanted)
            .zip(&self.shown);
        for (station, (((reading, by), &wanted), shown)) in self.next.iter_mut().zip(said) {
            let pair = reading.off_px[0].zip(reading.off_px[1]);
            station.edges = match by.weight {
                0.0 => 0,
                1.0 => 2,
                _ => 1,
            };
            station.is_hidden = if wanted {
                station.edges == 0 && reading.is_covered
            } else {
                station.is_hidden
            };
            read += usize::from(station.edges > 0);
            let is_asked = wanted && *shown != [false; 2] && station.is_clear;
            asked += usize::from(is_asked && !station.is_hidden);
            if let (2, Some((a, b))) = (station.edges, pair) {
                station.width_px += b - a;
                station.edges_px[0] += a - by.px;
                station.edges_px[1] += b - by.px;
            }
            for side in 0..2 {
                let level = reading.levels[side];
                let is_own = reading.off_px[side].is_some_and(|px| (px - by.px).abs() < 2.0);
                if station.edges > 0 && is_own {
                    station.cuts[side] += PACE * (level - station.cuts[side]);
                }
            }
        }
        self.spread_cover();
        self.keep_ends_covered();
        let n = self.next.len();
        let enough =
            read as f32 >= LEAST_READ * asked as f32 && read as f32 >= LEAST_SEEN * n as f32;
        (enough && (self.is_brief || self.holds_together())).then(|| self.settle())
    }

    /// Keeps the covered marks before the ends as they were. There, only the tip shows whether the
    /// rope is covered or ends.
    fn keep_ends_covered(&mut self) {
        let is_read = |station: &Station| station.edges > 0;
        let n = self.next.len();
        let first = self.next.iter().position(is_read).unwrap_or(n);
        let last = self.next.iter().rposition(is_read).unwrap_or(0);
        if !self.closed {
            for i in (0..first).chain(last + 1..n) {
                self.next[i].is_hidden = self.stations[i].is_hidden;
            }
        }
    }

    /// Returns whether all unread parts are short enough for their neighbors to determine them.
    fn holds_together(&self) -> bool {
        let most = |widths: f32| (widths * self.width_px / self.spacing_px()) as usize + 1;
        let inner = most(MOST_BRIDGED);
        let outer = |end: usize| match self.ends[end].is_against {
            true => inner,
            false => most(MOST_AT_END),
        };
        let read = |station: &Station| station.edges > 0;
        let (Some(first), Some(last)) = (
            self.next.iter().position(read),
            self.next.iter().rposition(read),
        ) else {
            return false;
        };
        let mut runs = self.next[first..=last].split(read).map(<[_]>::len);
        let (before, after) = (first, self.next.len() - 1 - last);
        let ends = match self.closed {
            true => before + after <= inner,
            false => before <= outer(0) && after <= outer(1),
        };
        ends && runs.all(|run| run <= inner)
            && (!self.is_on_table || self.is_seen(most(MOST_BLIND)))
    }

    /// Returns whether at most `most` stations in a row are unread without a known cover.
    fn is_seen(&self, most: usize) -> bool {
        let places = self.next.iter().zip(&self.shown).zip(&self.wanted);
        let mut run = 0;
        places.into_iter().all(|((station, shown), &wanted)| {
            let is_blind = station.edges == 0 && wanted && *shown != [false; 2];
            run = if is_blind && !station.is_hidden {
                run + 1
            } else {
                0
            };
            run <= most
        })
    }

    /// Moves the stations, smoothed along the rope. Returns the mean distance.
    fn settle(&mut self) -> f32 {
        let width_px = self.width_px;
        self.motion.shift(&self.next, self.closed, width_px);
        let Motion { moves, shifts, .. } = &self.motion;
        let samples = &mut self.line.samples;
        samples.clear();
        let all = self.next.iter().zip(shifts).zip(moves);
        samples.extend(all.map(|((station, &shift), by)| Sample {
            at: vec2::add(station.at, shift),
            weight: by.weight.max(CARRIED),
            width_px: station.width_px,
            side: 0.0,
        }));
        self.line.closed = self.closed;
        self.smoother.smooth(&mut self.line, SMOOTH);
        let mut sum = 0.0;
        for (station, sample) in self.next.iter_mut().zip(&self.line.samples) {
            sum += vec2::distance(station.at, sample.at);
            station.at = sample.at;
        }
        self.run_on(if self.is_learning { 1.0 } else { RUN_ON_PACE });
        for (station, was) in self.next.iter_mut().zip(&self.stations) {
            station.aside_px = vec2::dot(vec2::sub(station.at, was.at), was.normal);
        }
        sum / self.next.len() as f32
    }

    /// Finds the rope in the next image. Returns false if that needs a full extraction. The caller
    /// commits the result with [`take`](Self::take).
    pub(super) fn follow(&mut self, image: &Image) -> bool {
        self.next.clone_from(&self.stations);
        for station in &mut self.next {
            station.at = vec2::along(station.at, station.normal, station.aside_px);
        }
        let Some(mut aside_px) = self.measure(image) else {
            return false;
        };
        if aside_px > FAR_PX {
            set_normals(&mut self.next, self.closed);
            let Some(again_px) = self.measure(image) else {
                return false;
            };
            aside_px = again_px;
        }
        // The rope is moving away too fast.
        if aside_px > FAR_PX {
            return false;
        }
        let is_unseen = !self.was_hidden && self.next.iter().any(|station| station.is_hidden)
            || !self.closed && self.ends.iter().any(End::is_unseen);
        self.unseen_frames = if is_unseen { self.unseen_frames + 1 } else { 0 };
        (self.is_brief || self.unseen_frames <= MOST_UNSEEN_FRAMES) && self.lay(image)
    }

    /// Respaces the stations from end to end.
    fn lay(&mut self, image: &Image) -> bool {
        let Some(ends_px) = self.find_ends(image) else {
            return false;
        };
        if !self.keep_length(ends_px) {
            return false;
        }
        let again = self.closed.then(|| self.next[0].at);
        let places = self.next.iter().map(|s| s.at).chain(again);
        let Some(length_px) = self.lay.lay(places, ends_px) else {
            return false;
        };
        for (station, &at) in self.next.iter_mut().zip(self.lay.points()) {
            station.at = at;
        }
        self.length_px = length_px;
        set_normals(&mut self.next, self.closed);
        for (station, was) in self.next.iter_mut().zip(&self.stations) {
            // Edges face opposite directions. If one is farther in, the other one is farther out.
            let turned = vec2::sub(station.normal, was.normal);
            let out_px = vec2::dot(self.lamp, turned);
            station.edges_px = station.edges_px.map(|px| px - out_px);
        }
        let leaves = self.ends.iter().any(|end| end.is_border);
        let limits = [image.width(), image.height()].map(|side| (side - 1) as f32);
        // The end at the border is on it, within rounding.
        let inside = |at: Vec2| (0..2).all(|c| at[c] >= -0.5 && at[c] <= limits[c] + 0.5);
        let same = leaves || (length_px / self.whole_px - 1.0).abs() <= LENGTH;
        for station in &mut self.next {
            station.at = [0, 1].map(|c| {
                let most = limits[c];
                if leaves {
                    station.at[c].clamp(0.0, most)
                } else {
                    station.at[c]
                }
            });
        }
        let may_leave = |station: &Station| self.was_hidden && station.is_hidden;
        same && (self.next.iter()).all(|station| inside(station.at) || may_leave(station))
    }

    /// Commits the result of [`follow`](Self::follow), and writes it to `curve`.
    pub(super) fn take(&mut self, curve: &mut Curve) {
        std::mem::swap(&mut self.stations, &mut self.next);
        let mean = |stations: &[Station]| {
            stations.iter().map(|s| s.width_px).sum::<f32>() / stations.len() as f32
        };
        let wider = mean(&self.stations) / mean(&self.next).max(0.1);
        curve.width_px *= wider;
        self.width_px = curve.width_px;
        curve.length_px = self.length_px;
        curve.points.clear();
        curve.points.extend(self.stations.iter().map(|s| s.at));
        curve.widths_px.clear();
        let widths = self.stations.iter().map(|s| s.width_px);
        curve.widths_px.extend(widths);
        curve.hidden.clear();
        let hidden = self.stations.iter().map(|s| s.is_hidden);
        curve.hidden.extend(hidden);
        let is_whole = !curve.hidden.contains(&true);
        curve.status = match (curve.status, is_whole) {
            (Status::Doubtful, _) => Status::Doubtful,
            (_, true) if !self.is_part => Status::Ok,
            _ => Status::Partial,
        };
    }
}

impl Crossed for Rope {
    fn clear_crossings(&mut self) {
        self.stations.iter_mut().for_each(|s| s.is_crossed = false);
    }

    fn cross(&mut self, rho: f32, over: &Over) {
        let (n, middle) = (self.stations.len(), self.number(rho));
        let most = (CROSSED * self.width_px / self.spacing_px()) as usize + 1;
        for way in [1, n - 1] {
            let mut i = middle;
            for _ in 0..n.min(most) {
                let station = &mut self.stations[i];
                if !over.covers(station.at, station.normal) {
                    break;
                }
                station.is_crossed = true;
                let next = (i + way) % n;
                if !self.closed && next.abs_diff(i) != 1 {
                    break;
                }
                i = next;
            }
        }
    }

    fn at(&self, rho: f32) -> (Vec2, Vec2) {
        let station = &self.stations[self.number(rho)];
        (station.at, station.normal)
    }

    fn width_px(&self) -> f32 {
        self.width_px
    }
}
