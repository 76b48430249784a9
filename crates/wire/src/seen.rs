//! What is known of a rope now, as a type that has to be looked at before there is a shape.

use std::fmt;
use std::time::Duration;

use thiserror::Error;

use crate::Rope;
use crate::rope::{InSpace, Moment};
use crate::{CenterlinePoints, Descriptor, FitQuality, NoShape, Shape, Status};

/// What is known of a rope.
///
/// Only [`Fresh`](Self::Fresh) is the rope as it is: whole, in an image no older than was asked for, and under its curve. Each other case
/// has to be taken by its name before there is a shape, so that no wrong one is taken for right:
///
/// ```
/// # use lariat_wire::Seen;
/// # fn steer(_: [f64; 2]) {} fn creep(_: [f64; 2]) {} fn hold(_: &Seen) {}
/// # fn control(seen: Seen) -> Result<(), lariat_wire::NoShape> {
/// match seen {
///     Seen::Fresh(rope) => steer(rope.shape()?.point_at(0.5)),
///     Seen::Partial(rope) => creep(rope.shape()?.point_at(0.5)),
///     Seen::Unsure(..) | Seen::Lost(_) | Seen::Stale(_) | Seen::Absent(_) => hold(&seen),
/// }
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone, Copy)]
#[must_use = "whether there is a rope to steer by is what this says"]
pub enum Seen<'a> {
    /// The whole rope.
    Fresh(Rope<'a>),
    /// The rope, but a part of it is covered by something: that part is bridged by what was seen on its two sides, and
    /// where it was before.
    Partial(Rope<'a>),
    /// A rope, or what looks like one, and why it is not to be steered by as it is.
    Unsure(Rope<'a>, Doubt),
    /// The image is fresh, and the rope is not in it; or the camera gives no image. This is where it was.
    Lost(LastKnown<'a>),
    /// The image is older than was asked for: the chain stands still, or is too slow, or has ended. This is where it was.
    Stale(LastKnown<'a>),
    /// There is no shape at all, not even an old one.
    Absent(Absent),
}

impl<'a> Seen<'a> {
    /// What a message says of a rope.
    pub(crate) fn of(
        (descriptor, points): (&'a Descriptor, &'a CenterlinePoints),
        space: InSpace<'a>,
        moment: Moment,
        max_age: Duration,
    ) -> Self {
        // Every number in shared memory is somebody else's.
        if Shape::of(descriptor).is_err_and(|cause| cause == NoShape::Unreadable) {
            return Self::Absent(Absent::Unreadable);
        }
        let (Some(status), Some(fit)) = (descriptor.status(), descriptor.fit()) else {
            return Self::Absent(Absent::Unreadable);
        };
        let rope = Rope::new(descriptor, points, space, moment);
        let image_age = moment.now_ns.saturating_sub(moment.exposed_ns);
        let is_stale = u128::from(image_age) > max_age.as_nanos();
        // What is no number is no confidence.
        let is_sure = descriptor.confidence >= moment.min_confidence;
        let is_coarse = fit == FitQuality::Coarse && !moment.coarse;
        match status {
            _ if is_stale => Self::Stale(LastKnown(rope)),
            Status::Lost => Self::Lost(LastKnown(rope)),
            Status::Doubtful => Self::Unsure(rope, Doubt::NoRope),
            Status::Ok | Status::Partial if !is_sure => Self::Unsure(rope, Doubt::LowConfidence),
            // What is bridged is not seen, what a coarse curve misses is: so that comes first.
            Status::Ok | Status::Partial if is_coarse => Self::Unsure(rope, Doubt::Coarse),
            Status::Ok => Self::Fresh(rope),
            Status::Partial => Self::Partial(rope),
        }
    }
}

/// As a sentence, for the log.
impl fmt::Display for Seen<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fresh(rope) => write!(f, "rope {} is seen whole", rope.track()),
            Self::Partial(rope) => {
                let hidden = 100.0 * rope.hidden();
                write!(f, "{hidden:.0} % of rope {} is covered", rope.track())
            }
            Self::Unsure(rope, Doubt::Coarse) => {
                let Descriptor { max, width, .. } = rope.descriptor();
                write!(
                    f,
                    "the curve of rope {} misses it by up to {max:.1}, where it is {width:.1} wide: its centerline is right, and \
                     `lariat run --basis auto` finds a curve that lies on it",
                    rope.track()
                )
            }
            Self::Unsure(rope, Doubt::LowConfidence) => write!(
                f,
                "rope {} has a confidence of {:.0} % only, less than required",
                rope.track(),
                100.0 * rope.confidence()
            ),
            Self::Unsure(rope, why) => write!(f, "rope {} is doubtful: {why}", rope.track()),
            Self::Lost(last) => write!(
                f,
                "rope {} is out of sight since {} ms",
                last.0.track(),
                last.age().as_millis()
            ),
            Self::Stale(last) => write!(
                f,
                "the last image of rope {} is {} ms old",
                last.0.track(),
                last.age().as_millis()
            ),
            Self::Absent(why) => why.fmt(f),
        }
    }
}

/// Why a rope that is seen is not to be steered by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum Doubt {
    /// The curve does not lie on the rope, as one with too few control points for its bends. The
    /// [centerline](Rope::centerline) does. A loop that wants such a curve all the same says so:
    /// [`Reader::accept_coarse`](crate::Reader::accept_coarse).
    #[error("the curve does not lie on the rope, but its centerline does")]
    Coarse,
    /// It is seen whole, but what is seen may be no rope.
    #[error("it may not be a rope, but a shadow, a pen or an edge")]
    NoRope,
    /// Its [confidence](Rope::confidence) is less than required
    /// ([`Reader::min_confidence`](crate::Reader::min_confidence)).
    #[error("its confidence is less than required")]
    LowConfidence,
}

/// A shape that a rope had, and may have no more.
#[derive(Debug, Clone, Copy)]
pub struct LastKnown<'a>(Rope<'a>);

impl<'a> LastKnown<'a> {
    /// How long ago the rope was seen with this shape, when the frame was asked for.
    pub fn age(&self) -> Duration {
        self.0.age()
    }

    /// The rope as it was. To look for it, to draw it, or to [predict](Rope::predict) where it went: not to steer by.
    pub fn as_it_was(&self) -> Rope<'a> {
        self.0
    }
}

/// Why there is no shape, not even an old one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum Absent {
    /// No message has come since the reader was opened.
    #[error(
        "nothing came yet: the chain does not run, waits for its source or its masks, or has just been joined"
    )]
    NothingYet,
    /// The last message is older than was asked for, and this rope is not in it.
    #[error("nothing came lately: the chain stands still, or has ended")]
    NothingLately,
    /// The camera gives no image.
    #[error("the camera gives no image")]
    NoImage,
    /// It is not in the image, nor remembered.
    #[error("there is no such rope in the image")]
    NoRope,
    /// The only rope was asked for, and there are several: choose one by its track.
    #[error("there are several ropes: choose one by its track")]
    Several,
    /// The track is of a run of the chain that is over: choose a rope again.
    #[error("the chain was restarted, and numbers ropes again: choose the rope again")]
    OtherRun,
    /// Its numbers make no rope. A chain of this release sends none such.
    #[error("the message makes no sense: use the same release of lariat for every process")]
    Unreadable,
}
