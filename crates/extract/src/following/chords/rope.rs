//! A rope that is followed by its chords.

use super::chord::{MOST, Reader};
use super::profile::{self, BLOCK};
use super::station::{
    ASIDE_WIDTHS, Measurement, ReadAll, Station, TIP_WIDTHS, beyond, set_normals,
};
use crate::centerline::line::{Line, Sample};
use crate::centerline::smooth::Smoother;
use crate::following::crossings::{Crossed, Over};
use crate::following::lay::Lay;
use crate::scene::Curve;
use crate::vec2::{self, Vec2};

/// Minimum share of the points with a chord of their own.
pub(super) const LEAST_MEASURED: f32 = 0.6;
/// Number of points next to one without a chord that may also lose theirs, as a crossing moves
/// along the rope.
const BESIDE: usize = 2;
/// Maximum share of all points that may lose their chord elsewhere.
const LOST: f32 = 0.02;
/// Maximum length between read parts that may go unread: in widths, or in pixels if that is more.
const MOST_BRIDGED: (f32, f32) = (6.0, 24.0);
/// Distance from a tip, in widths, within which the rope is not read. A chord that would come that
/// near, or run out of the tip, is read straight across.
pub(super) const AT_TIP: f32 = 0.35;
/// Number of additional points before a tip that may lack a reading.
const MOST_UNREAD: usize = 1;
/// Length before a tip, in widths, over which the bend is measured, twice, to extrapolate to the
/// tip.
const BEFORE_TIP: f32 = 1.0;
/// Maximum bend of the extrapolation, in radians over that length.
const SHARPEST: f32 = 0.8;
/// Reach of smoothing, in points. A chord is a single row of noisy pixels. A bend with a radius of
/// three points, which is as tight as ropes get, loses (0.6/3)⁴ of it.
const SMOOTH: f32 = 0.6;
/// Maximum mean sideways movement, in pixels. A rope that moved farther is measured once more at
/// its new place, as chords are accurate when near.
const FAR_PX: f32 = 1.0;

/// A rope, and how its chords read in the reference image.
#[derive(Debug, Default)]
pub(super) struct Rope {
    pub(super) stations: Vec<Station>,
    /// Stations in the current frame, until it is accepted, and their readings.
    pub(super) next: Vec<Station>,
    pub(super) readings: Vec<Option<Measurement>>,
    pub(super) tips: [Tip; 2],
    pub(super) width_px: f32,
    pub(super) length_px: f32,
    pub(super) lay: Lay,
    line: Line,
    smoother: Smoother,
}

/// An end of the rope, relative to its extrapolation.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tip {
    /// Distance beyond it at which the difference falls to half.
    pub(super) beyond_px: f32,
    /// Sideways distance.
    pub(super) aside_px: f32,
}

impl Rope {
    /// Index of the `i`-th station from an end.
    pub(super) fn place(&self, end: usize, i: usize) -> usize {
        if end == 0 {
            i
        } else {
            self.stations.len() - 1 - i
        }
    }

    pub(super) fn end(&self, end: usize, i: usize) -> &Station {
        &self.stations[self.place(end, i)]
    }

    /// Returns whether the rope can be extrapolated to a tip of the next frame: few enough stations
    /// before it are unread, and enough after those are read.
    pub(super) fn can_run_on(&self, end: usize, unread: usize) -> bool {
        let most = (AT_TIP * self.width_px / self.spacing_px()) as usize + 1 + MOST_UNREAD;
        let mut needed = unread..=(unread + 2 * self.before_tip()).min(self.next.len() - 1);
        unread <= most && needed.all(|i| self.next[self.place(end, i)].is_measured)
    }

    /// Number of stations over which the bend before a tip is measured, twice.
    fn before_tip(&self) -> usize {
        let before = (BEFORE_TIP * self.width_px / self.spacing_px()).round() as usize;
        before.clamp(1, self.stations.len() / 4)
    }

    fn spacing_px(&self) -> f32 {
        (self.length_px / (self.stations.len() - 1) as f32).max(0.1)
    }

    /// Reads the stations of the next frame.
    pub(super) fn read(&mut self, reader: &Reader) {
        let (span, spacing_px) = (self.span(), self.spacing_px());
        self.readings.clear();
        self.readings.resize(self.next.len(), None);
        profile::dispatch(ReadAll {
            reader,
            stations: &self.next,
            readings: &mut self.readings,
            spacing_px,
            width_px: self.width_px,
            span,
        });
    }

    /// Places the first `unread` stations from an end, in the next frame, on the arc through those
    /// after them.
    pub(super) fn run_on(&mut self, end: usize, unread: usize) {
        let n = self.next.len();
        let back = self.before_tip();
        let at = |i: usize| self.next[self.place(end, i.min(n - 1))].at;
        let here = at(unread);
        let new = vec2::sub(here, at(unread + back));
        let old = vec2::sub(at(unread + back), at(unread + 2 * back));
        let turn = vec2::angle(old, new).clamp(-SHARPEST, SHARPEST);
        let way_px = vec2::norm(new).max(0.1);
        let direction = vec2::unit_or(new, [1.0, 0.0]);
        let aside = vec2::scale(self.end(end, 0).normal, self.tips[end].aside_px);
        for i in 0..unread {
            let far_px = (unread - i) as f32 * self.spacing_px();
            // The chord to a point on a circle is at half the angle from the tangent.
            let (sin, cos) = libm::sincosf(0.5 * turn * (1.0 + far_px / way_px));
            let ahead = vec2::along(vec2::scale(direction, cos), vec2::normal(direction), sin);
            let share = far_px / (unread as f32 * self.spacing_px());
            let place = self.place(end, i);
            self.next[place].at = vec2::along(vec2::along(here, ahead, far_px), aside, share);
        }
    }

    /// Number of pixels in which a chord is sought.
    fn span(&self) -> usize {
        // A chord is at most √2 widths long. The rope may have moved aside on either side.
        let reach_px = (std::f32::consts::FRAC_1_SQRT_2 + 1.5 * ASIDE_WIDTHS) * self.width_px + 3.0;
        (2 * reach_px.ceil() as usize)
            .next_multiple_of(BLOCK)
            .min(MOST)
    }

    /// Distance from the [places](Self::places) within which something may be the rope itself,
    /// before or after moving.
    pub(super) fn reach_px(&self) -> f32 {
        (0.5 + 2.0 * ASIDE_WIDTHS) * self.width_px + self.spacing_px() + 4.0
    }

    /// Last known positions, at every other point and the last.
    pub(super) fn places(&self) -> impl Iterator<Item = Vec2> {
        let last = self.stations.last();
        let all = self.stations.iter().step_by(2).chain(last);
        all.map(|station| station.at)
    }

    /// Finds the rope in the next image. Returns false if that needs a full extraction. The caller
    /// commits the result with [`take`](Self::take).
    pub(super) fn follow(&mut self, reader: &Reader) -> bool {
        self.next.clone_from(&self.stations);
        for station in &mut self.next {
            station.at = vec2::along(station.at, station.normal, station.aside_px);
        }
        let first_px = self.measure(reader).or_else(|| {
            self.chase(reader);
            set_normals(&mut self.next);
            self.measure(reader)
        });
        let Some(mut aside_px) = first_px else {
            return false;
        };
        if aside_px > FAR_PX {
            set_normals(&mut self.next);
            let Some(again_px) = self.measure(reader) else {
                return false;
            };
            aside_px = again_px;
        }
        // The rope is moving away too fast.
        if aside_px > FAR_PX {
            return false;
        }
        let mut ends = [0.0; 2];
        for (end, far_px) in ends.iter_mut().enumerate() {
            let Some(beyond_px) = beyond(reader, &self.next, end, self.width_px) else {
                return false;
            };
            *far_px = beyond_px - self.tips[end].beyond_px;
            if far_px.abs() > TIP_WIDTHS * self.width_px {
                return false;
            }
        }
        let places = self.next.iter().map(|s| s.at);
        let Some(length_px) = self.lay.lay(places, ends) else {
            return false;
        };
        for (station, &at) in self.next.iter_mut().zip(self.lay.points()) {
            station.at = at;
        }
        self.length_px = length_px;
        set_normals(&mut self.next);
        let limits = [reader.image.width(), reader.image.height()].map(|side| (side - 1) as f32);
        let inside = |at: Vec2| (0..2).all(|c| at[c] >= 0.0 && at[c] <= limits[c]);
        self.next.iter().all(|station| inside(station.at))
    }

    /// Moves the stations to where their chords show the rope. Returns the mean distance, or `None`
    /// if too many lack a chord.
    pub(super) fn measure(&mut self, reader: &Reader) -> Option<f32> {
        self.read(reader);
        let n = self.next.len();
        let (mut lost, mut measured) = (0usize, 0usize);
        for (i, reading) in self.readings.iter().enumerate() {
            let station = &mut self.next[i];
            station.is_measured = reading.is_some();
            if let Some(reading) = reading {
                measured += 1;
                station.aside_px = reading.aside_px - station.bias_px[0];
                station.width_px = reading.width_px - station.bias_px[1];
                station.contrast += 0.3 * (reading.contrast - station.contrast);
            } else if !station.is_crossed {
                let around = &self.stations[i.saturating_sub(BESIDE)..(i + BESIDE + 1).min(n)];
                lost += usize::from(around.iter().all(|s| s.is_measured));
            }
        }
        let enough = measured as f32 >= LEAST_MEASURED * n as f32;
        if !enough || lost as f32 > LOST * n as f32 {
            return None;
        }
        let first = self.next.iter().position(|s| s.is_measured)?;
        let last = self.next.iter().rposition(|s| s.is_measured)?;
        if !self.can_run_on(0, first) || !self.can_run_on(1, n - 1 - last) {
            return None;
        }
        let sum = self.settle(first, last)?;
        self.run_on(0, first);
        self.run_on(1, n - 1 - last);
        for (station, was) in self.next.iter_mut().zip(&self.stations) {
            station.aside_px = vec2::dot(vec2::sub(station.at, was.at), was.normal);
        }
        Some(sum / n as f32)
    }

    /// Moves the stations from `first` to `last` to where they were read, and those in between to
    /// where the rope bends least. Returns the sum of all distances, or `None` if too many in a row
    /// were not read.
    fn settle(&mut self, first: usize, last: usize) -> Option<f32> {
        let most_px = (MOST_BRIDGED.0 * self.width_px).max(MOST_BRIDGED.1);
        let most = (most_px / self.spacing_px()) as usize;
        let samples = &mut self.line.samples;
        samples.clear();
        let stations = &mut self.next[first..=last];
        samples.extend(stations.iter().map(|station| Sample {
            at: vec2::along(station.at, station.normal, station.aside_px),
            weight: f32::from(u8::from(station.is_measured)),
            width_px: station.width_px,
            side: 0.0,
        }));
        // A chord next to one that runs into another strand may also touch it, so it gets no
        // weight.
        let mut begins = None;
        for i in 0..stations.len() {
            match (begins, stations[i].is_measured) {
                (None, false) => begins = Some(i),
                (Some(from), true) => {
                    if i - from > most {
                        return None;
                    }
                    if i - from > 1 {
                        samples[from - 1].weight = 0.0;
                        samples[i].weight = 0.0;
                    }
                    begins = None;
                }
                _ => {}
            }
        }
        self.smoother.smooth(&mut self.line, SMOOTH);
        let mut sum = 0.0;
        for (station, sample) in stations.iter_mut().zip(&self.line.samples) {
            sum += vec2::distance(station.at, sample.at);
            station.at = sample.at;
        }
        Some(sum)
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
        curve
            .widths_px
            .extend(self.stations.iter().map(|s| s.width_px));
    }
}

impl Rope {
    /// Index of the station at normalized arc length `rho`.
    fn number(&self, rho: f32) -> usize {
        let last = self.stations.len() - 1;
        ((rho * last as f32).round() as usize).min(last)
    }
}

impl Crossed for Rope {
    fn clear_crossings(&mut self) {
        self.stations.iter_mut().for_each(|s| s.is_crossed = false);
    }

    fn cross(&mut self, rho: f32, over: &Over) {
        let middle = self.number(rho);
        let (before, after) = self.stations.split_at_mut(middle);
        for way in [
            &mut before.iter_mut().rev() as &mut dyn Iterator<Item = &mut Station>,
            &mut after.iter_mut(),
        ] {
            for station in way.take_while(|station| over.covers(station.at, station.normal)) {
                station.is_crossed = true;
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
