//! What a reader knows at one moment: the newest message, and how old it is now.

use std::sync::Mutex;
use std::time::Duration;

use crate::rope::{InSpace, Moment};
use crate::{Absent, CenterlinePoints, Descriptor, Descriptors, Descriptors3, Seen, Track};

/// The newest that came, looked at at one moment. It lives in shared memory and is borrowed from the
/// [`Reader`](crate::Reader) until that one looks again.
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

    /// Whether it came since the last look. If not, it is the same image, some time older.
    pub fn is_new(&self) -> bool {
        self.is_new
    }

    /// How long ago the image was taken; `None` before the first.
    pub fn age(&self) -> Option<Duration> {
        let age_ns = self.moment.now_ns.saturating_sub(self.moment.exposed_ns);
        self.message.map(|_| Duration::from_nanos(age_ns))
    }

    /// Which run of the chain it is of, counted by this reader from 1; 0 before the first message. When it changes, tracks
    /// have begun again, and the new chain may have another basis, order or unit.
    pub fn run(&self) -> u64 {
        self.moment.run
    }

    /// The message itself; `None` before the first. It says nothing of how old it is: for what is to be done with all of
    /// it, as writing it down.
    pub fn message(&self) -> Option<&'a Descriptors> {
        self.message
    }

    /// The rope of an image that has one. With several, seen or lost, it is none of them
    /// ([`Absent::Several`]): then choose one among [`ropes`](Self::ropes), and ask for its track.
    ///
    /// `max_age`: how old the image may be. Older, the rope is [`Stale`](Seen::Stale).
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

    /// Every rope of the image, and those that are lost.
    pub fn ropes(&self, max_age: Duration) -> impl Iterator<Item = Seen<'a>> + use<'a> {
        let (space, moment) = (self.space, self.moment);
        let ropes = self.described();
        ropes.map(move |rope| Seen::of(rope, space, moment, max_age))
    }

    /// Every rope's descriptor, and the points of it.
    fn described(&self) -> impl Iterator<Item = (&'a Descriptor, &'a CenterlinePoints)> + use<'a> {
        let message = self.message.into_iter();
        message.flat_map(|message| message.curves().iter().zip(message.centerlines()))
    }

    fn is_older(&self, max_age: Duration) -> bool {
        self.age().is_some_and(|age| age > max_age)
    }

    /// Why a rope is not there.
    fn without(&self, max_age: Duration) -> Seen<'a> {
        Seen::Absent(match self.message {
            None => Absent::NothingYet,
            Some(_) if self.is_older(max_age) => Absent::NothingLately,
            Some(message) if message.width == 0 || message.height == 0 => Absent::NoImage,
            Some(_) => Absent::NoRope,
        })
    }
}

/// A frame that is kept: what its message says, copied out of shared memory, so that it stays when the reader looks again,
/// and can go to another thread.
#[derive(Debug)]
pub struct KeptFrame {
    message: Option<Box<Descriptors>>,
    /// `None` where the reader does not follow in space.
    space: Option<Option<Box<Descriptors3>>>,
    moment: Moment,
    is_new: bool,
}

/// Messages that are kept no more. A new one has to be cleared whole, which takes longer than to copy what one rope means.
static SPARE: Mutex<Vec<Box<Descriptors>>> = Mutex::new(Vec::new());
/// So many: a loop keeps the last frame while it looks at the next.
const MOST_SPARE: usize = 4;

impl Frame<'_> {
    /// Copies what the message means, 4 KB a rope, to keep the frame.
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

/// What is meant of a message; the rest is empty. To copy all of it would take many times as long, the most of it to fetch what is
/// stale.
fn copied(message: &Descriptors) -> Box<Descriptors> {
    // Nobody waits for another thread here.
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
    /// The frame as it was when it was kept, ages included.
    pub fn frame(&self) -> Frame<'_> {
        let space = match &self.space {
            None => InSpace::NotFollowed,
            Some(None) => InSpace::None,
            Some(Some(message)) => InSpace::Message(message),
        };
        Frame::new(self.message.as_deref(), space, self.moment, self.is_new)
    }
}
