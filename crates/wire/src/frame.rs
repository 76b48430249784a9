//! State of a reader at one moment: the newest message and its current age.

use std::sync::Mutex;
use std::time::Duration;

use crate::rope::{InSpace, Moment};
use crate::{Absent, CenterlinePoints, Descriptor, Descriptors, Descriptors3, Seen, Track};

/// The newest message at the time of a request. It stays in shared memory and is borrowed from the
/// [`Reader`](crate::Reader) until the next request.
#[derive(Debug, Clone, Copy)]
pub struct Frame<'a> {
    message: Option<&'a Descriptors>,
    space: InSpace<'a>,
    moment: Moment,
    is_new: bool,
}

impl<'a> Frame<'a> {
    pub(crate) fn new(
        message: Option<&'a Descriptors>,
        space: InSpace<'a>,
        moment: Moment,
        is_new: bool,
    ) -> Self {
        Self {
            message,
            space,
            moment,
            is_new,
        }
    }

    /// Returns whether it arrived after the previous request. Otherwise it is the same image, now
    /// older.
    pub fn is_new(&self) -> bool {
        self.is_new
    }

    /// Time since the image was taken; `None` before the first image.
    pub fn age(&self) -> Option<Duration> {
        let age_ns = self.moment.now_ns.saturating_sub(self.moment.exposed_ns);
        self.message.map(|_| Duration::from_nanos(age_ns))
    }

    /// Run of the chain, counted by this reader from 1; 0 before the first message. When it
    /// changes, tracks start again, and the new chain may have another basis, order or unit.
    pub fn run(&self) -> u64 {
        self.moment.run
    }

    /// The message itself; `None` before the first. It does not contain its age, and is meant for
    /// uses that need all of its data, such as recording.
    pub fn message(&self) -> Option<&'a Descriptors> {
        self.message
    }

    /// The rope of an image that has exactly one. If there are several, visible or lost, the result
    /// is [`Absent::Several`]. Then choose one of [`ropes`](Self::ropes) and request its track.
    ///
    /// `max_age` is the maximum age of the image. If the image is older, the rope is
    /// [`Stale`](Seen::Stale).
    pub fn only_rope(&self, max_age: Duration) -> Seen<'a> {
        let mut ropes = self.described();
        match (ropes.next(), ropes.next()) {
            (Some(rope), None) => Seen::of(rope, self.space, self.moment, max_age),
            (Some(_), Some(_)) if !self.is_older(max_age) => Seen::Absent(Absent::Several),
            _ => self.without(max_age),
        }
    }

    /// The rope of this track, and no other.
    pub fn rope(&self, track: Track, max_age: Duration) -> Seen<'a> {
        if self.message.is_some() && track.run != self.moment.run {
            return Seen::Absent(Absent::OtherRun);
        }
        let mut ropes = self.described();
        match ropes.find(|(rope, _)| rope.track == track.number) {
            Some(rope) => Seen::of(rope, self.space, self.moment, max_age),
            None => self.without(max_age),
        }
    }

    /// Every rope of the image, including lost ones.
    pub fn ropes(&self, max_age: Duration) -> impl Iterator<Item = Seen<'a>> + use<'a> {
        let (space, moment) = (self.space, self.moment);
        let ropes = self.described();
        ropes.map(move |rope| Seen::of(rope, space, moment, max_age))
    }

    /// Descriptor and points of every rope.
    fn described(&self) -> impl Iterator<Item = (&'a Descriptor, &'a CenterlinePoints)> + use<'a> {
        let message = self.message.into_iter();
        message.flat_map(|message| message.curves().iter().zip(message.centerlines()))
    }

    fn is_older(&self, max_age: Duration) -> bool {
        self.age().is_some_and(|age| age > max_age)
    }

    /// The reason why a rope is missing.
    fn without(&self, max_age: Duration) -> Seen<'a> {
        Seen::Absent(match self.message {
            None => Absent::NothingYet,
            Some(_) if self.is_older(max_age) => Absent::NothingLately,
            Some(message) if message.width == 0 || message.height == 0 => Absent::NoImage,
            Some(_) => Absent::NoRope,
        })
    }
}

/// A copy of a frame outside shared memory. It survives further requests to the reader and can move
/// to another thread.
#[derive(Debug)]
pub struct KeptFrame {
    message: Option<Box<Descriptors>>,
    /// `None` if the reader does not follow shapes in space.
    space: Option<Option<Box<Descriptors3>>>,
    moment: Moment,
    is_new: bool,
}

/// Unused messages. A new one must be cleared completely, which takes longer than copying one rope.
static SPARE: Mutex<Vec<Box<Descriptors>>> = Mutex::new(Vec::new());
/// Maximum number of spare messages. A loop needs few: it keeps the last frame while it reads the
/// next.
const MOST_SPARE: usize = 4;

impl Frame<'_> {
    /// Copies the valid part of the message, 4 KB per rope, to keep the frame.
    pub fn keep(&self) -> KeptFrame {
        KeptFrame {
            message: self.message.map(copied),
            space: match self.space {
                InSpace::NotFollowed => None,
                InSpace::None => Some(None),
                InSpace::Message(message) => {
                    let mut copy = Box::new(Descriptors3::EMPTY);
                    copy.copy_meant(message);
                    Some(Some(copy))
                }
            },
            moment: self.moment,
            is_new: self.is_new,
        }
    }
}

/// Copies the valid part of a message and leaves the rest empty. A full copy would take many times
/// as long, mostly to load stale data.
fn copied(message: &Descriptors) -> Box<Descriptors> {
    // Never wait for another thread here.
    let spare = SPARE.try_lock().ok().and_then(|mut spare| spare.pop());
    let mut copy = spare.unwrap_or_else(|| Box::new(Descriptors::EMPTY));
    let used = copy.curves().len();
    copy.curves[..used].fill(Descriptor::EMPTY);
    copy.centerlines[..used].fill(CenterlinePoints::EMPTY);
    copy.copy_meant(message);
    copy
}

impl Clone for KeptFrame {
    fn clone(&self) -> Self {
        self.frame().keep()
    }
}

impl Drop for KeptFrame {
    fn drop(&mut self) {
        if let (Some(message), Ok(mut spare)) = (self.message.take(), SPARE.try_lock())
            && spare.len() < MOST_SPARE
        {
            spare.push(message);
        }
    }
}

impl KeptFrame {
    /// The frame as it was when it was copied, including its age.
    pub fn frame(&self) -> Frame<'_> {
        let space = match &self.space {
            None => InSpace::NotFollowed,
            Some(None) => InSpace::None,
            Some(Some(message)) => InSpace::Message(message),
        };
        Frame::new(self.message.as_deref(), space, self.moment, self.is_new)
    }
}
