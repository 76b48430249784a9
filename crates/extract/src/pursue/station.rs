//! A point of a rope that is followed, and how the rope is read there.

use super::chord::{Reader, Where};
use super::narrow::{self, SIDE};
use super::profile::{Lanes, Work};
use crate::color;
use crate::vec2::{self, Vec2};

/// How far a rope may have moved aside from where it is expected, in widths and at most in pixels more.
pub(super) const ASIDE_WIDTHS: f32 = 0.6;
/// How much a chord's width may differ from the rope's there.
const WIDTH: std::ops::RangeInclusive<f32> = 0.78..=1.28;
/// How much its contrast may.
const CONTRAST: std::ops::RangeInclusive<f32> = 0.7..=1.4;
/// A tip may move this far along the rope from one frame to the next, in widths.
pub(super) const TIP_WIDTHS: f32 = 0.75;

/// A point of the curve.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Station {
    pub(super) at: Vec2,
    pub(super) normal: Vec2,
    /// The width there.
    pub(super) width_px: f32,
    /// The difference in the middle of the rope.
    pub(super) contrast: f32,
    /// What chords say too much: how far aside of the curve, and of the width.
    pub(super) bias_px: [f32; 2],
    /// Whether it was read.
    pub(super) is_measured: bool,
    /// Whether a strand that crosses here lies in its chord.
    pub(super) is_crossed: bool,
    /// How far it moved aside in the last frame.
    pub(super) aside_px: f32,
}

/// One chord, read at a station.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reading {
    pub(super) aside_px: f32,
    pub(super) width_px: f32,
    pub(super) contrast: f32,
}

/// Reads the rope at each station. As one piece of work, so that all of it is compiled for the widest registers.
pub(super) struct ReadAll<'a, 'b> {
    pub(super) reader: &'a Reader<'b>,
    pub(super) stations: &'a [Station],
    pub(super) readings: &'a mut [Option<Reading>],
    /// Stations from either end that are not read, and those from there on that are read straight across.
    pub(super) near_tip: [usize; 2],
    pub(super) span: usize,
}

impl Work for ReadAll<'_, '_> {
    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let n = self.stations.len();
        let both = self
            .stations
            .chunks(SIDE)
            .zip(self.readings.chunks_mut(SIDE));
        for (k, (stations, readings)) in both.enumerate() {
            let mut wanted = [false; SIDE];
            for (i, (wanted, station)) in wanted.iter_mut().zip(stations).enumerate() {
                let i = SIDE * k + i;
                *wanted = i.min(n - 1 - i) >= self.near_tip[1] && !station.is_crossed;
            }
            let found = narrow::chords(self.reader, lanes, stations, &wanted);
            for (i, (station, reading)) in stations.iter().zip(readings).enumerate() {
                *reading = if found.found[i] {
                    Some(Reading {
                        aside_px: found.aside_px[i],
                        width_px: found.width_px[i],
                        contrast: found.contrast[i],
                    })
                } else if found.farther[i] {
                    farther(self.reader, lanes, station, self.span)
                } else {
                    None
                };
                *reading = reading.filter(|reading| fits(station, reading));
            }
        }
        let ends = n.min(self.near_tip[1]);
        for i in (self.near_tip[0]..ends).flat_map(|i| [i, n - 1 - i]) {
            let station = &self.stations[i];
            let reading = (!station.is_crossed).then(|| straight(self.reader, station, self.span));
            self.readings[i] = reading.flatten().filter(|reading| fits(station, reading));
        }
    }
}

/// The chord at a station, looked for in as many pixels as a rope may have moved.
#[inline(always)]
fn farther(reader: &Reader, lanes: impl Lanes, station: &Station, span: usize) -> Option<Reading> {
    let axis = axis(station.normal);
    let chord = reader.chord(
        lanes,
        &Where {
            at: station.at,
            axis,
            span,
            level: 0.5 * station.contrast,
        },
    )?;
    Some(Reading {
        aside_px: vec2::dot(vec2::sub(chord.at, station.at), station.normal),
        width_px: chord.length_px * station.normal[axis].abs(),
        contrast: chord.contrast,
    })
}

/// The rope at a station near a tip, straight across.
#[inline(always)]
fn straight(reader: &Reader, station: &Station, span: usize) -> Option<Reading> {
    let (level, limit_px) = (0.5 * station.contrast, 0.5 * span as f32);
    let out = [station.normal, vec2::scale(station.normal, -1.0)];
    let [right, left] = out.map(|out| fall(reader, station.at, out, level, limit_px));
    let (right, left) = (right?, left?);
    Some(Reading {
        aside_px: 0.5 * (right - left),
        width_px: right + left,
        contrast: station.contrast,
    })
}

/// Whether what was read at a station can be the rope.
#[inline(always)]
fn fits(station: &Station, reading: &Reading) -> bool {
    let width_px = reading.width_px - station.bias_px[1];
    WIDTH.contains(&(width_px / station.width_px.max(0.1)))
        && CONTRAST.contains(&(reading.contrast / station.contrast))
        && reading.aside_px.abs() <= ASIDE_WIDTHS * station.width_px + 1.0
}

/// How far beyond the last station at an end the rope goes on; nothing where it does not end nearby.
pub(super) fn beyond(
    reader: &Reader,
    stations: &[Station],
    end: usize,
    width_px: f32,
) -> Option<f32> {
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
#[inline(always)]
fn fall(reader: &Reader, from: Vec2, out: Vec2, level: f32, limit_px: f32) -> Option<f32> {
    let limits = [reader.image.width(), reader.image.height()];
    let table = table(reader, from);
    let yuv = color::is_yuv(reader.image.format());
    let (mut far_px, mut before) = (0.0, f32::INFINITY);
    while far_px <= limit_px {
        let place = vec2::along(from, out, far_px);
        let holds = (0..2).all(|c| place[c] >= 0.0 && place[c] <= (limits[c] - 1) as f32);
        if !holds {
            return None;
        }
        let value = color::distance(color::between(reader.image, place), table, yuv);
        if value < level {
            let part = (before - level) / (before - value).max(1e-3);
            return before.is_finite().then_some(far_px - 1.0 + part);
        }
        before = value;
        far_px += 1.0;
    }
    None
}

/// The table's color at a place.
#[inline(always)]
pub(super) fn table(reader: &Reader, at: Vec2) -> [f32; 3] {
    let [x, y] = at.map(|v| v.max(0.0) as usize);
    reader.background.at(x, y)
}

/// Along which the rope with this normal is cut at the steeper angle: 0 is a row, 1 a column.
#[inline(always)]
pub(super) fn axis([x, y]: Vec2) -> usize {
    usize::from(y.abs() > x.abs())
}

pub(super) fn set_normals(stations: &mut [Station]) {
    let n = stations.len();
    for i in 0..n {
        let (a, b) = (i.saturating_sub(1), (i + 1).min(n - 1));
        let tangent = vec2::sub(stations[b].at, stations[a].at);
        stations[i].normal = vec2::normal(vec2::unit_or(tangent, [1.0, 0.0]));
    }
}
