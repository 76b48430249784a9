//! Follows ropes on any background by their two edges.
//!
//! The method is that of [chords](super::chords), without a model of the table. The image of the
//! last full extraction is the reference. It shows the rope's own color at each of its points.
//! Anything far from that color is ground, whatever the ground's color is. Along a pixel row, the
//! difference from the rope's color grows in proportion to the ground's share of each pixel. An
//! edge is therefore where the difference passes half of its value outside, to a tenth of a pixel.
//! The ground is measured again in each frame, so the rope may move over it, and the camera over
//! both.
//!
//! The edges of each point are read separately (measurement lines as in Blake and Isard, "Active
//! Contours", 1998). If one edge lacks contrast, the other one and the width decide. A reading that
//! differs from those around it is dropped. Points without a reading, under a hand or in a
//! crossing, move with their neighbors. An object over a rope between its tips may stay there and
//! move along it ([`cover`]). Anything else unexpected leads to a full extraction.

mod beside;
mod cover;
mod edge;
mod ends;
mod learn;
mod looks;
mod motion;
mod novelty;
mod read;
mod rope;
mod station;

use super::crossings::{carry, note};
use crate::image::{Image, PixelFormat};
use crate::scene::{Crossing, Curve};
use beside::note_neighbors;
use novelty::Novelty;
use rope::Rope;

/// Knowledge of the ropes besides their positions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trust {
    /// True if the ropes are where they were before. Their confidence then does not matter.
    pub(super) is_known: bool,
    /// True if they are on a plain table, where every edge can be read.
    pub(super) is_table: bool,
    /// True if they are too uncertain to be followed where they touch.
    pub(super) is_simple: bool,
    /// True if they are followed for a moment only, in which any change to them is visible.
    pub(super) is_brief: bool,
}

/// State of the ropes that can be followed.
#[derive(Debug, Default)]
pub(super) struct ContourFollower {
    novelty: Novelty,
    ropes: Vec<Rope>,
    /// Number of ropes that are followed. 0 if none are.
    count: usize,
    /// Size of the reference image.
    size: [usize; 2],
    format: Option<PixelFormat>,
}

impl ContourFollower {
    /// Allocates buffers for this many ropes and points, in images of this size.
    pub(super) fn reserve(&mut self, ropes: usize, points: usize, [width, height]: [usize; 2]) {
        let most = ropes.max(self.ropes.len());
        self.ropes.resize_with(most, Rope::default);
        self.ropes.iter_mut().for_each(|rope| rope.reserve(points));
        self.novelty.reserve(width, height);
    }

    /// Returns whether there are ropes that may be followed into the next image.
    pub(super) fn is_ready(&self) -> bool {
        self.count > 0
    }

    /// Forgets the ropes. The next image gets a full extraction.
    pub(super) fn drop(&mut self) {
        self.count = 0;
    }

    /// Learns the ropes that were just extracted from `image`. All of them must be at least partly
    /// seen.
    pub(super) fn anchor(
        &mut self,
        image: &Image,
        curves: &[Curve],
        crossings: &[Crossing],
        trust: Trust,
    ) {
        self.count = 0;
        (self.size, self.format) = ([image.width(), image.height()], Some(image.format()));
        if self.ropes.len() < curves.len() {
            self.ropes.resize_with(curves.len(), Rope::default);
        }
        let ropes = &mut self.ropes[..curves.len()];
        for rope in &mut *ropes {
            (rope.is_on_table, rope.is_brief) = (trust.is_table, trust.is_brief);
        }
        if !(ropes.iter_mut().zip(curves)).all(|(rope, curve)| rope.anchor(curve, trust.is_known)) {
            return;
        }
        note(ropes, crossings);
        note_neighbors(ropes);
        let is_unsure = |rope: &Rope| rope.may_slide() || trust.is_simple && rope.touches();
        if !trust.is_brief && ropes.iter().any(is_unsure) {
            return;
        }
        if ropes.iter_mut().all(|rope| rope.learn(image)) {
            // Overlaps in the reference image are accepted.
            station::come_together(ropes);
            ropes.iter_mut().for_each(Rope::keep_together);
            self.count = curves.len();
            self.novelty.keep(image, &self.ropes[..self.count]);
        }
    }

    /// Follows the ropes into `image`, which is the next one, and moves `curves` and `crossings`
    /// with them. Returns false if the image needs a full extraction. The curves and crossings are
    /// then meaningless.
    pub(super) fn follow(
        &mut self,
        image: &Image,
        curves: &mut [Curve],
        crossings: &mut [Crossing],
    ) -> bool {
        let same = self.size == [image.width(), image.height()];
        let ready = self.is_ready() && self.count == curves.len();
        if !ready || !same || self.format != Some(image.format()) {
            self.count = 0;
            return false;
        }
        let ropes = &mut self.ropes[..self.count];
        note(ropes, crossings);
        note_neighbors(ropes);
        ropes.iter().for_each(|rope| rope.fetch(image));
        let is_brief = ropes.iter().all(|rope| rope.is_brief);
        let found = !self.novelty.is_in(image, ropes)
            && ropes
                .iter_mut()
                .all(|rope| (is_brief || !rope.may_slide()) && rope.follow(image))
            && (!station::come_together(ropes) || is_brief);
        if !found {
            self.count = 0;
            return false;
        }
        for (rope, curve) in ropes.iter_mut().zip(&mut *curves) {
            rope.take(curve);
        }
        let carried = crossings.iter_mut().all(|crossing| carry(curves, crossing));
        if !carried {
            self.count = 0;
        }
        carried
    }
}
