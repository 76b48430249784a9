//! Ropes followed on any ground, by their two edges.
//!
//! As [chords](super::chords) are, but without a table: at each of a rope's points the rope's own color is learnt where it
//! was extracted whole, and what is far from that color is ground, whatever its own may be. The difference from the rope's
//! color grows along a pixel row in proportion to the ground's share in it, so that an edge lies where it passes half of
//! what it comes to beyond: to a tenth of a pixel on any ground, and again in each frame, so that nothing of the ground has
//! to be remembered while the rope moves over it or the camera over both.
//!
//! The edges of a point are read each by itself (measurement lines as in Blake and Isard, "Active Contours", 1998). Where
//! one has no contrast the other one and the width tell; a reading that is unlike those around is dropped; and points
//! without any, under a hand or in a crossing, move as their neighbors do. What lies over a rope between its tips may stay
//! there and move along it ([`cover`]). Whatever else is not as expected is left to a
//! whole extraction.

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

/// What is known of ropes beside where they are.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trust {
    /// They are where they were, and so need not look likely by themselves.
    pub(super) is_known: bool,
    /// They lie on a plain table, where nothing keeps an edge from being read.
    pub(super) is_table: bool,
    /// They are not sure enough to be followed where they touch.
    pub(super) is_simple: bool,
    /// They are followed for a moment only, in which nothing can have become of them that does not show.
    pub(super) is_brief: bool,
}

/// What is known of the ropes that can be followed.
#[derive(Debug, Default)]
pub(super) struct ContourFollower {
    novelty: Novelty,
    ropes: Vec<Rope>,
    /// How many of them are followed; 0: none can be.
    count: usize,
    /// The image they were extracted from.
    size: [usize; 2],
    format: Option<PixelFormat>,
}

impl ContourFollower {
    /// Makes the buffers for so many ropes of so many points, in images of this size.
    pub(super) fn reserve(&mut self, ropes: usize, points: usize, [width, height]: [usize; 2]) {
        let most = ropes.max(self.ropes.len());
        self.ropes.resize_with(most, Rope::default);
        self.ropes.iter_mut().for_each(|rope| rope.reserve(points));
        self.novelty.reserve(width, height);
    }

    /// Whether there are ropes that may be followed into the next image.
    pub(super) fn is_ready(&self) -> bool {
        self.count > 0
    }

    /// Forgets the ropes: the next image is extracted whole.
    pub(super) fn drop(&mut self) {
        self.count = 0;
    }

    /// Learns the ropes that were just extracted from `image`, all of them seen at least in part.
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
            // As they were extracted is how they may lie.
            station::come_together(ropes);
            ropes.iter_mut().for_each(Rope::keep_together);
            self.count = curves.len();
            self.novelty.keep(image, &self.ropes[..self.count]);
        }
    }

    /// Follows the ropes into `image`, the next one, moving `curves` and `crossings` with them. False when the image
    /// has to be extracted whole; then they mean nothing.
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
