//! Ropes followed from one image to the next, where nothing else happens: a fraction of the work of a whole extraction.
//!
//! On a plain table by what differs from it (`chords`), on any other ground, and where a tip lies against a strand, by their
//! edges ([`contours`]).

mod chords;
mod contours;
mod crossings;
mod lay;

use crate::image::Image;
use crate::mask::Masker;
use crate::scene::{Crossing, Curve};
use crate::vec2::Vec2;
use chords::ChordFollower;
use contours::ContourFollower;

/// Frames that ropes are followed before they are extracted again: a second at a camera's usual rate.
const MOST_FRAMES: u32 = 30;
/// Frames after which ropes that are plain to see are followed.
const SETTLED: u32 = 3;
/// And those of a mask that was given.
const TOLD: u32 = 1;

/// What is known of the ropes that can be followed.
#[derive(Debug, Default)]
pub(crate) struct Follower {
    chords: ChordFollower,
    contours: ContourFollower,
    /// Frames in a row in which all ropes were seen, and nothing else.
    plain_frames: u32,
    /// Whether there was ever an image to follow ropes into: who gives a mask for each needs nothing learnt.
    is_wanted: bool,
}

impl Follower {
    /// Makes room for so many ropes of so many points each, in images of this size.
    pub(crate) fn reserve(&mut self, ropes: usize, points: usize, size: [usize; 2]) {
        self.contours.reserve(ropes, points, size);
    }

    /// Notes that ropes are to be followed; says whether there are some that can be.
    pub(crate) fn is_ready(&mut self) -> bool {
        self.is_wanted = true;
        self.chords.is_ready() || self.contours.is_ready()
    }

    /// The next image is extracted whole.
    pub(crate) fn drop(&mut self) {
        self.chords.drop();
        self.contours.drop();
        self.plain_frames = 0;
    }

    /// The next image is another scene's.
    pub(crate) fn forget(&mut self) {
        self.drop();
        self.contours.forget();
        self.is_wanted = false;
    }

    /// Follows the ropes into `image`, the next one, moving `curves` and `crossings` with them. False when the image
    /// has to be extracted whole; then they mean nothing.
    pub(crate) fn follow(
        &mut self,
        image: &Image,
        masker: &Masker,
        curves: &mut [Curve],
        crossings: &mut [Crossing],
    ) -> bool {
        if self.chords.is_ready() {
            return (self.chords).follow(image, &masker.background, curves, crossings);
        }
        self.contours.follow(image, curves, crossings)
    }

    /// Lets ropes just extracted be followed from here on. `is_plain`: there are some, all of them were seen, and nothing lies
    /// over them.
    pub(crate) fn anchor(
        &mut self,
        image: &Image,
        masker: &Masker,
        curves: &[Curve],
        crossings: &[Crossing],
        is_plain: bool,
    ) {
        self.chords.drop();
        self.contours.drop();
        self.plain_frames = if is_plain { self.plain_frames + 1 } else { 0 };
        let seen_frames = self.contours.know(curves);
        let is_table = masker.notice.is_none() && !masker.is_smoothed;
        let is_within = |curve: &Curve| !curve.closed && curve.border == [false; 2];
        if let Some(cut) = masker.cut.filter(|_| is_table)
            && curves.iter().all(is_within)
        {
            if self.plain_frames >= SETTLED {
                (self.chords).anchor(image, &masker.background, cut, curves, crossings);
            }
            // Of several ropes that touch each other edges do not tell which is whose.
            if self.chords.is_ready() || curves.len() > 1 {
                return;
            }
        }
        // A mask that was given is taken at its word.
        let is_told = masker.is_given && !masker.is_sought;
        let least = if is_told { TOLD } else { SETTLED };
        if is_plain && seen_frames >= least && (self.is_wanted || !is_told) {
            self.contours.anchor(image, curves, crossings);
        }
    }
}

/// Along which a rope with this normal is cut at the steeper angle: 0 is a row, 1 a column.
#[inline(always)]
fn axis([x, y]: Vec2) -> usize {
    usize::from(y.abs() > x.abs())
}

/// The largest whole number up to `value`, from 0 on. What a float's last bit stands for is 1 from 2²³ on: so it is
/// converted without a question about each.
#[inline(always)]
fn whole(value: f32) -> i32 {
    const ONES: f32 = 8_388_608.0;
    let value = if value > 0.0 { value.floor() } else { 0.0 };
    let value = if value < ONES { value } else { 0.0 };
    (value + ONES).to_bits().cast_signed() - ONES.to_bits().cast_signed()
}
