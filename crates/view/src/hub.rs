//! Reads the rig for all clients, while there are any.
//!
//! Without a client, the hub's thread sleeps and has closed its reader. Clients ask for a moment
//! ([`Watcher::want`]) and sleep until it is there. An idle client costs nothing.

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

/// Interval between two statuses.
const STATUS: Duration = Duration::from_millis(250);
/// Longest sleep of a lossless rig's reader, which each message wakes.
const KEEPING_UP: Duration = Duration::from_millis(50);
/// Interval at which channels are checked for a writer.
const LINK_NS: u64 = 100_000_000;
/// Delay before another attempt to join the domain.
const AGAIN: Duration = Duration::from_secs(1);

/// State that clients and the reading thread share.
pub(crate) struct Hub {
    rig: Option<Rig>,
    state: Mutex<State>,
    /// Notified when a client comes or goes, or when everything is to end.
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
    /// The rig that is read.
    rig: Option<Rig>,
    newest: Option<Arc<Moment>>,
    /// The newest status, and its number, which increases with each status.
    status: Option<(u64, Arc<str>)>,
    is_over: bool,
}

/// A client, and whether it waits for a moment.
struct Wants {
    id: u64,
    moment: bool,
    bell: Arc<OwnedFd>,
}

/// A client's registration at the hub, which ends when this is dropped.
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
        // A panicking thread leaves a valid state, because each change is one assignment.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Registers a client.
    ///
    /// # Errors
    /// Fails if the process has run out of descriptors.
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

    /// Reads the rig whenever there are clients, until the [`end`](Self::end).
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
        // A page shows the tail of a distribution, for which 3 s of frames are too few.
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
                // A lossless chain waits for its readers, even if no moment is wanted.
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

    /// Sleeps for `time`, or until a client comes or goes.
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

    /// Notes which rig is read. Returns whether a client waits for a moment of it.
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
    // Writing fails only if the counter is full, and then the descriptor is readable anyway.
    let _ = rustix::io::write(bell, &1_u64.to_ne_bytes());
}

impl Watcher {
    /// Asks for the next moment. The client is woken when it is there.
    pub(crate) fn want(&self) {
        let mut state = self.hub.state();
        if let Some(wants) = state.watchers.iter_mut().find(|wants| wants.id == self.id) {
            wants.moment = true;
        }
    }

    /// Returns the rig, once it is known.
    pub(crate) fn rig(&self) -> Option<Rig> {
        self.hub.state().rig.clone()
    }

    /// Returns the newest moment, if its number is greater than this.
    pub(crate) fn moment_after(&self, number: u64) -> Option<Arc<Moment>> {
        let state = self.hub.state();
        state.newest.clone().filter(|newest| newest.number > number)
    }

    /// Returns the newest status and its number, if that number is greater than this.
    pub(crate) fn status_after(&self, number: u64) -> Option<(u64, Arc<str>)> {
        let state = self.hub.state();
        state.status.clone().filter(|(newest, _)| *newest > number)
    }

    /// Returns whether the server is ending.
    pub(crate) fn is_over(&self) -> bool {
        self.hub.is_over()
    }

    /// Returns the event descriptor that wakes the client, for others that have news for it.
    pub(crate) fn bell(&self) -> Arc<OwnedFd> {
        self.bell.clone()
    }

    /// Resets the event descriptor, so that it can wake the client again.
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
            // The next client must not see an old picture first.
            (state.newest, state.status) = (None, state.status.take());
        }
        drop(state);
        self.hub.changed.notify_all();
    }
}

/// Readers of the frames and centerlines that belong to the descriptors.
#[derive(Default)]
struct Sources {
    frames: Option<Ordered<[u8]>>,
    centerlines: Option<Ordered<Centerlines>>,
    /// When to check again whether the channels are written.
    due_ns: u64,
    /// Number of the last moment, and its frame.
    number: u64,
    shown: Option<(u64, u64)>,
}

impl Sources {
    /// Closes the readers, and keeps the number.
    fn closed(self) -> Self {
        Self {
            number: self.number,
            ..Self::default()
        }
    }

    /// Becomes a reader where there is a writer. A reader that came first would create the channel,
    /// and a chain that asks for another delivery would be refused.
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

    /// Returns the moment of the newest descriptors; `None` if it was shown, is not wanted, or its
    /// image is yet to come.
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

/// Returns a key that orders frames by their capture: by time, then by number.
fn key(trace: &Trace) -> (u64, u64) {
    (trace.captured_ns, trace.captured)
}

/// A message that belongs to a frame.
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

/// A reader that gives one frame's message after another, and keeps those of later frames.
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

    /// Returns the message of this frame. Older ones are skipped.
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
