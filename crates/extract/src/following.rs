//! Ropes followed from one image to the next, where nothing else happens: a fraction of the work of a whole extraction.
//!
//! On a plain table by what differs from it (`chords`), on any other ground, and where a tip lies against a strand, by their
//! edges ([`contours`]).

mod chords;
mod contours;
mod crossings;
mod known;
mod lay;

use crate::image::Image;
use crate::mask::Masker;
use crate::scene::{Crossing, Curve, Status};
use crate::vec2::Vec2;
use chords::ChordFollower;
use contours::{ContourFollower, Trust};
use known::KnownRopes;

/// How long ropes are followed before they are extracted again, at first and at most, in nanoseconds: twice as long each time
/// that a whole look shows nothing that was not known.
const LOOK_NS: (u64, u64) = (1_000_000_000, 4_000_000_000);
/// How long ropes are followed that cannot be followed for long: they are not far from where they were. Of a fast camera's images
/// one in some is then extracted whole, instead of each, for which there is no time.
const BRIEF_NS: u64 = 7_000_000;
/// Frames after which ropes that are plain to see are followed.
const SETTLED: u32 = 3;
/// And those of a mask that was given.
const TOLD: u32 = 1;

/// What is known of the ropes that can be followed.
#[derive(Debug, Default)]
pub(crate) struct Follower {
    chords: ChordFollower,
    contours: ContourFollower,
    known: KnownRopes,
    /// The numbers of the ropes that were last seen, how many crossings they made, and in how many images in a row these were seen
    /// whole.
    tracks: Vec<u32>,
    crossings: usize,
    whole_frames: u32,
    /// In how many in a row they were seen so but for parts between their tips that do not show.
    held_frames: u32,
    /// Frames in a row in which all ropes were seen, and nothing else.
    plain_frames: u32,
    /// When the ropes were last extracted, and for how long they are followed from there, in nanoseconds.
    anchored_ns: u64,
    wait_ns: u64,
    /// Whether they are followed from there for a moment only.
    is_brief: bool,
    /// When the last image was taken.
    last_ns: u64,
    /// Whether there was ever an image to follow ropes into: who gives a mask for each needs nothing learnt.
    is_wanted: bool,
}

impl Follower {
    /// Makes room for so many ropes of so many points each, in images of this size.
    pub(crate) fn reserve(&mut self, ropes: usize, points: usize, size: [usize; 2]) {
        self.contours.reserve(ropes, points, size);
        self.known.reserve(ropes, points);
        // Those that are out of sight are known, too.
        self.tracks.reserve(4 * ropes);
    }

    /// Notes that ropes are to be followed; says whether there are some that can be, into an image of this moment.
    pub(crate) fn is_ready(&mut self, now_ns: u64) -> bool {
        self.is_wanted = true;
        let wait_ns = match self.is_brief {
            true => self.wait_ns.min(BRIEF_NS),
            false => self.wait_ns,
        };
        let is_due =
            !(self.anchored_ns..self.anchored_ns.saturating_add(wait_ns)).contains(&now_ns);
        !is_due && self.is_anchored()
    }

    /// Returns true if there are ropes that can be followed.
    pub(crate) fn is_anchored(&self) -> bool {
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
        self.known.forget();
        self.tracks.clear();
        (self.whole_frames, self.held_frames) = (0, 0);
        (self.crossings, self.anchored_ns, self.wait_ns) = (0, 0, 0);
        self.last_ns = 0;
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
        now_ns: u64,
    ) -> bool {
        let found = match self.chords.is_ready() {
            true => (self.chords).follow(image, &masker.background, curves, crossings),
            false => self.contours.follow(image, curves, crossings),
        };
        if found {
            self.last_ns = now_ns;
            if !self.is_brief {
                self.known.note(curves, now_ns);
            }
        }
        found
    }

    /// Lets ropes just extracted be followed from here on. `is_seen`: there are some, and none is out of sight; `is_plain`:
    /// nothing lies over them, besides.
    pub(crate) fn anchor(
        &mut self,
        image: &Image,
        masker: &Masker,
        curves: &[Curve],
        crossings: &[Crossing],
        [is_seen, is_plain]: [bool; 2],
        now_ns: u64,
    ) {
        self.chords.drop();
        self.contours.drop();
        // What the network finds may be other things, too.
        self.know(curves, crossings, is_plain && !masker.is_sought, now_ns);
        self.plain_frames = if is_plain { self.plain_frames + 1 } else { 0 };
        let is_fast = now_ns.saturating_sub(self.last_ns) < BRIEF_NS;
        (self.is_brief, self.last_ns) = (false, now_ns);
        let is_table = masker.notice.is_none() && !masker.is_smoothed;
        let is_within = |curve: &Curve| !curve.closed && curve.border == [false; 2];
        if let Some(cut) = masker.cut.filter(|_| is_table)
            && curves.iter().all(is_within)
        {
            if self.plain_frames >= SETTLED {
                (self.chords).anchor(image, &masker.background, cut, curves, crossings);
            }
            if self.chords.is_ready() {
                self.known.note(curves, now_ns);
                return;
            }
        }
        // A mask that was given is taken at its word.
        let is_told = masker.is_given && !masker.is_sought;
        let least = if is_told { TOLD } else { SETTLED };
        let is_whole = self.whole_frames >= least;
        let is_held = self.held_frames >= SETTLED;
        let is_known = self.whole_frames > 0 && self.known.are(curves, now_ns);
        if !is_seen || is_told && !self.is_wanted {
            return;
        }
        let how = Trust {
            is_known,
            is_table: masker.cut.is_some(),
            is_simple: masker.is_sought,
            is_brief: false,
        };
        if is_whole || is_held || is_known {
            self.contours.anchor(image, curves, crossings, how);
        }
        if self.contours.is_ready() {
            self.known.note(curves, now_ns);
        } else if is_fast {
            let is_brief = true;
            (self.contours).anchor(image, curves, crossings, Trust { is_brief, ..how });
            self.is_brief = true;
        }
    }
}

impl Follower {
    /// Notes what an image shows: in how many images in a row these ropes and no others were seen, and how long they are followed
    /// from here.
    fn know(&mut self, curves: &[Curve], crossings: &[Crossing], is_plain: bool, now_ns: u64) {
        let is_known = |curve: &Curve| self.tracks.contains(&curve.track);
        let same = self.tracks.len() == curves.len() && curves.iter().all(is_known);
        let is_open = |curve: &Curve| match is_plain {
            // One that is shorter than it was is whole as far as it goes.
            true => !curve.hidden.contains(&true),
            false => is_whole(curve),
        };
        let in_a_row = |frames: u32, are_so: bool| match (same, are_so) {
            (true, true) => frames + 1,
            (false, true) => 1,
            (_, false) => 0,
        };
        self.whole_frames = in_a_row(self.whole_frames, curves.iter().all(is_open));
        self.held_frames = in_a_row(self.held_frames, curves.iter().all(shows_ends));
        let was_due = now_ns >= self.anchored_ns.saturating_add(self.wait_ns);
        let is_open = !curves.iter().any(|curve| curve.hidden.contains(&true));
        self.wait_ns = match same && is_open && self.crossings == crossings.len() {
            true if was_due => (2 * self.wait_ns).min(LOOK_NS.1),
            true => self.wait_ns,
            false => LOOK_NS.0,
        };
        self.tracks.clear();
        self.tracks.extend(curves.iter().map(|curve| curve.track));
        (self.crossings, self.anchored_ns) = (crossings.len(), now_ns);
    }
}

/// Whether all of a rope is seen.
fn is_whole(curve: &Curve) -> bool {
    matches!(curve.status, Status::Ok | Status::Doubtful) && !curve.hidden.contains(&true)
}

/// Whether all of a rope is seen but for parts between its tips.
fn shows_ends(curve: &Curve) -> bool {
    let hides = |i: Option<&bool>| i.is_some_and(|&is_hidden| is_hidden);
    let is_between =
        curve.hidden.contains(&true) && !hides(curve.hidden.first()) && !hides(curve.hidden.last());
    is_whole(curve) || curve.status == Status::Partial && is_between
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
