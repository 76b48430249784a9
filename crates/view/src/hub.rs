//! The one that reads the rig for all clients, while there are any.
//!
//! Its thread sleeps without a client, and has no reader then. Clients say what they want ([`Watcher::want`]) and sleep until it is
//! there; who wants nothing costs nothing.

use std::fmt;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use lariat_chain::places::Places;
use lariat_record::Losses;
use lariat_wire::{
    CENTERLINES, Centerlines, Channel, Descriptors, Domain, FRAMES, Message, Payload, Receiver,
    Rig, Trace, WireError, now_ns,
};
use rustix::event::{EventfdFlags, eventfd};

use crate::gather::Gatherer;
use crate::moment::{Image, Moment};
use crate::notices::Notices;
use crate::pace::Pace;
use crate::status::Reporter;

/// From one status to the next.
const STATUS: Duration = Duration::from_millis(250);
/// The longest sleep of a lossless rig's reader, which each message wakes.
const KEEPING_UP: Duration = Duration::from_millis(50);
/// How often it is looked whether a channel is written.
const LINK_NS: u64 = 100_000_000;
/// How long after a failure to join the domain it is tried again.
const AGAIN: Duration = Duration::from_secs(1);

/// What clients and the reading thread share.
pub(crate) struct Hub {
    rig: Option<Rig>,
    state: Mutex<State>,
    /// A client came or went, or all is to end.
    changed: Condvar,
}

impl fmt::Debug for Hub {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_struct("Hub")
            .field("rig", &self.rig)
            .finish_non_exhaustive()
    }
}

#[derive(Default)]
struct State {
    watchers: Vec<Wants>,
    next_id: u64,
    /// The one that is read.
    rig: Option<Rig>,
    newest: Option<Arc<Moment>>,
    /// Its number goes up with each.
    status: Option<(u64, Arc<str>)>,
    is_over: bool,
}

/// What a client waits for.
struct Wants {
    id: u64,
    moment: bool,
    bell: Arc<OwnedFd>,
}

/// A client's place at the hub. Dropped, it is given up.
pub(crate) struct Watcher {
    hub: Arc<Hub>,
    id: u64,
    bell: Arc<OwnedFd>,
}

impl Hub {
    pub(crate) fn new(rig: Option<Rig>) -> Arc<Self> {
        Arc::new(Self {
            rig,
            state: Mutex::default(),
            changed: Condvar::new(),
        })
    }

    fn state(&self) -> MutexGuard<'_, State> {
        // What a panicking thread left of it is as good as before: each change is one assignment.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes a place.
    ///
    /// # Errors
    /// The process has no descriptor left.
    pub(crate) fn join(self: &Arc<Self>) -> std::io::Result<Watcher> {
        let bell = Arc::new(eventfd(0, EventfdFlags::NONBLOCK | EventfdFlags::CLOEXEC)?);
        let mut state = self.state();
        state.next_id += 1;
        let id = state.next_id;
        state.watchers.push(Wants {
            id,
            moment: false,
            bell: bell.clone(),
        });
        drop(state);
        self.changed.notify_all();
        Ok(Watcher {
            hub: self.clone(),
            id,
            bell,
        })
    }

    /// Ends the reading thread, and wakes all clients.
    pub(crate) fn end(&self) {
        let mut state = self.state();
        state.is_over = true;
        state
            .watchers
            .iter()
            .for_each(|watcher| ring(&watcher.bell));
        drop(state);
        self.changed.notify_all();
    }

    pub(crate) fn is_over(&self) -> bool {
        self.state().is_over
    }

    /// Reads the rig whenever there are clients, until the [end](Self::end).
    pub(crate) fn run(&self) {
        loop {
            let mut state = self.state();
            while state.watchers.is_empty() && !state.is_over {
                state = self
                    .changed
                    .wait(state)
                    .unwrap_or_else(PoisonError::into_inner);
            }
            if state.is_over {
                return;
            }
            drop(state);
            if let Err(error) = self.read_the_rig() {
                self.tell(Reporter::failed(&error));
                self.rest(AGAIN);
            }
        }
    }

    fn read_the_rig(&self) -> Result<(), WireError> {
        let domain = Domain::open()?;
        let mut gatherer = Gatherer::new(&domain, self.rig.clone());
        // A page has room for the tail of a distribution, which 3 s of frames do not have.
        gatherer.longer();
        let mut reporter = Reporter::default();
        let mut reading = Sources::default();
        let (mut notices, mut places) = (Notices::default(), Places::default());
        let (mut pace, mut status_due) = (Pace::default(), Instant::now());
        while self.is_looked_at() {
            let now = now_ns();
            gatherer.look(now);
            let newest = gatherer.newest();
            if let Some(newest) = newest {
                pace.saw(&newest.trace);
            }
            let is_wanted = self.is_moment_wanted(gatherer.linked());
            let lossless = gatherer.must_keep_up();
            match gatherer.linked() {
                // Not only when one is wanted: the chain would wait for it.
                Some(rig) if is_wanted || lossless => {
                    if let Err(error) = reading.open(&domain, rig, lossless) {
                        reporter.note(&error);
                    } else if let Some(mut moment) =
                        reading.moment(newest, gatherer.losses(now), is_wanted)?
                    {
                        moment.places = places.of_rig(&moment.descriptors, gatherer.stage("fit"));
                        let moment = Arc::new(moment);
                        self.show(moment.clone());
                        notices.look(&moment, gatherer.stage("extract"));
                    }
                }
                Some(_) => {}
                None => reading = reading.closed(),
            }
            if Instant::now() >= status_due {
                status_due = Instant::now() + STATUS;
                self.tell(reporter.report(&gatherer, notices.said(), now));
            }
            match lossless {
                true => gatherer.keep_up(Instant::now() + KEEPING_UP, None),
                false => self.rest(pace.wait(now_ns())),
            }
        }
        Ok(())
    }

    /// Sleeps for so long, or until a client comes or goes.
    fn rest(&self, time: Duration) {
        let state = self.state();
        if !state.is_over && !state.watchers.is_empty() {
            drop(self.changed.wait_timeout(state, time));
        }
    }

    fn is_looked_at(&self) -> bool {
        let state = self.state();
        !state.watchers.is_empty() && !state.is_over
    }

    /// Whether a client waits for a moment of the rig that is read.
    fn is_moment_wanted(&self, rig: Option<&Rig>) -> bool {
        let mut state = self.state();
        if rig.is_some() && state.rig.as_ref() != rig {
            state.rig = rig.cloned();
        }
        state.watchers.iter().any(|watcher| watcher.moment)
    }

    fn show(&self, moment: Arc<Moment>) {
        let mut state = self.state();
        state.newest = Some(moment);
        for watcher in state.watchers.iter_mut().filter(|watcher| watcher.moment) {
            watcher.moment = false;
            ring(&watcher.bell);
        }
    }

    fn tell(&self, status: String) {
        let mut state = self.state();
        let number = state.status.as_ref().map_or(1, |(number, _)| number + 1);
        state.status = Some((number, status.into()));
        state
            .watchers
            .iter()
            .for_each(|watcher| ring(&watcher.bell));
    }
}

pub(crate) fn ring(bell: &OwnedFd) {
    // A bell that is full has been heard of anyway.
    let _ = rustix::io::write(bell, &1_u64.to_ne_bytes());
}

impl Watcher {
    /// Asks for the next moment. The bell rings when it is there.
    pub(crate) fn want(&self) {
        let mut state = self.hub.state();
        if let Some(wants) = state.watchers.iter_mut().find(|wants| wants.id == self.id) {
            wants.moment = true;
        }
    }

    /// The rig, once it is known which.
    pub(crate) fn rig(&self) -> Option<Rig> {
        self.hub.state().rig.clone()
    }

    /// The newest moment after this number.
    pub(crate) fn moment_after(&self, number: u64) -> Option<Arc<Moment>> {
        let state = self.hub.state();
        state.newest.clone().filter(|newest| newest.number > number)
    }

    /// The newest status after this number, with its own.
    pub(crate) fn status_after(&self, number: u64) -> Option<(u64, Arc<str>)> {
        let state = self.hub.state();
        state.status.clone().filter(|(newest, _)| *newest > number)
    }

    /// Whether the server ends.
    pub(crate) fn is_over(&self) -> bool {
        self.hub.is_over()
    }

    /// The bell, for others who have news for the client.
    pub(crate) fn bell(&self) -> Arc<OwnedFd> {
        self.bell.clone()
    }

    /// Has the bell ring again from now on.
    pub(crate) fn hear(&self) {
        let mut count = [0; 8];
        let _ = rustix::io::read(&*self.bell, &mut count);
    }
}

impl AsFd for Watcher {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.bell.as_fd()
    }
}

impl Drop for Watcher {
    fn drop(&mut self) {
        let mut state = self.hub.state();
        state.watchers.retain(|wants| wants.id != self.id);
        if state.watchers.is_empty() {
            // An old picture is not what the next client wants to see first.
            (state.newest, state.status) = (None, state.status.take());
        }
        drop(state);
        self.hub.changed.notify_all();
    }
}

/// The readers of what the descriptors were made of.
#[derive(Default)]
struct Sources {
    frames: Option<Ordered<[u8]>>,
    centerlines: Option<Ordered<Centerlines>>,
    /// When it is looked again whether they are written.
    due_ns: u64,
    /// The last moment's number, and its frame.
    number: u64,
    shown: Option<(u64, u64)>,
}

impl Sources {
    /// Without readers, and counting on.
    fn closed(self) -> Self {
        Self {
            number: self.number,
            ..Self::default()
        }
    }

    /// Becomes a reader where there is a writer: one that came before it would make the channel, and a chain that asks for another
    /// delivery be refused.
    fn open(&mut self, domain: &Domain, rig: &Rig, lossless: bool) -> Result<(), WireError> {
        if (self.frames.is_some() && self.centerlines.is_some()) || now_ns() < self.due_ns {
            return Ok(());
        }
        self.due_ns = now_ns() + LINK_NS;
        let is_written = |name| {
            let ends = domain.channel(rig, name).and_then(|state| state.ends);
            ends.is_some_and(|ends| ends.writer.is_some())
        };
        if self.frames.is_none() && is_written(FRAMES.name()) {
            self.frames = Some(Ordered::open(domain, rig, &FRAMES, lossless)?);
        }
        if self.centerlines.is_none() && is_written(CENTERLINES.name()) {
            self.centerlines = Some(Ordered::open(domain, rig, &CENTERLINES, lossless)?);
        }
        Ok(())
    }

    /// The moment of the newest descriptors; `None` if it was shown, or its image is yet to come.
    fn moment(
        &mut self,
        newest: Option<&Descriptors>,
        losses: Losses,
        is_wanted: bool,
    ) -> Result<Option<Moment>, WireError> {
        let (Some(newest), Some(frames)) = (newest, &mut self.frames) else {
            return Ok(None);
        };
        let key = key(&newest.trace);
        if self.shown == Some(key) {
            return Ok(None);
        }
        let frame = frames.of(key)?;
        let seen = match &mut self.centerlines {
            Some(lines) => lines.of(key)?,
            None => None,
        };
        if !is_wanted {
            return Ok(None);
        }
        let is_blank = newest.width == 0;
        let Some(image) = frame.map(|frame| Image {
            header: *frame.header(),
            bytes: frame.to_vec(),
        }) else {
            if !is_blank {
                return Ok(None);
            }
            return Ok(Some(self.made(None, None, newest, losses)));
        };
        let seen = seen.map(|seen| {
            let mut copy = Box::new(Centerlines::EMPTY);
            copy.copy_meant(&seen);
            copy
        });
        Ok(Some(self.made(Some(image), seen, newest, losses)))
    }

    fn made(
        &mut self,
        image: Option<Image>,
        seen: Option<Box<Centerlines>>,
        newest: &Descriptors,
        losses: Losses,
    ) -> Moment {
        self.number += 1;
        self.shown = Some(key(&newest.trace));
        let mut copy = Box::new(Descriptors::EMPTY);
        copy.copy_meant(newest);
        Moment::new(self.number, image, seen, copy, losses)
    }
}

/// Frames in the order in which they were captured: by time, and by number.
fn key(trace: &Trace) -> (u64, u64) {
    (trace.captured_ns, trace.captured)
}

/// A message that tells of a frame.
trait Told: Payload {
    fn key_of(message: &Message<Self>) -> (u64, u64);
}

impl Told for [u8] {
    fn key_of(message: &Message<Self>) -> (u64, u64) {
        key(&message.header().trace)
    }
}

impl Told for Centerlines {
    fn key_of(message: &Message<Self>) -> (u64, u64) {
        key(&message.trace)
    }
}

/// A reader of one frame's message after the other, which leaves those of later frames for later.
struct Ordered<P: Told + ?Sized> {
    receiver: Receiver<P>,
    ahead: Option<Message<P>>,
}

impl<P: Told + ?Sized> Ordered<P> {
    fn open(
        domain: &Domain,
        rig: &Rig,
        channel: &Channel<P>,
        woken: bool,
    ) -> Result<Self, WireError> {
        let receiver = match woken {
            true => Receiver::create(domain, rig, channel, None)?,
            false => Receiver::create_unwoken(domain, rig, channel, None)?,
        };
        Ok(Self {
            receiver,
            ahead: None,
        })
    }

    /// The message of this frame. What is older is passed over.
    fn of(&mut self, key: (u64, u64)) -> Result<Option<Message<P>>, WireError> {
        loop {
            let next = match self.ahead.take() {
                Some(next) => Some(next),
                None => self.receiver.next()?,
            };
            let Some(next) = next else {
                return Ok(None);
            };
            let of = P::key_of(&next);
            if of == key {
                return Ok(Some(next));
            }
            if of > key {
                self.ahead = Some(next);
                return Ok(None);
            }
        }
    }
}
