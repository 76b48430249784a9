//! The ropes as they were last followed, or seen without a doubt.
//!
//! Where ropes are tangled, one image may show them as others. What is unsure of its order is believed where it is what was
//! followed, for long enough, before.

use crate::scene::Curve;
use crate::vec2::{self, Vec2};

/// How long ropes are to be seen whole for that, and for how long they are then known.
const SURE_NS: u64 = 1_000_000_000;
const KNOWN_NS: u64 = 1_000_000_000;
/// Widths that a point may be away from where it was, at once and after that time, and the share of them that keep to it.
const AWAY_WIDTHS: (f32, f32) = (1.5, 4.0);
const KEPT: f32 = 0.95;
/// How much longer or shorter the rope may be.
const LENGTH: f32 = 0.05;

/// A rope.
#[derive(Debug, Default)]
struct Rope {
    track: u32,
    points: Vec<Vec2>,
    length_px: f32,
    closed: bool,
}

/// All of them; the first `count` are known, the rest is memory.
#[derive(Debug, Default)]
pub(super) struct KnownRopes {
    ropes: Vec<Rope>,
    count: usize,
    /// Since when they have been known, and when they were last seen.
    since_ns: u64,
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

    /// Notes where the ropes of an image are.
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

    /// Whether they were seen whole for long enough.
    fn is_sure(&self) -> bool {
        self.count > 0 && self.seen_ns.saturating_sub(self.since_ns) >= SURE_NS
    }

    /// Whether these are the known ropes and no others, each where it may have come to since, and known for long enough.
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
    /// Whether a curve is the rope, after so long a time.
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
