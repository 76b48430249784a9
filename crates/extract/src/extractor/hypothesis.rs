//! A hypothesis of the ropes in an image: the curves traced in one mask.

use crate::confidence::remainder::Remainder;
use crate::scene::Curve;
use crate::tracking::track::Appearance;

/// Curves traced in a mask, and what is known of them before they are judged. Hypotheses of the same
/// image are compared; one of them is reported.
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

    /// Mean confidence of the curves, weighted by length; 0 without curves.
    pub(super) fn mean_confidence(&self) -> f32 {
        let curves = self.seen().iter();
        let (sum, length_px) = curves.fold((0.0, 0.0), |(sum, length_px), curve| {
            (
                sum + curve.confidence * curve.length_px,
                length_px + curve.length_px,
            )
        });
        sum / f32::max(length_px, 1.0)
    }
}
