//! Ropes followed from one frame to the next by reading no more than a chord at each of their points.
//!
//! Between two frames a rope moves by less than its width, and mostly nothing else happens. Then its points are found
//! again along their normals (measurement lines as in Blake and Isard, "Active Contours", 1998): where a row or column of
//! pixels runs through the rope, the middle of that chord lies on the centerline. How the chords of each point read in
//! the image where the rope was extracted whole, how far beside the centerline and how wide, is learnt there and taken
//! off afterwards, so that what is followed agrees with what is extracted. Where strands cross a chord is no strand's
//! own: those points move as their neighbors do.
//!
//! A few rows of the rest of the image, others in each frame, show whether something is new. Whatever is not as expected
//! (chords that are missing, a tip that jumped, other crossings, something elsewhere) is left to a whole extraction.

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

/// What is known of the ropes that can be followed.
#[derive(Debug, Default)]
pub(super) struct ChordFollower {
    sweep: Sweep,
    ropes: Vec<Rope>,
    /// How many of them are followed; 0: none can be.
    count: usize,
    /// The image they were extracted from.
    size: [usize; 2],
    format: Option<PixelFormat>,
    /// From here on a difference from the table is rope.
    cut: u8,
}

impl ChordFollower {
    /// Whether there are ropes that may be followed into the next image.
    pub(super) fn is_ready(&self) -> bool {
        self.count > 0
    }

    /// Forgets the ropes: the next image is extracted whole.
    pub(super) fn drop(&mut self) {
        self.count = 0;
    }

    /// Learns the ropes that were just extracted from `image`, all of them seen.
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

    /// Follows the ropes into `image`, the next one, moving `curves` and `crossings` with them. False when the image
    /// has to be extracted whole; then they mean nothing.
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
