//! One rope that is followed by its chords.

use super::chord::{MOST, Reader, Where};
use super::lay::Lay;
use crate::color;
use crate::line::{Line, Sample};
use crate::scene::{Curve, Status};
use crate::smooth::Smoother;
use crate::vec2::{self, Vec2};

/// Ropes of these widths, in pixels: thinner ones have no middle to tell their contrast by, and of thicker ones a chord
/// does not fit into a span.
const WIDTHS_PX: std::ops::RangeInclusive<f32> = 3.0..=36.0;
/// Fewer points than this are no shape to follow.
const LEAST_POINTS: usize = 16;
/// The farthest that points may lie apart, in widths: what lies between them is not looked at.
const APART_WIDTHS: f32 = 2.0;
/// A smooth curve through the points is as long as the rope, up to this share: or they lie too far apart for its bends.
const LENGTH: f32 = 0.002;
/// How far a rope may have moved aside from where it is expected, in widths and at most in pixels more.
const ASIDE_WIDTHS: f32 = 0.6;
/// How much a chord's width may differ from the rope's there.
const WIDTH: std::ops::RangeInclusive<f32> = 0.78..=1.28;
/// How much its contrast may.
const CONTRAST: std::ops::RangeInclusive<f32> = 0.7..=1.4;
/// The least share of the points that have a chord of their own.
const LEAST_MEASURED: f32 = 0.6;
/// Points beside one without a chord that may lose theirs, as a crossing moves along the rope, and the share of all
/// points that may lose it anywhere.
const BESIDE: usize = 2;
const LOST: f32 = 0.02;
/// A tip may move this far along the rope from one frame to the next, in widths.
const TIP_WIDTHS: f32 = 0.75;
/// Points to either side that a bias and a contrast are averaged with.
const AROUND: usize = 4;
/// Within so many widths of a tip a chord may run out of it: the rope is read straight across there; and nearer than
/// this not at all.
const NEAR_TIP: f32 = 1.2;
const AT_TIP: f32 = 0.35;
/// Points beyond those that may lack a reading before a tip.
const MOST_UNREAD: usize = 1;
/// A tip may lie so far, in widths, beside the way that the rope runs on to it, and beyond where its difference falls.
const OFF_TIP: f32 = 0.15;
const BEYOND_TIP: f32 = 0.5;
/// The rope runs on to its tip as it bends over twice this way, in widths, before it.
const BEFORE_TIP: f32 = 1.0;
/// The sharpest bend that it runs on with, in radians over that way.
const SHARPEST: f32 = 0.8;
/// A strand that crosses blurs this far beyond its width, as a factor and in pixels more.
const CLEAR: f32 = 1.1;
const CLEAR_PX: f32 = 2.0;
/// A rope is followed if that leaves each of its points where it was extracted, to so many pixels, or widths.
const OFF: (f32, f32) = (0.4, 0.04);
/// The reach of smoothing, in points: each chord is one row of noisy pixels. A bend of a radius of three points, as tight
/// as ropes are, loses (0.6/3)⁴ of it.
const SMOOTH: f32 = 0.6;
/// Moved farther than this aside in the mean, in pixels, a rope is measured once more where it then is: chords are
/// exact where they are near.
const FAR_PX: f32 = 1.0;

/// A rope, and how its chords read where it was measured with care.
#[derive(Debug, Default)]
pub(super) struct Rope {
    stations: Vec<Station>,
    /// The same in the frame at hand, until that is taken.
    next: Vec<Station>,
    tips: [Tip; 2],
    pub(super) width_px: f32,
    pub(super) length_px: f32,
    lay: Lay,
    line: Line,
    smoother: Smoother,
}

/// A point of the curve.
#[derive(Clone, Copy, Debug, Default)]
struct Station {
    at: Vec2,
    normal: Vec2,
    /// The width there.
    width_px: f32,
    /// The difference in the middle of the rope.
    contrast: f32,
    /// What chords say too much: how far aside of the curve, and of the width.
    bias_px: [f32; 2],
    /// Whether it was read.
    is_measured: bool,
    /// Whether a strand that crosses here lies in its chord.
    is_crossed: bool,
    /// How far it moved aside in the last frame.
    aside_px: f32,
}

/// An end of the rope, beside the way the rope runs on to it.
#[derive(Clone, Copy, Debug, Default)]
struct Tip {
    /// How far beyond it the difference falls to half.
    beyond_px: f32,
    /// How far aside it lies.
    aside_px: f32,
}

/// One chord, read at a station.
#[derive(Clone, Copy, Debug)]
struct Reading {
    aside_px: f32,
    width_px: f32,
    contrast: f32,
}

impl Rope {
    /// Takes the rope as it was extracted; false when it is none that can be followed.
    pub(super) fn anchor(&mut self, curve: &Curve) -> bool {
        let n = curve.points.len();
        let spacing_px = curve.length_px / (n.max(2) - 1) as f32;
        let plain = curve.status == Status::Ok && !curve.closed && curve.border == [false; 2];
        let fits = n >= LEAST_POINTS
            && WIDTHS_PX.contains(&curve.width_px)
            && spacing_px <= APART_WIDTHS * curve.width_px;
        if !plain || !fits {
            return false;
        }
        self.width_px = curve.width_px;
        self.stations.clear();
        self.stations
            .extend(
                (curve.points.iter().zip(&curve.widths_px)).map(|(&at, &width_px)| Station {
                    at,
                    width_px,
                    ..Station::default()
                }),
            );
        set_normals(&mut self.stations);
        self.length_px = self.lay.measure(self.stations.iter().map(|s| s.at));
        if (self.length_px - curve.length_px).abs() > LENGTH * curve.length_px {
            return false;
        }
        true
    }

    /// Learns how the chords read in the image that the rope was extracted from; false when they do not tell it.
    pub(super) fn learn(&mut self, reader: &mut Reader) -> bool {
        self.learn_contrast(reader);
        self.learn_biases(reader) && self.learn_tips(reader) && self.agrees(reader)
    }

    /// Whether the rope, followed into the very image that it was extracted from, stays where it is.
    fn agrees(&mut self, reader: &mut Reader) -> bool {
        self.next.clone_from(&self.stations);
        if self.measure(reader).is_none() {
            return false;
        }
        let most_px = OFF.0.max(OFF.1 * self.width_px);
        let both = self.next.iter().zip(&self.stations);
        both.into_iter()
            .all(|(next, was)| vec2::distance(next.at, was.at) <= most_px)
    }

    /// Forgets which stations are crossed.
    pub(super) fn clear_crossings(&mut self) {
        self.stations.iter_mut().for_each(|s| s.is_crossed = false);
    }

    /// Notes that another strand crosses at normalized arc length `rho`, with this direction and width.
    pub(super) fn cross(&mut self, rho: f32, direction: Vec2, width_px: f32) {
        let last = self.stations.len() - 1;
        let middle = (rho * last as f32).round() as usize;
        let across = vec2::normal(direction);
        let place = self.stations[middle.min(last)].at;
        let clear_px = 0.5 * width_px * CLEAR + CLEAR_PX;
        let half_px = 0.5 * self.width_px;
        let crosses = |station: &Station| {
            let axis = axis(station.normal);
            let reach_px = (half_px / station.normal[axis] * across[axis]).abs();
            vec2::dot(vec2::sub(station.at, place), across).abs() < clear_px + reach_px
        };
        let (before, after) = self.stations.split_at_mut(middle.min(last));
        for way in [
            &mut before.iter_mut().rev() as &mut dyn Iterator<Item = _>,
            &mut after.iter_mut(),
        ] {
            for station in way.take_while(|station| crosses(station)) {
                station.is_crossed = true;
            }
        }
    }

    /// The rope's direction at normalized arc length `rho`.
    pub(super) fn direction(&self, rho: f32) -> Vec2 {
        let last = self.stations.len() - 1;
        let normal = self.stations[((rho * last as f32).round() as usize).min(last)].normal;
        [normal[1], -normal[0]]
    }

    /// Reads the rope's contrast at its points, in the mean of those around.
    fn learn_contrast(&mut self, reader: &mut Reader) {
        for station in &mut self.stations {
            let color = color::between(reader.image, station.at);
            station.bias_px[0] = difference(reader, station.at, color);
        }
        self.average(|s| Some(s.bias_px[0]), |s, mean| s.contrast = mean.max(2.0));
    }

    fn learn_biases(&mut self, reader: &mut Reader) -> bool {
        let span = self.span();
        let mut measured = 0;
        for i in 0..self.stations.len() {
            let near = self.nearness(i);
            let station = &mut self.stations[i];
            station.bias_px = [0.0; 2];
            let reading = read(reader, station, near, span);
            station.is_measured = reading.is_some();
            if let Some(reading) = reading {
                measured += 1;
                station.bias_px = [reading.aside_px, reading.width_px - station.width_px];
            }
        }
        for part in 0..2 {
            self.average(
                |s| s.is_measured.then_some(s.bias_px[part]),
                |s, mean| s.aside_px = mean,
            );
            for station in &mut self.stations {
                station.bias_px[part] = station.aside_px;
            }
        }
        self.stations.iter_mut().for_each(|s| s.aside_px = 0.0);
        measured as f32 >= LEAST_MEASURED * self.stations.len() as f32
    }

    fn learn_tips(&mut self, reader: &mut Reader) -> bool {
        self.tips = [Tip::default(); 2];
        let known: fn(&Station) -> bool = |s| s.is_measured;
        let ends = [
            self.stations.iter().position(known),
            self.stations.iter().rev().position(known),
        ];
        self.next.clone_from(&self.stations);
        for (end, unread) in ends.into_iter().enumerate() {
            let Some(unread) = unread.filter(|&unread| self.can_run_on(end, unread)) else {
                return false;
            };
            let (true_tip, normal) = (self.end(end, 0).at, self.end(end, 0).normal);
            self.run_on(end, unread);
            let run_on = self.next[self.place(end, 0)].at;
            self.tips[end].aside_px = vec2::dot(vec2::sub(true_tip, run_on), normal);
            let Some(beyond_px) = beyond(reader, &self.stations, end, self.width_px) else {
                return false;
            };
            self.tips[end].beyond_px = beyond_px;
            let [off, beyond] = [OFF_TIP, BEYOND_TIP].map(|widths| widths * self.width_px);
            if self.tips[end].aside_px.abs() > off || beyond_px.abs() > beyond {
                return false;
            }
        }
        true
    }

    /// The number of the `i`-th station from an end.
    fn place(&self, end: usize, i: usize) -> usize {
        if end == 0 {
            i
        } else {
            self.stations.len() - 1 - i
        }
    }

    fn end(&self, end: usize, i: usize) -> &Station {
        &self.stations[self.place(end, i)]
    }

    /// Whether so few stations before a tip of the next frame are unread, and so many after those are read, that the rope
    /// can be run on to it.
    fn can_run_on(&self, end: usize, unread: usize) -> bool {
        let most = (AT_TIP * self.width_px / self.spacing_px()) as usize + 1 + MOST_UNREAD;
        let mut needed = unread..=(unread + 2 * self.before_tip()).min(self.next.len() - 1);
        unread <= most && needed.all(|i| self.next[self.place(end, i)].is_measured)
    }

    /// Stations that the rope's bend before a tip is read over, twice.
    fn before_tip(&self) -> usize {
        let before = (BEFORE_TIP * self.width_px / self.spacing_px()).round() as usize;
        before.clamp(1, self.stations.len() / 4)
    }

    fn spacing_px(&self) -> f32 {
        (self.length_px / (self.stations.len() - 1) as f32).max(0.1)
    }

    /// How station `i` is to be read.
    fn nearness(&self, i: usize) -> Near {
        let far = i.min(self.stations.len() - 1 - i) as f32 * self.spacing_px() / self.width_px;
        match far {
            _ if far < AT_TIP || i == 0 || i + 1 == self.stations.len() => Near::Tip,
            _ if far < NEAR_TIP => Near::BeforeTip,
            _ => Near::Rope,
        }
    }

    /// Lays the first `unread` stations of the next frame from an end on along the arc that those after them lie on.
    fn run_on(&mut self, end: usize, unread: usize) {
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
            // The chord to a point on a circle lies half the angle off the tangent.
            let (sin, cos) = (0.5 * turn * (1.0 + far_px / way_px)).sin_cos();
            let ahead = vec2::along(vec2::scale(direction, cos), vec2::normal(direction), sin);
            let share = far_px / (unread as f32 * self.spacing_px());
            let place = self.place(end, i);
            self.next[place].at = vec2::along(vec2::along(here, ahead, far_px), aside, share);
        }
    }

    /// Gives each station the mean of what the stations around it say.
    fn average(
        &mut self,
        of: impl Fn(&Station) -> Option<f32>,
        mut put: impl FnMut(&mut Station, f32),
    ) {
        let n = self.stations.len();
        self.next.clone_from(&self.stations);
        for (i, station) in self.stations.iter_mut().enumerate() {
            let around = &self.next[i.saturating_sub(AROUND)..(i + AROUND + 1).min(n)];
            let (sum, count) = (around.iter().filter_map(&of))
                .fold((0.0, 0), |(sum, count), value| (sum + value, count + 1));
            put(station, if count > 0 { sum / count as f32 } else { 0.0 });
        }
    }

    /// Pixels that a chord is looked for in.
    fn span(&self) -> usize {
        // A chord is at most √2 widths long, twice the half of it moved aside.
        let reach_px = (std::f32::consts::FRAC_1_SQRT_2 + 1.5 * ASIDE_WIDTHS) * self.width_px + 3.0;
        (2 * reach_px.ceil() as usize).next_multiple_of(8).min(MOST)
    }

    /// How far from the curve something is the rope itself, or was or will be.
    pub(super) fn reach_px(&self) -> f32 {
        (0.5 + 2.0 * ASIDE_WIDTHS) * self.width_px + 0.5 * self.spacing_px() + 4.0
    }

    /// The points where it was last seen.
    pub(super) fn places(&self) -> impl Iterator<Item = Vec2> {
        self.stations.iter().map(|station| station.at)
    }

    /// Finds the rope in the next image; false when that takes a closer look. [`take`](Self::take) makes it so.
    pub(super) fn follow(&mut self, reader: &mut Reader) -> bool {
        self.next.clone_from(&self.stations);
        for station in &mut self.next {
            station.at = vec2::along(station.at, station.normal, station.aside_px);
        }
        let Some(mut aside_px) = self.measure(reader) else {
            return false;
        };
        if aside_px > FAR_PX {
            let Some(again_px) = self.measure(reader) else {
                return false;
            };
            aside_px = again_px;
        }
        // It runs away.
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
        for (station, at) in self.next.iter_mut().zip(self.lay.points()) {
            station.at = at;
        }
        self.length_px = length_px;
        set_normals(&mut self.next);
        true
    }

    /// Moves the stations to where their chords say that the rope is; returns how far that was in the mean, nothing
    /// when too many have none.
    fn measure(&mut self, reader: &mut Reader) -> Option<f32> {
        let span = self.span();
        let n = self.next.len();
        let (mut lost, mut measured) = (0usize, 0usize);
        for i in 0..n {
            let near = self.nearness(i);
            let station = &mut self.next[i];
            let reading = read(reader, station, near, span);
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
        let sum = self.settle(first, last);
        self.run_on(0, first);
        self.run_on(1, n - 1 - last);
        for (station, was) in self.next.iter_mut().zip(&self.stations) {
            station.aside_px = vec2::dot(vec2::sub(station.at, was.at), was.normal);
        }
        set_normals(&mut self.next);
        Some(sum / n as f32)
    }

    /// Moves the stations from `first` to `last` to where they were read, and those in between that were not to where
    /// the rope bends least; returns how far they moved, in all.
    fn settle(&mut self, first: usize, last: usize) -> f32 {
        let samples = &mut self.line.samples;
        samples.clear();
        let stations = &mut self.next[first..=last];
        samples.extend(stations.iter().map(|station| Sample {
            at: vec2::along(station.at, station.normal, station.aside_px),
            weight: f32::from(u8::from(station.is_measured)),
            width_px: station.width_px,
            side: 0.0,
        }));
        // A chord beside one that runs into another strand may do so a little, too.
        let mut begins = None;
        for i in 0..stations.len() {
            match (begins, stations[i].is_measured) {
                (None, false) => begins = Some(i),
                (Some(from), true) => {
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
        sum
    }

    /// Takes what [`follow`](Self::follow) found, into `curve` as well.
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

/// How a station is read.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Near {
    /// Not at all.
    Tip,
    /// Straight across.
    BeforeTip,
    /// By the chord.
    Rope,
}

/// The rope at a station, if it can be the rope.
fn read(reader: &mut Reader, station: &Station, near: Near, span: usize) -> Option<Reading> {
    if station.is_crossed {
        return None;
    }
    let level = 0.5 * station.contrast;
    let (aside_px, width_px, contrast) = match near {
        Near::Tip => return None,
        Near::BeforeTip => {
            let limit_px = 0.5 * span as f32;
            let out = [station.normal, vec2::scale(station.normal, -1.0)];
            let [right, left] = out.map(|out| fall(reader, station.at, out, level, limit_px));
            let (right, left) = (right?, left?);
            (0.5 * (right - left), right + left, station.contrast)
        }
        Near::Rope => {
            let axis = axis(station.normal);
            let chord = reader.chord(&Where {
                at: station.at,
                axis,
                span: if axis == 0 {
                    span.next_multiple_of(64)
                } else {
                    span
                },
                level,
            })?;
            let aside_px = vec2::dot(vec2::sub(chord.at, station.at), station.normal);
            let width_px = chord.length_px * station.normal[axis].abs();
            (aside_px, width_px, chord.contrast)
        }
    };
    let fits = WIDTH.contains(&((width_px - station.bias_px[1]) / station.width_px.max(0.1)))
        && CONTRAST.contains(&(contrast / station.contrast))
        && aside_px.abs() <= ASIDE_WIDTHS * station.width_px + 1.0;
    fits.then_some(Reading {
        aside_px,
        width_px,
        contrast,
    })
}

/// How far beyond the last station at an end the rope goes on; nothing where it does not end nearby.
fn beyond(reader: &Reader, stations: &[Station], end: usize, width_px: f32) -> Option<f32> {
    let n = stations.len();
    let at = |i: usize| &stations[if end == 0 { i } else { n - 1 - i }];
    let spacing_px = vec2::distance(at(0).at, at(1).at).max(0.1);
    let back = ((0.5 * width_px / spacing_px) as usize).clamp(1, n / 4);
    let out = vec2::unit_or(vec2::sub(at(0).at, at(back).at), [1.0, 0.0]);
    let within_px = TIP_WIDTHS * width_px;
    let from = vec2::along(at(0).at, out, -within_px);
    let level = 0.5 * at(back + 1).contrast;
    let far_px = fall(reader, from, out, level, 2.0 * within_px + 3.0)?;
    Some(far_px - within_px)
}

/// How far from a place, in a direction, the difference falls below a level; nothing where it lies below it from the
/// start, up to a limit or to the image's border.
fn fall(reader: &Reader, from: Vec2, out: Vec2, level: f32, limit_px: f32) -> Option<f32> {
    let limits = [reader.image.width(), reader.image.height()];
    let (mut far_px, mut before) = (0.0, f32::INFINITY);
    while far_px <= limit_px {
        let place = vec2::along(from, out, far_px);
        let holds = (0..2).all(|c| place[c] >= 0.0 && place[c] <= (limits[c] - 1) as f32);
        if !holds {
            return None;
        }
        let value = difference(reader, place, color::between(reader.image, place));
        if value < level {
            let part = (before - level) / (before - value).max(1e-3);
            return before.is_finite().then_some(far_px - 1.0 + part);
        }
        before = value;
        far_px += 1.0;
    }
    None
}

/// How unlike the table a color at a place is.
fn difference(reader: &Reader, at: Vec2, color: [f32; 3]) -> f32 {
    let table = reader
        .background
        .at(at[0].max(0.0) as usize, at[1].max(0.0) as usize);
    color::distance(color, table, color::is_yuv(reader.image.format()))
}

/// Along which the rope with this normal is cut at the steeper angle: 0 is a row, 1 a column.
fn axis([x, y]: Vec2) -> usize {
    usize::from(y.abs() > x.abs())
}

fn set_normals(stations: &mut [Station]) {
    let n = stations.len();
    for i in 0..n {
        let (a, b) = (i.saturating_sub(1), (i + 1).min(n - 1));
        let tangent = vec2::sub(stations[b].at, stations[a].at);
        stations[i].normal = vec2::normal(vec2::unit_or(tangent, [1.0, 0.0]));
    }
}
