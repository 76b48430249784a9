//! Selects the desired ropes, if only some are to be reported.

use super::Extractor;
use crate::options::Options;
use crate::scene::{Crossing, Curve, MOST_CROSSINGS};
use crate::vec2;

/// Maximum distance of a position from its rope's middle, in pixels, in addition to the rope's
/// width.
const BESIDE_PX: f32 = 8.0;

/// Memory and result of the selection.
#[derive(Debug, Default)]
pub(super) struct Meant {
    /// The number of the rope found at each position.
    tracks: Vec<Option<u32>>,
    /// The first `count` are the desired ropes; the rest is memory.
    curves: Vec<Curve>,
    count: usize,
    crossings: Vec<Crossing>,
}

impl Meant {
    /// Makes room for the positions, ropes and points of these options.
    pub(super) fn reserve(&mut self, options: &Options) {
        let &Options { ropes, points, .. } = options;
        self.tracks.resize(options.at.len(), None);
        self.curves.resize_with(ropes, Curve::default);
        for curve in &mut self.curves {
            curve.points.reserve(points);
            curve.widths_px.reserve(points);
            curve.hidden.reserve(points);
        }
        self.crossings.reserve(MOST_CROSSINGS);
    }

    /// Forgets the ropes found at the positions.
    pub(super) fn forget(&mut self) {
        self.tracks.fill(None);
        self.count = 0;
        self.crossings.clear();
    }

    /// The desired ropes and their crossings.
    pub(super) fn chosen(&self) -> (&[Curve], &[Crossing]) {
        (&self.curves[..self.count], &self.crossings)
    }

    /// Selects the ropes that were found first at the positions `at`.
    fn choose(&mut self, at: &[[f32; 2]], curves: &[Curve], crossings: &[Crossing]) {
        self.tracks.resize(at.len(), None);
        for (track, &at) in self.tracks.iter_mut().zip(at) {
            let is_there = |number: u32| curves.iter().any(|curve| curve.track == number);
            if !track.is_some_and(is_there) {
                *track = nearest(curves, at);
            }
        }
        self.count = 0;
        self.crossings.clear();
        self.crossings.extend_from_slice(crossings);
        // Crossings refer to curves by their index in the list.
        for (old, curve) in curves.iter().enumerate() {
            if !self.tracks.contains(&Some(curve.track)) {
                self.crossings.retain(|c| c.over != old && c.under != old);
                continue;
            }
            for crossing in &mut self.crossings {
                for place in [&mut crossing.over, &mut crossing.under] {
                    if *place == old {
                        *place = self.count;
                    }
                }
            }
            match self.curves.get_mut(self.count) {
                Some(known) => copy(curve, known),
                None => self.curves.push(curve.clone()),
            }
            self.count += 1;
        }
    }
}

/// A copy that allocates no memory.
fn copy(from: &Curve, to: &mut Curve) {
    let mut points = std::mem::take(&mut to.points);
    let mut widths_px = std::mem::take(&mut to.widths_px);
    let mut hidden = std::mem::take(&mut to.hidden);
    points.clone_from(&from.points);
    widths_px.clone_from(&from.widths_px);
    hidden.clone_from(&from.hidden);
    *to = Curve {
        points,
        widths_px,
        hidden,
        ..*from
    };
}

/// The number of the rope at a position.
fn nearest(curves: &[Curve], at: [f32; 2]) -> Option<u32> {
    let away = |curve: &Curve| {
        let points = curve.points.iter();
        let away_px = points.map(|&point| vec2::distance(at, point));
        away_px.fold(f32::MAX, f32::min)
    };
    let near = curves.iter().map(|curve| (away(curve), curve));
    near.filter(|(away_px, curve)| *away_px <= curve.width_px + BESIDE_PX)
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, curve)| curve.track)
}

impl Extractor {
    /// Selects the desired ropes, if not all are.
    pub(super) fn choose_meant(&mut self) {
        if !self.options.at.is_empty() {
            let curves = &self.found.curves[..self.found.count];
            self.meant.choose(&self.options.at, curves, &self.crossings);
        }
    }
}
