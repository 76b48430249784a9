//! A point of a rope that is followed, and the reading of the rope there.

use super::chord::{Reader, Where};
use super::narrow::{self, SIDE};
use super::profile::{Lanes, Work};
use super::rope::AT_TIP;
use crate::following::axis;
use crate::image::color;
use crate::vec2::{self, Vec2};

/// Maximum sideways distance of a rope from its expected place, in widths, plus a pixel.
pub(super) const ASIDE_WIDTHS: f32 = 0.6;
/// Range of a chord's width relative to the rope's width there, minus 1.
const WIDTH: [f32; 2] = [-0.22, 0.28];
/// Range of its contrast relative to the station's.
const CONTRAST: [f32; 2] = [0.7, 1.4];
/// Width, in pixels, below which these ranges are extended. The pixels of a thinner rope show as
/// much of it as happens to be in each.
const THIN_PX: f32 = 3.5;
/// Maximum movement of a tip along the rope from one frame to the next, in widths.
pub(super) const TIP_WIDTHS: f32 = 0.75;

/// Distance that a chord at the flattest angle runs along the rope, to either side, in widths.
const ALONG: f32 = 0.5;
/// Reach of the tip's blur, in pixels.
const CLEAR_PX: f32 = 1.0;
/// Distance before an edge's expected place at which the search starts, in pixels.
const BEFORE_EDGE_PX: f32 = 3.0;

/// A point of the curve.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Station {
    pub(super) at: Vec2,
    pub(super) normal: Vec2,
    /// Width of the rope there.
    pub(super) width_px: f32,
    /// Difference in the middle of the rope.
    pub(super) contrast: f32,
    /// Bias of chords: sideways from the curve, and in the width.
    pub(super) bias_px: [f32; 2],
    /// True if it was read.
    pub(super) is_measured: bool,
    /// True if its chord includes a crossing strand.
    pub(super) is_crossed: bool,
    /// Sideways movement in the last frame.
    pub(super) aside_px: f32,
}

/// A chord that was read at a station.
#[derive(Clone, Copy, Debug)]
pub(super) struct Measurement {
    pub(super) aside_px: f32,
    pub(super) width_px: f32,
    pub(super) contrast: f32,
}

/// Reads the rope at each station. It is one work item, so that all of it is compiled for the
/// widest registers.
pub(super) struct ReadAll<'a, 'b> {
    pub(super) reader: &'a Reader<'b>,
    pub(super) stations: &'a [Station],
    pub(super) readings: &'a mut [Option<Measurement>],
    /// Distance between stations.
    pub(super) spacing_px: f32,
    pub(super) width_px: f32,
    pub(super) span: usize,
}

impl Work for ReadAll<'_, '_> {
    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let n = self.stations.len();
        let beside_px = (AT_TIP + ALONG) * self.width_px + CLEAR_PX;
        // From here on, any chord is clear of the tip.
        let clear = ((beside_px / self.spacing_px).ceil() as usize).min(n / 2);
        for k in 0..n.div_ceil(SIDE) {
            let group = SIDE * k..(SIDE * (k + 1)).min(n);
            let stations = &self.stations[group.clone()];
            let mut wanted = [false; SIDE];
            for (i, (wanted, station)) in wanted.iter_mut().zip(stations).enumerate() {
                let i = SIDE * k + i;
                let from_end = i.min(n - 1 - i);
                let has_chord = from_end >= clear || self.has_chord(from_end, station);
                *wanted = has_chord && !station.is_crossed;
            }
            let found = narrow::chords(self.reader, lanes, stations, &wanted);
            let readings = &mut self.readings[group];
            for (i, (station, reading)) in stations.iter().zip(readings).enumerate() {
                *reading = if found.found[i] {
                    Some(Measurement {
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
        let at_tip = (AT_TIP * self.width_px / self.spacing_px).ceil() as usize;
        for from_end in at_tip.max(1)..clear {
            for i in [from_end, n - 1 - from_end] {
                let station = &self.stations[i];
                if !station.is_crossed && !self.has_chord(from_end, station) {
                    let reading = straight(self.reader, station, self.span);
                    self.readings[i] = reading.filter(|reading| fits(station, reading));
                }
            }
        }
    }
}

impl ReadAll<'_, '_> {
    /// Returns whether the chord at a station is clear of the tip. `from_end` is the station's
    /// number, counted from the nearer end.
    #[inline(always)]
    fn has_chord(&self, from_end: usize, station: &Station) -> bool {
        let axis = axis(station.normal);
        let slant = station.normal[1 - axis] / station.normal[axis];
        let along_px = (ALONG * self.width_px * slant).abs();
        from_end as f32 * self.spacing_px >= AT_TIP * self.width_px + along_px + CLEAR_PX
    }
}

/// Reads the chord at a station over the whole span in which the rope may be.
#[inline(always)]
fn farther(
    reader: &Reader,
    lanes: impl Lanes,
    station: &Station,
    span: usize,
) -> Option<Measurement> {
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
    Some(Measurement {
        aside_px: vec2::dot(vec2::sub(chord.at, station.at), station.normal),
        width_px: chord.length_px * station.normal[axis].abs(),
        contrast: chord.contrast,
    })
}

/// Reads the rope at a station near a tip, straight across.
#[inline(always)]
fn straight(reader: &Reader, station: &Station, span: usize) -> Option<Measurement> {
    let (level, ways_px) = (
        0.5 * station.contrast,
        [0.5 * station.width_px, 0.5 * span as f32],
    );
    let right = fall(reader, station.at, station.normal, level, ways_px)?;
    let left = vec2::scale(station.normal, -1.0);
    let left = fall(reader, station.at, left, level, ways_px)?;
    Some(Measurement {
        aside_px: 0.5 * (right - left),
        width_px: right + left,
        contrast: station.contrast,
    })
}

/// Returns whether a reading at a station can be the rope.
#[inline(always)]
fn fits(station: &Station, reading: &Measurement) -> bool {
    let thin = (THIN_PX / station.width_px.max(0.1)).max(1.0);
    let wider = (reading.width_px - station.bias_px[1]) / station.width_px.max(0.1) - 1.0;
    let contrast = reading.contrast / station.contrast;
    (WIDTH[0] * thin..=WIDTH[1] * thin).contains(&wider)
        && (CONTRAST[0] / thin..=CONTRAST[1] * thin).contains(&contrast)
        && reading.aside_px.abs() <= ASIDE_WIDTHS * station.width_px + 1.0
}

/// Distance beyond the last station at which the rope ends. `None` if it does not end nearby.
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
    let far_px = fall(reader, from, out, level, [within_px, 2.0 * within_px + 3.0])?;
    Some(far_px - within_px)
}

/// Distance from a place, in a direction, at which the difference falls below a level. The search
/// starts shortly before `near_px`. `None` if it is below that level from the start, not below it
/// up to `limit_px`, or the image ends first.
#[inline(always)]
fn fall(
    reader: &Reader,
    from: Vec2,
    out: Vec2,
    level: f32,
    [near_px, limit_px]: [f32; 2],
) -> Option<f32> {
    let limits = [reader.image.width(), reader.image.height()];
    let table = table(reader, from);
    let yuv = color::is_yuv(reader.image.format());
    let start_px = (near_px - BEFORE_EDGE_PX).floor().max(0.0);
    let (mut far_px, mut before) = (start_px, f32::INFINITY);
    while far_px <= limit_px {
        let place = vec2::along(from, out, far_px);
        let holds = (0..2).all(|c| place[c] >= 0.0 && place[c] <= (limits[c] - 1) as f32);
        if !holds {
            return None;
        }
        let value = color::distance(color::between(reader.image, place), table, yuv);
        if value >= level {
            (before, far_px) = (value, far_px + 1.0);
        } else if before.is_finite() {
            let part = (before - level) / (before - value).max(1e-3);
            return Some(far_px - 1.0 + part);
        } else if far_px > 0.0 {
            // The difference falls below the level earlier.
            far_px = 0.0;
        } else {
            return None;
        }
    }
    None
}

/// Color of the table at a place.
#[inline(always)]
pub(super) fn table(reader: &Reader, at: Vec2) -> [f32; 3] {
    let [x, y] = at.map(|v| v.max(0.0) as usize);
    reader.background.at(x, y)
}

pub(super) fn set_normals(stations: &mut [Station]) {
    let n = stations.len();
    for i in 0..n {
        let (a, b) = (i.saturating_sub(1), (i + 1).min(n - 1));
        let tangent = vec2::sub(stations[b].at, stations[a].at);
        stations[i].normal = vec2::normal(vec2::unit_or(tangent, [1.0, 0.0]));
    }
}
