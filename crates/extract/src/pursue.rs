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
//! (chords that are missing, a tip that jumped, other crossings, something elsewhere) is left to a whole extraction, and
//! so is every [`MOST_FRAMES`]th frame.

mod chord;
mod lay;
mod rope;
mod sweep;

use crate::background::Background;
use crate::difference::Differencer;
use crate::kernels::Kernels;
use crate::meet::{Meeter, Meeting};
use crate::scene::{Crossing, Curve};
use crate::{Image, PixelFormat};
use chord::Reader;
use rope::Rope;
use sweep::Sweep;

/// Frames that ropes are followed before they are extracted again: a second at a camera's usual rate.
const MOST_FRAMES: u32 = 30;
/// How far a crossing may move along its ropes between two frames, as a share of their length.
const CROSSING: f32 = 0.03;

/// What is known of the ropes that can be followed.
#[derive(Debug, Default)]
pub(crate) struct Pursuer {
    kernels: Kernels,
    differencer: Differencer,
    sweep: Sweep,
    meeter: Meeter,
    ropes: Vec<Rope>,
    /// How many of them are followed; 0: none can be.
    count: usize,
    frames: u32,
    /// The image they were extracted from.
    size: [usize; 2],
    format: Option<PixelFormat>,
    /// From here on a difference from the table is rope.
    cut: u8,
}

impl Pursuer {
    /// Forgets the ropes: the next image is extracted whole.
    pub(crate) fn drop(&mut self) {
        self.count = 0;
    }

    /// Learns the ropes that were just extracted from `image`, all of them seen.
    pub(crate) fn anchor(
        &mut self,
        image: &Image,
        background: &Background,
        cut: u8,
        curves: &[Curve],
        crossings: &[Crossing],
    ) {
        self.count = 0;
        self.frames = 0;
        (self.size, self.format, self.cut) =
            ([image.width(), image.height()], Some(image.format()), cut);
        if self.ropes.len() < curves.len() {
            self.ropes.resize_with(curves.len(), Rope::default);
        }
        let mut reader = Reader {
            image,
            background,
            differencer: &mut self.differencer,
            kernels: self.kernels,
        };
        let ropes = &mut self.ropes[..curves.len()];
        let anchored = (ropes.iter_mut().zip(curves)).all(|(rope, curve)| rope.anchor(curve));
        if anchored {
            note(ropes, crossings);
            if ropes.iter_mut().all(|rope| rope.learn(&mut reader)) {
                self.count = curves.len();
            }
        }
    }

    /// Follows the ropes into `image`, the next one, moving `curves` and `crossings` with them. False when the image
    /// has to be extracted whole; then they mean nothing.
    pub(crate) fn pursue(
        &mut self,
        image: &Image,
        background: &Background,
        curves: &mut [Curve],
        crossings: &mut [Crossing],
    ) -> bool {
        let same = self.size == [image.width(), image.height()];
        let ready = self.count > 0 && self.count == curves.len() && self.frames < MOST_FRAMES;
        if !ready || !same || self.format != Some(image.format()) {
            self.count = 0;
            return false;
        }
        self.frames += 1;
        let mut reader = Reader {
            image,
            background,
            differencer: &mut self.differencer,
            kernels: self.kernels,
        };
        let ropes = &mut self.ropes[..self.count];
        note(ropes, crossings);
        self.sweep.begin(image.width(), image.height());
        for rope in &mut *ropes {
            for at in rope.places() {
                self.sweep.note(at, rope.reach_px());
            }
        }
        let found = !self.sweep.finds(&mut reader, self.cut)
            && ropes.iter_mut().all(|rope| rope.follow(&mut reader));
        if !found {
            self.count = 0;
            return false;
        }
        for (rope, curve) in ropes.iter_mut().zip(&mut *curves) {
            rope.take(curve);
        }
        self.meeter.find(curves);
        if !carry(&self.meeter.crossings, curves, crossings) {
            self.count = 0;
            return false;
        }
        true
    }
}

/// Lets the ropes know where others cross them.
fn note(ropes: &mut [Rope], crossings: &[Crossing]) {
    ropes.iter_mut().for_each(Rope::clear_crossings);
    for crossing in crossings {
        let over = (crossing.over, crossing.over_rho);
        let under = (crossing.under, crossing.under_rho);
        for ((rope, rho), (other, other_rho)) in [(over, under), (under, over)] {
            let (direction, width_px) = (ropes[other].direction(other_rho), ropes[other].width_px);
            ropes[rope].cross(rho, direction, width_px);
        }
    }
}

/// Moves each crossing to where the curves now meet near it; false unless they are as many, each with its own.
fn carry(meetings: &[Meeting], curves: &[Curve], crossings: &mut [Crossing]) -> bool {
    if meetings.len() != crossings.len() {
        return false;
    }
    let rho = |curve: usize, at: f32| at / curves[curve].intervals() as f32;
    for meeting in meetings {
        let [a, b] = [meeting.a, meeting.b].map(|place| (place.curve, rho(place.curve, place.at)));
        let near = |(curve, at): (usize, f32), other: usize, rho: f32| {
            curve == other && (at - rho).abs() < CROSSING
        };
        let same = crossings.iter_mut().find_map(|crossing| {
            let over = |p| near(p, crossing.over, crossing.over_rho);
            let under = |p| near(p, crossing.under, crossing.under_rho);
            if over(a) && under(b) {
                Some((crossing, a, b))
            } else if over(b) && under(a) {
                Some((crossing, b, a))
            } else {
                None
            }
        });
        let Some((crossing, over, under)) = same else {
            return false;
        };
        crossing.at = meeting.at;
        (crossing.over_rho, crossing.under_rho) = (over.1, under.1);
    }
    true
}
