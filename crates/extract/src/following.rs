//! Follows ropes from one image to the next if nothing else happens, for a fraction of the cost of
//! a full extraction.
//!
//! On a plain table, ropes are followed by their difference from it (`chords`). On any other
//! background, and where a tip touches a strand, they are followed by their edges ([`contours`]).

mod chords;
mod contours;
mod crossings;
mod known;
mod lay;

use crate::image::Image;
use crate::mask::background::Background;
use crate::mask::{MaskSource, RopeMask};
use crate::scene::{Crossing, Curve, Status};
use crate::vec2::Vec2;
use chords::ChordFollower;
use contours::{ContourFollower, Trust};
use known::KnownRopes;

/// Time until the next full extraction, at first and at most, in nanoseconds. It doubles each time
/// that a full extraction on schedule finds nothing new.
const LOOK_NS: (u64, u64) = (1_000_000_000, 4_000_000_000);
/// Following time, in nanoseconds, for ropes that cannot be followed for long. They do not move far
/// in this time. A fast camera leaves no time for a full extraction of each image, so this skips
/// some.
const BRIEF_NS: u64 = 7_000_000;
/// Number of consecutive frames in which ropes must be seen completely before they are followed.
const SETTLED: u32 = 3;
/// As `SETTLED`, for the ropes of a given mask.
const TOLD: u32 = 1;

/// State of the ropes that can be followed.
#[derive(Debug, Default)]
pub(crate) struct Follower {
    chords: ChordFollower,
    contours: ContourFollower,
    known: KnownRopes,
    /// Numbers of the ropes that were last seen.
    tracks: Vec<u32>,
    /// Number of their crossings.
    crossings: usize,
    /// Number of consecutive full extractions in which these ropes were seen whole.
    whole_frames: u32,
    /// As `whole_frames`, but parts between the tips may be hidden.
    held_frames: u32,
    /// Number of consecutive full extractions in which all ropes were seen, and nothing else.
    plain_frames: u32,
    /// Time of the last full extraction, in nanoseconds.
    anchored_ns: u64,
    /// Time for which ropes are followed after that extraction, in nanoseconds.
    wait_ns: u64,
    /// True if they are followed for `BRIEF_NS` only.
    is_brief: bool,
    /// Time of the last image.
    last_ns: u64,
    /// True if the caller ever tried to follow ropes. If it never did and gives a mask for each
    /// image, nothing needs to be learned.
    is_wanted: bool,
}

impl Follower {
    /// Reserves memory for this many ropes and points, in images of this size.
    pub(crate) fn reserve(&mut self, ropes: usize, points: usize, size: [usize; 2]) {
        self.contours.reserve(ropes, points, size);
        self.known.reserve(ropes, points);
        // Ropes out of sight have numbers, too.
        self.tracks.reserve(4 * ropes);
    }

    /// Returns whether there are ropes that can be followed into an image at `now_ns`. Also records
    /// that the caller wants to follow.
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

    /// Requires a full extraction of the next image.
    pub(crate) fn drop(&mut self) {
        self.chords.drop();
        self.contours.drop();
        self.plain_frames = 0;
    }

    /// Forgets everything, as the next image is of another scene.
    pub(crate) fn forget(&mut self) {
        self.drop();
        self.known.forget();
        self.tracks.clear();
        (self.whole_frames, self.held_frames) = (0, 0);
        (self.crossings, self.anchored_ns, self.wait_ns) = (0, 0, 0);
        self.last_ns = 0;
        self.is_wanted = false;
    }

    /// Follows the ropes into `image`, which is the next one, and moves `curves` and `crossings`
    /// with them. Returns false if the image needs a full extraction. `curves` and `crossings` are
    /// then meaningless.
    pub(crate) fn follow(
        &mut self,
        image: &Image,
        background: &Background,
        curves: &mut [Curve],
        crossings: &mut [Crossing],
        now_ns: u64,
    ) -> bool {
        let found = match self.chords.is_ready() {
            true => (self.chords).follow(image, background, curves, crossings),
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

    /// Allows the ropes just extracted to be followed. `is_seen` means that there are ropes and
    /// none is out of sight, and `is_plain` also that no occluder is in the image.
    ///
    /// Chords come first, on a plain table with open ropes inside the image. Contours come second:
    /// for ropes seen whole for long enough, or with hidden parts only between their tips, or equal
    /// to the known ropes. With a fast camera, contours also follow all others for `BRIEF_NS`.
    pub(crate) fn anchor(
        &mut self,
        image: &Image,
        (mask, background): (&RopeMask, &Background),
        curves: &[Curve],
        crossings: &[Crossing],
        [is_seen, is_plain]: [bool; 2],
        now_ns: u64,
    ) {
        self.chords.drop();
        self.contours.drop();
        // The network may also find objects that are not ropes.
        self.know(
            curves,
            crossings,
            is_plain && !mask.source.is_network(),
            now_ns,
        );
        self.plain_frames = if is_plain { self.plain_frames + 1 } else { 0 };
        let is_fast = now_ns.saturating_sub(self.last_ns) < BRIEF_NS;
        (self.is_brief, self.last_ns) = (false, now_ns);
        let is_within = |curve: &Curve| !curve.closed && curve.border == [false; 2];
        if let MaskSource::Table {
            cut,
            is_smoothed: false,
        } = mask.source
            && mask.notice.is_none()
            && curves.iter().all(is_within)
        {
            if self.plain_frames >= SETTLED {
                (self.chords).anchor(image, background, cut, curves, crossings);
            }
            if self.chords.is_ready() {
                self.known.note(curves, now_ns);
                return;
            }
        }
        // A given mask is trusted.
        let is_told = mask.source == MaskSource::External;
        let least = if is_told { TOLD } else { SETTLED };
        let is_whole = self.whole_frames >= least;
        let is_held = self.held_frames >= SETTLED;
        let is_known = self.whole_frames > 0 && self.known.are(curves, now_ns);
        if !is_seen || is_told && !self.is_wanted {
            return;
        }
        let how = Trust {
            is_known,
            is_table: mask.source.is_table(),
            is_simple: mask.source.is_network(),
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
    /// Updates the counts of images in which these ropes and no others were seen, and the time for
    /// which they are followed.
    fn know(&mut self, curves: &[Curve], crossings: &[Crossing], is_plain: bool, now_ns: u64) {
        let is_known = |curve: &Curve| self.tracks.contains(&curve.track);
        let same = self.tracks.len() == curves.len() && curves.iter().all(is_known);
        let is_open = |curve: &Curve| match is_plain {
            // A rope shorter than before is whole as far as it is visible.
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

/// Returns whether a rope is seen completely.
fn is_whole(curve: &Curve) -> bool {
    matches!(curve.status, Status::Ok | Status::Doubtful) && !curve.hidden.contains(&true)
}

/// Returns whether a rope is seen completely, except for parts between its tips.
fn shows_ends(curve: &Curve) -> bool {
    let hides = |i: Option<&bool>| i.is_some_and(|&is_hidden| is_hidden);
    let is_between =
        curve.hidden.contains(&true) && !hides(curve.hidden.first()) && !hides(curve.hidden.last());
    is_whole(curve) || curve.status == Status::Partial && is_between
}

/// Axis along which a rope with this normal is cut at the steeper angle: 0 for a row, 1 for a
/// column.
#[inline(always)]
fn axis([x, y]: Vec2) -> usize {
    usize::from(y.abs() > x.abs())
}

/// The integer part of `value`, or 0 if it is negative or too large. From 2²³ on, the last bit of a
/// float is worth 1. Adding 2²³ therefore converts it without a branch.
#[inline(always)]
fn whole(value: f32) -> i32 {
    const ONES: f32 = 8_388_608.0;
    let value = if value > 0.0 { value.floor() } else { 0.0 };
    let value = if value < ONES { value } else { 0.0 };
    (value + ONES).to_bits().cast_signed() - ONES.to_bits().cast_signed()
}
