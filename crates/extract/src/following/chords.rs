//! Follows ropes from one frame to the next by a single chord at each of their points.
//!
//! Between two frames, a rope mostly moves by less than its width, and nothing else happens. Its
//! points are then found again along their normals (measurement lines as in Blake and Isard,
//! "Active Contours", 1998). The middle of the chord that a row or column of pixels cuts out of the
//! rope is on the centerline. The image of the last full extraction is the reference. It shows how
//! each chord deviates from the centerline and the width. These biases are learned there and
//! subtracted afterwards, so that following agrees with extraction. A chord in a crossing belongs
//! to neither strand, and its point moves with its neighbors.
//!
//! A few rows of the rest of the image, different ones in each frame, show whether something is
//! new. Anything unexpected leads to a full extraction: missing chords, a tip that jumps, other
//! crossings, a new object elsewhere.

mod chase;
mod chord;
mod learn;
mod narrow;
mod profile;
mod rope;
mod station;
mod sweep;

use super::crossings::{carry, note};
use crate::image::{Image, PixelFormat};
use crate::mask::background::Background;
use crate::scene::{Crossing, Curve};
use chord::Reader;
use rope::Rope;
use sweep::Sweep;

/// State of the ropes that can be followed.
#[derive(Debug, Default)]
pub(super) struct ChordFollower {
    sweep: Sweep,
    ropes: Vec<Rope>,
    /// Number of ropes that are followed. 0 if none are.
    count: usize,
    /// Size of the reference image.
    size: [usize; 2],
    format: Option<PixelFormat>,
    /// Minimum difference from the table that is rope.
    cut: u8,
}

impl ChordFollower {
    /// Returns whether there are ropes that may be followed into the next image.
    pub(super) fn is_ready(&self) -> bool {
        self.count > 0
    }

    /// Forgets the ropes. The next image gets a full extraction.
    pub(super) fn drop(&mut self) {
        self.count = 0;
    }

    /// Learns the ropes that were just extracted from `image`. All of them must be seen.
    pub(super) fn anchor(
        &mut self,
        image: &Image,
        background: &Background,
        cut: u8,
        curves: &[Curve],
        crossings: &[Crossing],
    ) {
        self.count = 0;
        (self.size, self.format, self.cut) =
            ([image.width(), image.height()], Some(image.format()), cut);
        if self.ropes.len() < curves.len() {
            self.ropes.resize_with(curves.len(), Rope::default);
        }
        let reader = Reader { image, background };
        let ropes = &mut self.ropes[..curves.len()];
        let anchored = (ropes.iter_mut().zip(curves)).all(|(rope, curve)| rope.anchor(curve));
        if anchored {
            note(ropes, crossings);
            if ropes.iter_mut().all(|rope| rope.learn(&reader)) {
                self.count = curves.len();
            }
        }
    }

    /// Follows the ropes into `image`, which is the next one, and moves `curves` and `crossings`
    /// with them. Returns false if the image needs a full extraction. The curves and crossings are
    /// then meaningless.
    pub(super) fn follow(
        &mut self,
        image: &Image,
        background: &Background,
        curves: &mut [Curve],
        crossings: &mut [Crossing],
    ) -> bool {
        let same = self.size == [image.width(), image.height()];
        let ready = self.is_ready() && self.count == curves.len();
        if !ready || !same || self.format != Some(image.format()) {
            self.count = 0;
            return false;
        }
        let reader = Reader { image, background };
        let ropes = &mut self.ropes[..self.count];
        note(ropes, crossings);
        self.sweep.begin(image.width(), image.height());
        for rope in &mut *ropes {
            for at in rope.places() {
                self.sweep.note(at, rope.reach_px());
            }
        }
        let found = !self.sweep.finds(&reader, self.cut)
            && ropes.iter_mut().all(|rope| rope.follow(&reader));
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
