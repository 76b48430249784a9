#![allow(unsafe_code)] // Functions that C calls by name, with pointers that it vouches for.
//! State of a rope.

use std::ffi::{c_char, c_int};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr;
use std::time::Duration;

use lariat_wire::{Absent, Descriptor, Doubt, Frame, Rope, Seen, Track};

use crate::error::{Failure, LARIAT_ERROR_NO_ROPE, answer};
use crate::message::lariat_descriptor;
use crate::reader::{lariat_reader, shown};

/// State of a rope. Only LARIAT_FRESH is the rope as it is.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum lariat_seen {
    /// The reader or the space for the rope is NULL.
    LARIAT_NO_READER = 0,
    /// The whole rope, in an image no older than requested.
    LARIAT_FRESH = 1,
    /// The rope, partly covered; the covered part is interpolated.
    LARIAT_PARTIAL = 2,
    /// The image is fresh but does not show the rope, or the camera gives no image.
    LARIAT_LOST = 3,
    /// The image is older than requested: the chain hangs, is too slow, or has ended.
    LARIAT_STALE = 4,
    /// No message has arrived since the reader was opened.
    LARIAT_NOTHING_YET = 5,
    /// The last message is older than requested, and does not contain this rope.
    LARIAT_NOTHING_LATELY = 6,
    /// The camera gives no image.
    LARIAT_NO_IMAGE = 7,
    /// The rope is neither in the image nor remembered.
    LARIAT_NO_ROPE = 8,
    /// The only rope was requested, but there are several; choose one by its track.
    LARIAT_SEVERAL = 9,
    /// The track belongs to an earlier run of the chain; choose a rope again.
    LARIAT_OTHER_RUN = 10,
    /// Its numbers do not describe a rope. A chain of this release never sends such a message.
    LARIAT_UNREADABLE = 11,
    /// A possible rope. `doubt` gives the reason: the curve does not follow it, it may not be a
    /// rope, or its confidence is less than required.
    LARIAT_UNSURE = 12,
}

/// Reason why a rope is LARIAT_UNSURE.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum lariat_doubt {
    /// The rope is not LARIAT_UNSURE.
    LARIAT_DOUBT_NONE = 0,
    /// The curve does not follow the rope, but the centerline does: lariat_centerline_of.
    LARIAT_DOUBT_COARSE = 1,
    /// Fully visible, but possibly not a rope: a shadow, a pen, an edge.
    LARIAT_DOUBT_NO_ROPE = 2,
    /// Its confidence is less than required: lariat_min_confidence.
    LARIAT_DOUBT_CONFIDENCE = 3,
}

use lariat_doubt::*;
use lariat_seen::*;

/// Identity of a rope: its number and the run of the chain that assigned it. A restarted chain
/// numbers its ropes again.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct lariat_track {
    /// Run, as counted by lariat_run.
    pub run: u64,
    /// Rope number, constant from frame to frame.
    pub number: u32,
    /// Always 0.
    pub reserved: u32,
}

/// A rope and its state.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct lariat_rope {
    /// State of the rope. It determines which of the four pointers is not NULL.
    pub seen: lariat_seen,
    /// Reason, if LARIAT_UNSURE.
    pub doubt: lariat_doubt,
    /// LARIAT_FRESH: the rope as it is. Otherwise NULL.
    pub fresh: *const lariat_descriptor,
    /// LARIAT_PARTIAL: the partly covered rope. Otherwise NULL.
    pub partial: *const lariat_descriptor,
    /// LARIAT_UNSURE: the possible rope; `doubt` gives the reason. Otherwise NULL.
    pub unsure: *const lariat_descriptor,
    /// LARIAT_LOST, LARIAT_STALE: the last known rope. Use it to search or to draw, but not to
    /// steer. Otherwise NULL.
    pub last_known: *const lariat_descriptor,
    /// Identity of the rope; lariat_rope_of_track finds the same rope by it.
    pub track: lariat_track,
    /// Age of this shape: the time since its image was taken or, for a lost rope, since the last
    /// image that showed it.
    pub age_ns: u64,
    /// Exposure time of its image.
    pub exposed_ns: u64,
}

impl lariat_rope {
    fn without(seen: lariat_seen) -> Self {
        Self {
            seen,
            doubt: LARIAT_DOUBT_NONE,
            fresh: ptr::null(),
            partial: ptr::null(),
            unsure: ptr::null(),
            last_known: ptr::null(),
            track: lariat_track {
                run: 0,
                number: 0,
                reserved: 0,
            },
            age_ns: u64::MAX,
            exposed_ns: 0,
        }
    }

    fn of(seen: Seen) -> Self {
        let doubt = match seen {
            Seen::Unsure(_, Doubt::Coarse) => LARIAT_DOUBT_COARSE,
            Seen::Unsure(_, Doubt::LowConfidence) => LARIAT_DOUBT_CONFIDENCE,
            Seen::Unsure(..) => LARIAT_DOUBT_NO_ROPE,
            _ => LARIAT_DOUBT_NONE,
        };
        let (seen, rope) = match seen {
            Seen::Fresh(rope) => (LARIAT_FRESH, rope),
            Seen::Partial(rope) => (LARIAT_PARTIAL, rope),
            Seen::Unsure(rope, _) => (LARIAT_UNSURE, rope),
            Seen::Lost(last) => (LARIAT_LOST, last.as_it_was()),
            Seen::Stale(last) => (LARIAT_STALE, last.as_it_was()),
            Seen::Absent(why) => return Self::without(absent(why)),
        };
        // The same layout; `message` checks it.
        let descriptor: *const lariat_descriptor = ptr::from_ref(rope.descriptor()).cast();
        let only = |case: bool| if case { descriptor } else { ptr::null() };
        Self {
            seen,
            doubt,
            fresh: only(seen == LARIAT_FRESH),
            partial: only(seen == LARIAT_PARTIAL),
            unsure: only(seen == LARIAT_UNSURE),
            last_known: only(matches!(seen, LARIAT_LOST | LARIAT_STALE)),
            track: lariat_track {
                run: rope.track().run(),
                number: rope.track().number(),
                reserved: 0,
            },
            age_ns: u64::try_from(rope.age().as_nanos()).unwrap_or(u64::MAX),
            exposed_ns: rope.exposed_ns(),
        }
    }
}

fn absent(why: Absent) -> lariat_seen {
    match why {
        Absent::NothingYet => LARIAT_NOTHING_YET,
        Absent::NothingLately => LARIAT_NOTHING_LATELY,
        Absent::NoImage => LARIAT_NO_IMAGE,
        Absent::NoRope => LARIAT_NO_ROPE,
        Absent::Several => LARIAT_SEVERAL,
        Absent::OtherRun => LARIAT_OTHER_RUN,
        _ => LARIAT_UNREADABLE,
    }
}

/// Queries the last frame read, at its current age.
fn ask(
    reader: *const lariat_reader,
    rope: *mut lariat_rope,
    question: impl FnOnce(Frame<'_>) -> Seen<'_>,
) -> lariat_seen {
    // SAFETY: C passes space for a rope, or NULL.
    let Some(place) = (unsafe { rope.as_mut() }) else {
        return LARIAT_NO_READER;
    };
    *place = lariat_rope::without(LARIAT_NO_READER);
    let Ok(shown) = shown(reader) else {
        return LARIAT_NO_READER;
    };
    let asked = catch_unwind(AssertUnwindSafe(|| {
        lariat_rope::of(question(shown.reader.frame()))
    }));
    *place = asked.unwrap_or_else(|_| lariat_rope::without(LARIAT_UNREADABLE));
    place.seen
}

/// Finds the current rope of an image that has exactly one. If there are several, visible or lost,
/// the result is LARIAT_SEVERAL. Then choose one with lariat_rope_at and request its track.
///
/// `max_age_ns` is the maximum age of the image. In an older one, the rope is LARIAT_STALE.
///
/// Returns the state of the rope, which `rope` contains too.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_only_rope(
    reader: *const lariat_reader,
    max_age_ns: u64,
    rope: *mut lariat_rope,
) -> lariat_seen {
    let max_age = Duration::from_nanos(max_age_ns);
    ask(reader, rope, |frame| frame.only_rope(max_age))
}

/// Finds the rope of this track, and no other. Returns the same values as lariat_only_rope.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_rope_of_track(
    reader: *const lariat_reader,
    track: lariat_track,
    max_age_ns: u64,
    rope: *mut lariat_rope,
) -> lariat_seen {
    let max_age = Duration::from_nanos(max_age_ns);
    let track = Track::new(track.run, track.number);
    ask(reader, rope, |frame| frame.rope(track, max_age))
}

/// Finds the rope at an index of the message, from 0, to iterate over all of them; their order may
/// change. After the last rope, the result is LARIAT_NO_ROPE. Returns the same values as
/// lariat_only_rope.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lariat_rope_at(
    reader: *const lariat_reader,
    index: u32,
    max_age_ns: u64,
    rope: *mut lariat_rope,
) -> lariat_seen {
    let max_age = Duration::from_nanos(max_age_ns);
    ask(reader, rope, |frame| {
        let mut ropes = frame.ropes(max_age);
        ropes
            .nth(index as usize)
            .unwrap_or(Seen::Absent(Absent::NoRope))
    })
}

/// Returns a state (a lariat_seen) as text for a log.
#[unsafe(no_mangle)]
#[must_use]
pub extern "C" fn lariat_seen_text(seen: c_int) -> *const c_char {
    // The argument is a plain number, because enumerations in C can hold any.
    const ALL: [lariat_seen; 13] = [
        LARIAT_NO_READER,
        LARIAT_FRESH,
        LARIAT_PARTIAL,
        LARIAT_LOST,
        LARIAT_STALE,
        LARIAT_NOTHING_YET,
        LARIAT_NOTHING_LATELY,
        LARIAT_NO_IMAGE,
        LARIAT_NO_ROPE,
        LARIAT_SEVERAL,
        LARIAT_OTHER_RUN,
        LARIAT_UNREADABLE,
        LARIAT_UNSURE,
    ];
    let known = ALL.into_iter().find(|known| *known as c_int == seen);
    let Some(known) = known else {
        return c"no lariat_seen".as_ptr();
    };
    let text = match known {
        LARIAT_NO_READER => c"the reader or the place for the rope is NULL",
        LARIAT_FRESH => c"the rope is seen whole",
        LARIAT_PARTIAL => c"a part of the rope is covered",
        LARIAT_UNSURE => {
            c"the curve does not lie on the rope, but its centerline does; or it may not be a rope, or its confidence is too low"
        }
        LARIAT_LOST => c"the rope is out of sight",
        LARIAT_STALE => c"the last image of the rope is too old",
        LARIAT_NOTHING_YET => c"nothing came yet: the chain does not run, waits for its source or its masks, or has just been joined",
        LARIAT_NOTHING_LATELY => c"nothing came lately: the chain stands still, or has ended",
        LARIAT_NO_IMAGE => c"the camera gives no image",
        LARIAT_NO_ROPE => c"there is no such rope in the image",
        LARIAT_SEVERAL => c"there are several ropes: choose one by its track",
        LARIAT_OTHER_RUN => {
            c"the chain was restarted, and numbers ropes again: choose the rope again"
        }
        LARIAT_UNREADABLE => {
            c"the message makes no sense: use the same release of lariat for every process"
        }
    };
    text.as_ptr()
}

/// Predicts the rope of this track for the time `t_ns` from its velocities. The chain must run with
/// --filter. `ahead` receives a descriptor like the frame's, with the predicted control points and
/// covariances. `t_ns` is at most 0.5 s after the image. A lost or stale rope is predicted too,
/// from its last image, so check its state first.
///
/// Returns 0, or an error; `ahead` is then empty.
#[unsafe(no_mangle)]
#[must_use]
pub unsafe extern "C" fn lariat_predict(
    reader: *const lariat_reader,
    track: lariat_track,
    t_ns: u64,
    ahead: *mut lariat_descriptor,
) -> c_int {
    answer(|| {
        // SAFETY: C passes space for a descriptor, or NULL. Its layout is the same, as `message`
        // checks.
        let place = unsafe { ahead.cast::<Descriptor>().as_mut() };
        let place = place.ok_or_else(|| Failure::null("the place for the descriptor"))?;
        *place = Descriptor::EMPTY;
        let track = Track::new(track.run, track.number);
        let seen = shown(reader)?.reader.frame().rope(track, Duration::MAX);
        let rope: Rope = match seen {
            Seen::Fresh(rope) | Seen::Partial(rope) | Seen::Unsure(rope, _) => rope,
            Seen::Lost(last) | Seen::Stale(last) => last.as_it_was(),
            Seen::Absent(why) => return Err(Failure::new(LARIAT_ERROR_NO_ROPE, why.to_string())),
        };
        *place = rope.predict(t_ns)?.to_descriptor();
        Ok(0)
    })
}
