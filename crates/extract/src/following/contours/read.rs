//! Reads the edges at all of a rope's points.

use super::edge::{self, WINDOW};
use super::looks::{self, Looks};
use super::station::Station;
use crate::following::axis;
use crate::image::Image;
use lariat_portable::{Simd, WithSimd};

/// Minimum share of other colors, in the pixels where the rope should be, for a point to be
/// covered.
const COVERED: f32 = 0.6;

/// Readings at a point.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Measurement {
    /// Distance of each edge from its expected place, along the normal.
    pub(super) off_px: [Option<f32>; 2],
    /// Difference half-way between rope and ground, at each edge.
    pub(super) levels: [f32; 2],
    /// True if something else is where the rope should be.
    pub(super) is_covered: bool,
}

/// Reads the edges at each wanted point. It is one work item, so that all of it is compiled for the
/// widest registers.
pub(super) struct ReadAll<'a, 'b> {
    pub(super) image: &'a Image<'b>,
    pub(super) looks: &'a Looks,
    pub(super) stations: &'a [Station],
    pub(super) wanted: &'a [bool],
    /// For each point, which edges show.
    pub(super) shown: &'a [[bool; 2]],
    pub(super) readings: &'a mut [Measurement],
}

impl WithSimd for ReadAll<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let places = self.stations.iter().zip(self.shown);
        let all = places.zip(self.wanted).zip(self.readings);
        for (((station, &shown), &wanted), reading) in all {
            *reading = Measurement::default();
            if wanted {
                *reading = both(self.image, self.looks, station, shown);
            }
        }
    }
}

/// Reads both edges at a point.
#[inline(always)]
fn both(image: &Image, looks: &Looks, station: &Station, shown: [bool; 2]) -> Measurement {
    let mut reading = Measurement::default();
    let (mut body, mut other) = (0, 0);
    for side in (0..2).filter(|&side| shown[side]) {
        let Some(window) = Window::of(image, looks, station, side) else {
            continue;
        };
        // Pixels between the rope's middle and the expected edge.
        let to = (window.expected - 0.5).max(0.0) as u32;
        let from = (window.expected - window.half_px).max(0.0) as u32;
        let within = ((1u32 << to.min(16)) - 1) & !((1u32 << from.min(16)) - 1);
        body += within.count_ones();
        other += (u32::from(window.strange) & within).count_ones();
        if let Some(edge) = edge::find(window.ground, &window.differences, window.expected) {
            reading.off_px[side] = Some((edge.at - window.expected) * window.outward);
            reading.levels[side] = edge.level;
        }
    }
    reading.is_covered = body > 0 && other as f32 >= COVERED * body as f32;
    reading
}

/// A row or a column of pixels across an edge, from the rope outward.
struct Window {
    ground: u16,
    /// Bits of the pixels that do not look like the rope.
    strange: u16,
    differences: [u8; WINDOW],
    /// Expected position of the edge.
    expected: f32,
    /// Distance from it to the rope's middle, along the row or column.
    half_px: f32,
    /// Distance along the normal of one pixel outward.
    outward: f32,
}

impl Window {
    /// `None` if it does not fit into the image.
    #[inline(always)]
    fn of(image: &Image, looks: &Looks, station: &Station, side: usize) -> Option<Self> {
        let axis = axis(station.normal);
        let size = [image.width(), image.height()];
        let [slope, across] = [station.normal[axis], station.normal[1 - axis]];
        let line = station.at[1 - axis] + 0.5;
        if !(line >= 0.0 && line < size[1 - axis] as f32) {
            return None;
        }
        let line = line as usize;
        let beside = across * (line as f32 - station.at[1 - axis]);
        let way_px = (station.edges_px[side] - beside) / slope;
        let place = station.at[axis] + way_px;
        let last = (size[axis] - WINDOW) as f32;
        let from = (place + 0.5 - (WINDOW / 2) as f32).clamp(0.0, last) as usize;
        let expected = place - from as f32;
        if !(expected >= *edge::INNER.start() as f32 && expected <= *edge::INNER.end() as f32) {
            return None;
        }
        let mut first = [line; 2];
        first[axis] = from;
        let pixels = looks::pixels(image, first, axis);
        let mut differences = looks.distances(&pixels, &station.color);
        let is_up = (side == 1) == (slope > 0.0);
        if !is_up {
            differences.reverse();
        }
        let expected = if is_up {
            expected
        } else {
            (WINDOW - 1) as f32 - expected
        };
        let half_px = (0.5 * station.width_px / slope).abs();
        let cut = edge::cut(
            &differences,
            [expected - half_px, expected],
            station.cuts[side],
        );
        Some(Self {
            ground: edge::ground(&differences, cut),
            strange: edge::ground(&differences, looks.strange),
            differences,
            expected,
            half_px,
            outward: if is_up { slope } else { -slope },
        })
    }
}
