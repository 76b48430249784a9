#![allow(unsafe_code)] // Readers move between threads despite their non-atomic counters.
//! The control loop's end of a rig: the newest shapes, in place, with their age.

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
/// It may be opened before the chain runs, and survives restarts of the chain. Until the next
/// message arrives, the latest shapes get older ([`Seen::Stale`](crate::Seen::Stale)). Up to 24
/// readers share a rig; a slow, stopped or killed reader disturbs neither the chain nor the others.
/// A reader belongs to one thread at a time; several threads open one each.
///
/// It accepts a channel as it is. Open a reader of a `--lossless` chain after the chain has
/// started, and read it as often as frames arrive, because that chain waits for it.
pub struct Reader {
    // Fields drop in order: the message before its channel, the channel before the domain.
    newest: Option<Message<Descriptors>>,
    receiver: Receiver<Descriptors>,
    space: Option<Space>,
    rig: Rig,
    domain: Domain,
    runs: Runs,
    motion: Motion,
    coarse: bool,
    min_confidence: f32,
    /// Time at which the newest message arrived, by this process's clock.
    came_ns: u64,
}

// SAFETY: only reference counts without atomics are not `Send`: those in the transport's
// subscriber, which its samples share, its listener and its notifier. All are fields of this
// reader, and whatever the reader lends borrows it, so everything that shares a count moves to
// another thread together. Node and services, which others may share, are counted atomically and
// are `Send` in the transport; it keeps nothing per thread.
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
    /// Default confidence below which a rope is [`Unsure`](crate::Seen::Unsure): its curve is then
    /// more likely wrong than right. [`min_confidence`](Self::min_confidence) sets another
    /// threshold.
    pub const MIN_CONFIDENCE: f32 = lariat_message::MIN_CONFIDENCE;

    /// Opens the reader of a rig: `"default"`, or the one that the chain was started with (`--rig
    /// NAME`). The chain need not be running.
    ///
    /// An open reader allocates only when it connects to a chain that has just started. The first
    /// [`Shape::covariance`](crate::Shape::covariance) of a thread allocates too.
    ///
    /// # Errors
    /// The name is invalid, shared memory is missing, the chain is of another release or another
    /// user, or the rig has 24 readers already.
    pub fn open(rig: &str) -> Result<Self, WireError> {
        Self::open_in(Domain::open()?, &rig.parse()?)
    }

    /// Opens the reader in a given domain.
    ///
    /// # Errors
    /// As for [`open`](Self::open).
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

    /// Also reads the shapes in space, for [`Rope::in_space`](crate::Rope::in_space), from a chain
    /// with a depth camera. If the chain has no depth camera, each rope reports that. Up to 12
    /// readers of a rig can do this.
    ///
    /// # Errors
    /// As for [`open`](Self::open).
    pub fn follow_in_space(&mut self) -> Result<(), WireError> {
        let receiver = Receiver::create_unwoken(&self.domain, &self.rig, &DESCRIPTORS3, None)?;
        self.space = Some(Space {
            held: None,
            receiver,
        });
        Ok(())
    }

    /// Returns the current state without waiting, from the newest message, whether or not it is
    /// new.
    ///
    /// It makes no system call, except when it connects to a chain that has just started.
    ///
    /// # Errors
    /// The transport failed; the message of the error says how to continue.
    pub fn latest(&mut self) -> Result<Frame<'_>, WireError> {
        let is_new = self.take()?;
        Ok(self.look(is_new))
    }

    /// Returns the frame that [`latest`](Self::latest) or [`wait`](Self::wait) found last, at its
    /// current age. It is never new.
    pub fn frame(&self) -> Frame<'_> {
        self.look(false)
    }

    /// Waits for a message that this reader has not returned yet, or for the deadline. At the
    /// deadline the frame [is not new](Frame::is_new).
    ///
    /// # Errors
    /// As for [`latest`](Self::latest).
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

    /// Age of the image of the newest message read; `None` before the first.
    pub fn age(&self) -> Option<Duration> {
        self.frame().age()
    }

    /// Prepares for your own `poll`, `epoll` or `select` on [this reader's
    /// descriptor](AsFd::as_fd). Call this before each of these calls, and sleep no longer than the
    /// returned time; `None` is unlimited, and zero means that a message waits.
    ///
    /// It drains the notifications, because the descriptor would stay readable otherwise. For 0.1 s
    /// after a notification the sleep is limited, because the transport may lose a notification in
    /// that time. After the sleep, however it ended, [`latest`](Self::latest) returns the new
    /// state.
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
    /// As for [`latest`](Self::latest).
    pub fn before_poll(&mut self) -> Result<Option<Duration>, WireError> {
        self.receiver.before_poll()
    }

    /// Lets [`wait`](Self::wait) spin for this time before it sleeps. Use it in a thread with its
    /// own core: a message that arrives in that time is received some microseconds earlier. The
    /// default is zero.
    pub fn look_for(&mut self, time: Duration) {
        self.receiver.look_for(time);
    }

    /// Sets the motion model of ropes for [`Rope::predict`](crate::Rope::predict). Use the chain's
    /// own settings if they are not the defaults, in the chain's unit (mm/s² if it uses
    /// millimeters).
    pub fn expect_motion(&mut self, motion: Motion) {
        self.motion = motion;
    }

    /// Sets whether a coarse curve can be [`Fresh`](crate::Seen::Fresh) or `Partial` like any
    /// other. Use it in loops that only compare descriptors, for example with deliberately few
    /// control points, and do not need curves that follow the rope. By default a coarse curve is
    /// [`Unsure`](crate::Seen::Unsure).
    pub fn accept_coarse(&mut self, accept: bool) {
        self.coarse = accept;
    }

    /// Sets the minimum [confidence](crate::Rope::confidence), 0 to 1, of a rope that is
    /// [`Fresh`](crate::Seen::Fresh) or `Partial`. A rope with less confidence is
    /// [`Unsure`](crate::Seen::Unsure). The default is [`MIN_CONFIDENCE`](Self::MIN_CONFIDENCE); 0
    /// accepts any.
    pub fn min_confidence(&mut self, least: f32) {
        self.min_confidence = least;
    }

    /// Receives the newest message; `false` if nothing new arrived.
    fn take(&mut self) -> Result<bool, WireError> {
        let mut is_new = false;
        while let Some(message) = self.receiver.next()? {
            // This drops the previous message, so at most two are ever held.
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
            // A timestamp may be in the future, and a chain in another time namespace may have
            // another clock. An image is at least as old as its fit and as its arrival here, so
            // nothing stays fresh forever.
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

/// The descriptors in space. For each frame, they are sent before the descriptors in the image.
struct Space {
    // Fields drop in order: the message before its channel.
    held: Option<Message<Descriptors3>>,
    receiver: Receiver<Descriptors3>,
}

impl Space {
    /// Advances to the message of this frame, or to the first later one.
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

    /// The message of this frame.
    fn of(&self, trace: &Trace) -> InSpace<'_> {
        let held = self.held.as_deref();
        let is_its = |held: &&Descriptors3| {
            (held.trace.sequence, held.trace.captured_ns) == (trace.sequence, trace.captured_ns)
        };
        held.filter(is_its).map_or(InSpace::None, InSpace::Message)
    }
}

/// The descriptor is readable when a message has arrived: see [`before_poll`](Reader::before_poll).
impl AsFd for Reader {
    fn as_fd(&self) -> BorrowedFd<'_> {
        let bell = self.receiver.descriptor();
        bell.expect("a reader's receiver is made with an ear, always")
    }
}
