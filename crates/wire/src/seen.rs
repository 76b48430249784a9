//! Current state of a rope, as a type that must be matched to get a shape.

use std::fmt;
use std::time::Duration;

use thiserror::Error;

use crate::Rope;
use crate::rope::{InSpace, Moment};
use crate::{CenterlinePoints, Descriptor, FitQuality, NoShape, Shape, Status};

/// State of a rope.
///
/// Only [`Fresh`](Self::Fresh) is the rope as it is: whole, followed by its curve, and in an image
/// no older than requested. Every other case must be named before it gives a shape, so that no
/// invalid shape is mistaken for a valid one:
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
    /// The rope, partly covered. The covered part is interpolated from the parts on both sides and
    /// from its earlier position.
    Partial(Rope<'a>),
    /// A rope or something similar, with the reason why it must not be used for steering as it is.
    Unsure(Rope<'a>, Doubt),
    /// The image is fresh but does not show the rope, or the camera gives no image. Contains the
    /// last known shape.
    Lost(LastKnown<'a>),
    /// The image is older than requested: the chain hangs, is too slow, or has ended. Contains the
    /// last known shape.
    Stale(LastKnown<'a>),
    /// There is no shape at all, not even an old one.
    Absent(Absent),
}

impl<'a> Seen<'a> {
    /// State of a rope in a message.
    pub(crate) fn of(
        (descriptor, points): (&'a Descriptor, &'a CenterlinePoints),
        space: InSpace<'a>,
        moment: Moment,
        max_age: Duration,
    ) -> Self {
        // Numbers in shared memory come from another process, so check them all.
        if Shape::of(descriptor).is_err_and(|cause| cause == NoShape::Unreadable) {
            return Self::Absent(Absent::Unreadable);
        }
        let (Some(status), Some(fit)) = (descriptor.status(), descriptor.fit()) else {
            return Self::Absent(Absent::Unreadable);
        };
        let rope = Rope::new(descriptor, points, space, moment);
        let image_age = moment.now_ns.saturating_sub(moment.exposed_ns);
        let is_stale = u128::from(image_age) > max_age.as_nanos();
        // A NaN counts as no confidence.
        let is_sure = descriptor.confidence >= moment.min_confidence;
        let is_coarse = fit == FitQuality::Coarse && !moment.coarse;
        match status {
            _ if is_stale => Self::Stale(LastKnown(rope)),
            Status::Lost => Self::Lost(LastKnown(rope)),
            Status::Doubtful => Self::Unsure(rope, Doubt::NoRope),
            Status::Ok | Status::Partial if !is_sure => Self::Unsure(rope, Doubt::LowConfidence),
            // The interpolated part is unobserved, but a coarse curve is wrong even where the rope
            // is visible, so this comes first.
            Status::Ok | Status::Partial if is_coarse => Self::Unsure(rope, Doubt::Coarse),
            Status::Ok => Self::Fresh(rope),
            Status::Partial => Self::Partial(rope),
        }
    }
}

/// A sentence for the log.
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

/// Reason why an observed rope must not be used for steering.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum Doubt {
    /// The curve does not follow the rope, for example with too few control points for its bends.
    /// The [centerline](Rope::centerline) does. A loop can accept such curves with
    /// [`Reader::accept_coarse`](crate::Reader::accept_coarse).
    #[error("the curve does not lie on the rope, but its centerline does")]
    Coarse,
    /// It is fully visible, but may not be a rope.
    #[error("it may not be a rope, but a shadow, a pen or an edge")]
    NoRope,
    /// Its [confidence](Rope::confidence) is less than required
    /// ([`Reader::min_confidence`](crate::Reader::min_confidence)).
    #[error("its confidence is less than required")]
    LowConfidence,
}

/// A shape that a rope had, and may no longer have.
#[derive(Debug, Clone, Copy)]
pub struct LastKnown<'a>(Rope<'a>);

impl<'a> LastKnown<'a> {
    /// Age of this shape when the frame was requested: the time since the rope was observed.
    pub fn age(&self) -> Duration {
        self.0.age()
    }

    /// The rope as it was. Use it to search, to draw, or to [predict](Rope::predict) its position,
    /// but not to steer.
    pub fn as_it_was(&self) -> Rope<'a> {
        self.0
    }
}

/// Reason why there is no shape, not even an old one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum Absent {
    /// No message has arrived since the reader was opened.
    #[error(
        "nothing came yet: the chain does not run, waits for its source or its masks, or has just been joined"
    )]
    NothingYet,
    /// The last message is older than requested, and does not contain this rope.
    #[error("nothing came lately: the chain stands still, or has ended")]
    NothingLately,
    /// The camera gives no image.
    #[error("the camera gives no image")]
    NoImage,
    /// The rope is neither in the image nor remembered.
    #[error("there is no such rope in the image")]
    NoRope,
    /// The only rope was requested, but there are several; choose one by its track.
    #[error("there are several ropes: choose one by its track")]
    Several,
    /// The track belongs to an earlier run of the chain; choose a rope again.
    #[error("the chain was restarted, and numbers ropes again: choose the rope again")]
    OtherRun,
    /// The message's numbers do not describe a rope. A chain of this release never sends such a
    /// message.
    #[error("the message makes no sense: use the same release of lariat for every process")]
    Unreadable,
}
