//! The ropes as they were last followed, or seen without doubt.
//!
//! A single image of tangled ropes may be misread. If the order of strands is uncertain, an
//! extraction is accepted if it equals the ropes that were followed for long enough before.

use crate::scene::Curve;
use crate::vec2::{self, Vec2};

/// Minimum time for which ropes must be seen whole before they are known, in nanoseconds.
const SURE_NS: u64 = 1_000_000_000;
/// Time for which ropes then stay known, in nanoseconds.
const KNOWN_NS: u64 = 1_000_000_000;
/// Maximum movement of a point, in widths: at once, and the addition over `KNOWN_NS`.
const AWAY_WIDTHS: (f32, f32) = (1.5, 4.0);
/// Minimum share of points within it.
const KEPT: f32 = 0.95;
/// Maximum change of a rope's length, as a share.
const LENGTH: f32 = 0.05;

/// A rope.
#[derive(Debug, Default)]
struct Rope {
    track: u32,
    points: Vec<Vec2>,
    length_px: f32,
    closed: bool,
}

/// The known ropes. The first `count` are in use, and the others are kept for their memory.
#[derive(Debug, Default)]
pub(super) struct KnownRopes {
    ropes: Vec<Rope>,
    count: usize,
    /// Time since which they have been known.
    since_ns: u64,
    /// Time at which they were last seen.
    seen_ns: u64,
}

impl KnownRopes {
    pub(super) fn reserve(&mut self, ropes: usize, points: usize) {
        let most = ropes.max(self.ropes.len());
        self.ropes.resize_with(most, Rope::default);
        self.ropes
            .iter_mut()
            .for_each(|rope| rope.points.reserve(points));
    }

    pub(super) fn forget(&mut self) {
        self.count = 0;
    }

    /// Records the ropes of an image. The known time restarts if they differ from the known ropes
    /// or have hidden parts.
    pub(super) fn note(&mut self, curves: &[Curve], now_ns: u64) {
        let is_same = self.are_near(curves, now_ns);
        let is_open = !curves.iter().any(|curve| curve.hidden.contains(&true));
        if !is_same || !is_open {
            self.since_ns = now_ns;
        }
        self.seen_ns = now_ns;
        if self.ropes.len() < curves.len() {
            self.ropes.resize_with(curves.len(), Rope::default);
        }
        self.count = curves.len();
        for (rope, curve) in self.ropes.iter_mut().zip(curves) {
            rope.track = curve.track;
            rope.points.clone_from(&curve.points);
            (rope.length_px, rope.closed) = (curve.length_px, curve.closed);
        }
    }

    /// Returns whether they were seen whole for long enough.
    fn is_sure(&self) -> bool {
        self.count > 0 && self.seen_ns.saturating_sub(self.since_ns) >= SURE_NS
    }

    /// Returns whether these curves are exactly the known ropes, each within its possible movement,
    /// and were known for long enough.
    pub(super) fn are(&self, curves: &[Curve], now_ns: u64) -> bool {
        self.is_sure() && self.are_near(curves, now_ns)
    }

    fn are_near(&self, curves: &[Curve], now_ns: u64) -> bool {
        let age_ns = match now_ns.checked_sub(self.seen_ns) {
            Some(age_ns) if age_ns <= KNOWN_NS => age_ns,
            _ => return false,
        };
        let ropes = &self.ropes[..self.count];
        let is_one = |curve: &Curve| {
            let rope = ropes.iter().find(|rope| rope.track == curve.track);
            rope.is_some_and(|rope| rope.is(curve, age_ns))
        };
        self.count == curves.len() && curves.iter().all(is_one)
    }
}

impl Rope {
    /// Returns whether a curve is the rope after `age_ns`.
    fn is(&self, curve: &Curve, age_ns: u64) -> bool {
        let same = self.closed == curve.closed && self.points.len() == curve.points.len();
        if !same || (curve.length_px / self.length_px - 1.0).abs() > LENGTH {
            return false;
        }
        let share = age_ns as f32 / KNOWN_NS as f32;
        let most_px = (AWAY_WIDTHS.0 + share * AWAY_WIDTHS.1) * curve.width_px;
        let is_near = |(a, b): &(&Vec2, &Vec2)| vec2::distance(**a, **b) <= most_px;
        let near = (self.points.iter().zip(&curve.points))
            .filter(is_near)
            .count();
        near as f32 >= KEPT * curve.points.len() as f32
    }
}
