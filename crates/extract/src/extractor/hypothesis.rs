//! A hypothesis of the ropes in an image: the curves traced in one mask.

use crate::judge::remainder::Remainder;
use crate::judge::{self, Class, Context, Verdict};
use crate::scene::Curve;
use crate::tracking::track::Appearance;

/// Minimum probability of a curve that is more likely a whole rope than not.
pub(super) const SURE: f32 = 0.5;
/// Probability below which a curve is not worth reporting where the network sees more or nothing:
/// four of five such curves are wrong.
pub(super) const UNLIKELY: f32 = 0.2;

/// Returns whether a curve with this verdict is probably neither a rope nor a fragment of one.
pub(super) fn is_thing(verdict: Verdict) -> bool {
    verdict.confidence < SURE && verdict.other != Class::Fragment
}

/// Curves traced in a mask, judged but not yet tracked. Hypotheses of the same image are compared;
/// one of them is reported.
#[derive(Debug, Default)]
pub(super) struct Hypothesis {
    /// The first `count` are this image's; the rest is memory.
    pub(super) curves: Vec<Curve>,
    pub(super) count: usize,
    /// Properties of each curve, besides its shape, that the tracker needs.
    pub(super) appearances: Vec<Appearance>,
    /// The part of the mask that no curve runs through.
    pub(super) remainder: Remainder,
    /// True if something is too wide for a rope, and is not a gripper over a known rope.
    pub(super) has_wide: bool,
    /// True if an object is over the ropes.
    pub(super) has_occluder: bool,
    /// True if there are more ropes than are reported.
    pub(super) is_crowded: bool,
    /// True if a curve was dropped that may be a rope.
    pub(super) has_dropped: bool,
}

impl Hypothesis {
    /// Reserves memory for a picture of this size with this many curves.
    pub(super) fn reserve(&mut self, [width, height]: [usize; 2], curves: usize) {
        self.appearances.reserve(curves);
        self.remainder.reserve(width, height);
    }

    /// This image's curves.
    pub(super) fn seen(&self) -> &[Curve] {
        &self.curves[..self.count]
    }

    /// Width of the widest curve, in pixels.
    pub(super) fn widest_px(&self) -> f32 {
        let widths = self.seen().iter().map(|curve| curve.width_px);
        widths.fold(0.0, f32::max)
    }

    /// Total length of the curves, in pixels.
    pub(super) fn length_px(&self) -> f32 {
        self.seen().iter().map(|curve| curve.length_px).sum()
    }

    /// Judges each curve by itself and by the others.
    pub(super) fn judge(&mut self, context: &Context) {
        for i in 0..self.count {
            let left_out = self.remainder.beside(&self.curves[i]);
            let color = |k: usize| self.appearances[k].color;
            let evidence = judge::evidence((self.seen(), color), i, left_out, context);
            self.curves[i].confidence = evidence.verdict(false).confidence;
            self.appearances[i].evidence = evidence;
        }
    }

    /// Returns whether curve `i` is probably a thing: neither a rope nor a fragment of one.
    pub(super) fn is_thing(&self, i: usize) -> bool {
        is_thing(self.appearances[i].evidence.verdict(false))
    }

    /// Expected length of right rope, in pixels, less what a wrong curve costs. Curves that are
    /// [`UNLIKELY`] are worth nothing.
    pub(super) fn score(&self) -> f32 {
        let worth = |curve: &Curve| (curve.confidence - UNLIKELY).max(0.0) * curve.length_px;
        self.seen().iter().map(worth).sum()
    }
}
