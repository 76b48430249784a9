#![allow(unsafe_code)] // A reader may go to another thread, which the transport's own counters do not know.
//! A control loop's end of a rig: the newest shapes, in place, with their age.

mod run;

use std::fmt;
use std::os::fd::{AsFd, BorrowedFd};
use std::time::{Duration, Instant};

use crate::channel::DESCRIPTORS3;
use crate::rope::{InSpace, Moment};
use crate::{
    Descriptors, Descriptors3, Domain, Frame, Message, Motion, Receiver, Rig, Trace, WireError,
    now_ns,
};
use run::Runs;
pub(crate) use run::WriterId;

/// Reads the shapes of a rig's ropes, for a control loop.
///
/// It may be opened before the chain runs, and survives restarts of the chain: until a message comes, what it has
/// gets older ([`Seen::Stale`](crate::Seen::Stale)). Up to 24 readers share a rig; one that is slow, stopped or killed
/// disturbs neither the chain nor the others. It belongs to one thread at a time; each thread of several opens its own.
///
/// It takes a channel as it is. A reader of a `--lossless` chain is opened after the chain has started, and must look as often
/// as frames come: that chain waits for it.
pub struct Reader {
    // The message first, then its channel, then the domain: each lives in the next.
    newest: Option<Message<Descriptors>>,
    receiver: Receiver<Descriptors>,
    space: Option<Space>,
    rig: Rig,
    domain: Domain,
    runs: Runs,
    motion: Motion,
    coarse: bool,
    min_confidence: f32,
    /// Time at which the newest message was taken up, by this process's clock.
    came_ns: u64,
}

// SAFETY: what keeps it from being `Send` are counted references without atomics inside the transport's subscriber (which
// its samples share), its listener and its notifier. Each of these is a field of this one reader, and what the reader lends out
// borrows it: all that share a count go to another thread together or not at all. Node and services, which others may share,
// are counted with atomics, and may be sent by the transport's own word; it keeps nothing by thread.
unsafe impl Send for Reader {}

impl fmt::Debug for Reader {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_struct("Reader")
            .field("receiver", &self.receiver)
            .field("runs", &self.runs)
            .finish_non_exhaustive()
    }
}

impl Reader {
    /// Confidence below which a rope is [`Unsure`](crate::Seen::Unsure), unless [`min_confidence`](Self::min_confidence) sets
    /// another: the curve is then more likely wrong than right.
    pub const MIN_CONFIDENCE: f32 = lariat_message::MIN_CONFIDENCE;

    /// Opens the reader of a rig: `"default"`, or what the chain was started with (`--rig NAME`). Whether it runs does not
    /// matter.
    ///
    /// Once it is open, it allocates when it takes up the channel of a chain that has just started, and
    /// [`Shape::covariance`](crate::Shape::covariance) does when first asked in its thread; nothing else.
    ///
    /// # Errors
    /// No such name, no shared memory, a chain of another release or of another user, or 24 readers already.
    pub fn open(rig: &str) -> Result<Self, WireError> {
        Self::open_in(Domain::open()?, &rig.parse()?)
    }

    /// The same, in a domain of one's own choice.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn open_in(domain: Domain, rig: &Rig) -> Result<Self, WireError> {
        Ok(Self {
            newest: None,
            receiver: Receiver::newest_descriptors(&domain, rig)?,
            space: None,
            rig: rig.clone(),
            domain,
            runs: Runs::default(),
            motion: Motion::default(),
            coarse: false,
            min_confidence: Self::MIN_CONFIDENCE,
            came_ns: 0,
        })
    }

    /// Reads where ropes are in space, too, for [`Rope::in_space`](crate::Rope::in_space): of a chain with a depth camera. One that has
    /// none says so, rope by rope. Up to 12 readers of a rig do.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn follow_in_space(&mut self) -> Result<(), WireError> {
        let receiver = Receiver::create_unwoken(&self.domain, &self.rig, &DESCRIPTORS3, None)?;
        self.space = Some(Space {
            held: None,
            receiver,
        });
        Ok(())
    }

    /// What is known now, without waiting: of the newest message, whether it came just now or earlier.
    ///
    /// It makes no system call, but in the one look that takes up the channel of a chain that has just started.
    ///
    /// # Errors
    /// The transport failed. What it says should be done is to be done.
    pub fn latest(&mut self) -> Result<Frame<'_>, WireError> {
        let is_new = self.take()?;
        Ok(self.look(is_new))
    }

    /// What [`latest`](Self::latest) or [`wait`](Self::wait) found last, as old as it is now; never new.
    pub fn frame(&self) -> Frame<'_> {
        self.look(false)
    }

    /// What is known as soon as a message comes that this reader has not looked at, or at the deadline: then the frame
    /// [is not new](Frame::is_new).
    ///
    /// # Errors
    /// As [`latest`](Self::latest).
    pub fn wait(&mut self, deadline: Instant) -> Result<Frame<'_>, WireError> {
        let is_new = loop {
            if self.take()? {
                break true;
            }
            if Instant::now() >= deadline {
                break false;
            }
            self.receiver.sleep(Some(deadline), None)?;
        };
        Ok(self.look(is_new))
    }

    /// How long ago the image of the newest message that was looked at was taken; `None` before the first.
    pub fn age(&self) -> Option<Duration> {
        self.frame().age()
    }

    /// Makes ready for a `poll`, `epoll` or `select` of one's own on [this reader's descriptor](AsFd::as_fd): call it
    /// before each one, and sleep no longer than it says; `None` is as long as you like. It is zero if a message waits.
    ///
    /// It empties the bell, which would ring for ever otherwise. For 0.1 s after a ring the sleep is limited, because the
    /// transport may lose one then. After the sleep, however it ended, [`latest`](Self::latest) says what came.
    ///
    /// ```no_run
    /// use rustix::event::{PollFd, PollFlags, Timespec, poll};
    ///
    /// let mut reader = lariat_wire::Reader::open("default")?;
    /// loop {
    ///     let timeout = reader.before_poll()?.map(|t| Timespec::try_from(t).expect("a second at most"));
    ///     // … with your other descriptors beside it.
    ///     poll(&mut [PollFd::new(&reader, PollFlags::IN)], timeout.as_ref())?;
    ///     let frame = reader.latest()?;
    ///     if frame.is_new() { /* … */ }
    /// }
    /// # #[allow(unreachable_code)]
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`latest`](Self::latest).
    pub fn before_poll(&mut self) -> Result<Option<Duration>, WireError> {
        self.receiver.before_poll()
    }

    /// Lets [`wait`](Self::wait) look for messages for so long, with the core all to itself, before it sleeps. For a
    /// thread with a core of its own: what comes meanwhile is in hand some microseconds earlier. From the start, zero.
    pub fn look_for(&mut self, time: Duration) {
        self.receiver.look_for(time);
    }

    /// How ropes are taken to move, for [`Rope::predict`](crate::Rope::predict). Give it what the chain was given where
    /// that is not the default, and in the chain's unit: with millimetres, mm/s².
    pub fn expect_motion(&mut self, motion: Motion) {
        self.motion = motion;
    }

    /// Whether a coarse curve is [`Fresh`](crate::Seen::Fresh), or `Partial`, like another: for a loop that compares descriptors
    /// of one kind, as with few control points on purpose, and needs none of them to lie on the rope. From the start not: it is
    /// [`Unsure`](crate::Seen::Unsure) then.
    pub fn accept_coarse(&mut self, accept: bool) {
        self.coarse = accept;
    }

    /// Sets the least [confidence](crate::Rope::confidence), 0 to 1, of a rope that is [`Fresh`](crate::Seen::Fresh) or `Partial`;
    /// a rope with less is [`Unsure`](crate::Seen::Unsure). The default is [`MIN_CONFIDENCE`](Self::MIN_CONFIDENCE); 0 accepts
    /// any.
    pub fn min_confidence(&mut self, least: f32) {
        self.min_confidence = least;
    }

    /// Takes up the newest message; `false` if nothing came.
    fn take(&mut self) -> Result<bool, WireError> {
        let mut is_new = false;
        while let Some(message) = self.receiver.next()? {
            // The old one goes back as the new one takes its place: no more than two are ever in hand.
            self.newest = Some(message);
            is_new = true;
        }
        if is_new && let Some(message) = &self.newest {
            self.came_ns = now_ns();
            self.runs.follow(message.writer(), &message.trace);
            if let Some(space) = &mut self.space {
                space.follow(&message.trace)?;
            }
        }
        Ok(is_new)
    }

    fn look(&self, is_new: bool) -> Frame<'_> {
        let message = self.newest.as_deref();
        let trace = message.map(|message| &message.trace);
        let moment = Moment {
            now_ns: now_ns(),
            // A timestamp may be in the future, and a chain in another time namespace may have another clock. An image is at least
            // as old as its fit, and as its arrival here: nothing stays fresh for ever.
            exposed_ns: trace.map_or(0, |trace| {
                trace.exposed_ns.min(trace.fitted_ns).min(self.came_ns)
            }),
            run: self.runs.run(),
            unit: message.and_then(Descriptors::unit),
            period_s: self.runs.period_s(),
            motion: self.motion,
            coarse: self.coarse,
            min_confidence: self.min_confidence,
        };
        let space = match (&self.space, trace) {
            (None, _) => InSpace::NotFollowed,
            (Some(space), Some(trace)) => space.of(trace),
            (Some(_), None) => InSpace::None,
        };
        Frame::new(message, space, moment, is_new)
    }
}

/// The descriptors in space, each of which is sent before those of the same frame.
struct Space {
    // The message before its channel.
    held: Option<Message<Descriptors3>>,
    receiver: Receiver<Descriptors3>,
}

impl Space {
    /// Goes on to those of this frame, or to the first later ones.
    fn follow(&mut self, trace: &Trace) -> Result<(), WireError> {
        while self
            .held
            .as_ref()
            .is_none_or(|held| held.trace.captured_ns < trace.captured_ns)
        {
            match self.receiver.next()? {
                Some(next) => self.held = Some(next),
                None => break,
            }
        }
        Ok(())
    }

    /// Those of this frame.
    fn of(&self, trace: &Trace) -> InSpace<'_> {
        let held = self.held.as_deref();
        let is_its = |held: &&Descriptors3| {
            (held.trace.sequence, held.trace.captured_ns) == (trace.sequence, trace.captured_ns)
        };
        held.filter(is_its).map_or(InSpace::None, InSpace::Message)
    }
}

/// Becomes readable when a message came: see [`before_poll`](Reader::before_poll).
impl AsFd for Reader {
    fn as_fd(&self) -> BorrowedFd<'_> {
        let bell = self.receiver.descriptor();
        bell.expect("a reader's receiver is made with an ear, always")
    }
}
