#![allow(unsafe_code)] // One descriptor is borrowed by number from the transport, which offers it no other way.
//! The event service beside every channel: wakes a waiting reader, so that nothing polls or sleeps.
//!
//! Beside every channel stands the event service `…-ready`; a reader sleeps in one `poll` on it, on its
//! signals' pipe and on a deadline. Before it sleeps it empties the bell until nothing more is heard, and then looks for
//! messages once more, in this order. In iceoryx2 0.10 a ring that arrives while the bell is being emptied can be lost and
//! take all later ones with it, until the bell is emptied again; so the first sleep after a ring is no longer than 100 ms. If
//! nothing is heard after it either, no ring is on its way that could be lost, and the sleeps that follow have no bound: a rig
//! without frames is never woken (no tick of CPU and no context switch of any of its five processes in 10 s). After sending, capture yields the core: the kernel
//! puts a woken reader on its waker's core, and there the next frame's making would hold it up (0.58 ms against 0.04 ms for
//! the rendered rope). The service carries three events:
//!
//! | event | from → to | meaning |
//! |---:|---|---|
//! | 0 | writer → readers | a message was sent |
//! | 1 | writer → readers | call: take up your end of the channel |
//! | 2 | reader → writer | answer: done |
//!
//! Call and answer are for lossless writers. In iceoryx2 a new reader's end becomes a connection when each side next
//! looks, and a message to a reader that has not looked yet is dropped once that one's buffer is full, whatever the
//! overflow setting. So a lossless writer that sees more readers than it has gathered calls before it borrows the next
//! slot, waits until all have answered, and no longer than 2 s, as a reader that never sleeps never answers. Sink listens
//! to all its channels in a lossless chain for this reason; otherwise it is woken by `descriptors` alone, one wake a
//! frame, and looks into the other two meanwhile.

use std::cell::Cell;
use std::os::fd::BorrowedFd;
use std::sync::Arc;
use std::time::{Duration, Instant};

use iceoryx2::port::listener::{Listener, ListenerCreateError};
use iceoryx2::port::notifier::{Notifier, NotifierCreateError};
use iceoryx2::prelude::*;
use iceoryx2::service::builder::event::{EventCreateError, EventOpenError, EventOpenOrCreateError};
use iceoryx2::service::port_factory::event::PortFactory;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;

use crate::door::Held;
use crate::{Domain, WireError, making, umask};

/// How long a bell must have been silent before it is trusted.
///
/// In iceoryx2 0.10 a ring that comes while its listener empties the bell can be emptied too, and yet leave the bell
/// marked as rung: then every later ring is taken for one that was already sent, and none arrives. Readers look for
/// messages after emptying, so that this takes a ring that comes late, after its message was read; and emptying the bell
/// again mends it. So a reader empties until nothing is heard, and the first sleep after a ring is no longer than this.
/// If nothing is heard after that either, no ring is on its way any more and none can be lost: the sleeps that follow
/// are as long as nothing comes. A rig without frames does nothing at all.
const TRUSTED_AFTER: Duration = Duration::from_millis(100);

/// A message was sent.
const MESSAGE: usize = 0;
/// The writer asks its readers to take up their ends of the channel.
const CALL: usize = 1;
/// A reader answers that it has.
const ANSWER: usize = 2;

pub(crate) fn open(
    domain: &Domain,
    channel: &str,
    readers: usize,
) -> Result<Held<PortFactory<ipc::Service>>, WireError> {
    let name = format!("{channel}-ready");
    let service = ServiceName::new(&name)
        .map_err(|cause| WireError::transport(format!("naming {name}"), cause))?;
    let attempt = || {
        domain
            .node
            .service_builder(&service)
            .event()
            .max_listeners(readers + 1)
            .max_notifiers(readers + 2)
            .max_nodes(40)
            .event_id_max_value(ANSWER)
            .open_or_create()
    };
    making::make(domain, attempt, passes)?
        .map_err(|cause| WireError::transport(format!("opening {name}"), cause))
}

/// Whether it may be otherwise a moment later.
fn passes(cause: &EventOpenOrCreateError) -> bool {
    matches!(
        cause,
        EventOpenOrCreateError::SystemInFlux
            | EventOpenOrCreateError::EventOpenError(
                EventOpenError::HangsInCreation
                    | EventOpenError::IsMarkedForDestruction
                    | EventOpenError::DoesNotExist
                    | EventOpenError::Interrupt,
            )
            | EventOpenOrCreateError::EventCreateError(
                EventCreateError::IsBeingCreatedByAnotherInstance
                    | EventCreateError::AlreadyExists
                    | EventCreateError::Interrupt,
            )
    )
}

/// Each reader has an ear, and a bell to answer with: without a place for them it has none on the channel either.
fn too_many(channel: &str, readers: usize) -> WireError {
    WireError::TooManyReaders {
        channel: channel.to_owned(),
        most: readers,
    }
}

/// The writer's side.
#[derive(Debug)]
pub(crate) struct Bell(Held<Notifier<ipc::Service>>);

impl Bell {
    pub(crate) fn new(domain: &Domain, channel: &str, readers: usize) -> Result<Self, WireError> {
        let service = open(domain, channel, readers)?;
        let notifier = domain.door.hold(|| service.notifier_builder().create())?;
        notifier.map(Self).map_err(|cause| match cause {
            NotifierCreateError::ExceedsMaxSupportedNotifiers => too_many(channel, readers),
            cause => WireError::transport(format!("waking readers of {channel}"), cause),
        })
    }

    /// Wakes every waiting reader. A reader that died is no reason to stop: its message was delivered all the same.
    pub(crate) fn ring(&self) {
        self.notify(MESSAGE);
    }

    /// Asks every reader to take up its end of the channel.
    pub(crate) fn call(&self) {
        self.notify(CALL);
    }

    fn notify(&self, event: usize) {
        let _ = self.0.notify_with_custom_event_id(EventId::new(event));
    }
}

/// The reader's side.
#[derive(Debug)]
pub struct Ear {
    listener: Held<Listener<ipc::Service>>,
    /// To answer with.
    bell: Bell,
    /// When it last heard something, or was made.
    heard: Cell<Instant>,
    /// Whether it has heard nothing for [`TRUSTED_AFTER`].
    trusted: Cell<bool>,
}

/// What an ear has heard.
#[derive(Debug, Default)]
pub(crate) struct Heard {
    /// The writer asks.
    pub(crate) called: bool,
    /// So many readers answered.
    pub(crate) answers: usize,
}

impl Ear {
    pub(crate) fn new(domain: &Domain, channel: &str, readers: usize) -> Result<Self, WireError> {
        let service = Arc::new(open(domain, channel, readers)?);
        let listener = domain.door.hold(|| umask::listener(&service))?;
        let listener = listener.map_err(|cause| match cause {
            ListenerCreateError::ExceedsMaxSupportedListeners => too_many(channel, readers),
            cause => WireError::transport(format!("listening to {channel}"), cause),
        })?;
        let bell = Bell::new(domain, channel, readers)?;
        Ok(Self {
            listener,
            bell,
            heard: Cell::new(Instant::now()),
            trusted: Cell::new(false),
        })
    }

    /// Becomes readable when the bell was rung.
    pub(crate) fn descriptor(&self) -> BorrowedFd<'_> {
        let descriptor = self.listener.file_descriptor();
        // SAFETY: the listener owns the descriptor and keeps it open while it lives, which is as long as this borrow.
        unsafe { BorrowedFd::borrow_raw(descriptor.native_handle()) }
    }

    /// Answers a writer's call.
    pub(crate) fn answer(&self) {
        self.bell.notify(ANSWER);
    }

    /// What was heard since the last time, without waiting.
    pub(crate) fn empty(&self) -> Result<Heard, WireError> {
        let mut heard = Heard::default();
        let mut anything = false;
        // A second time at most but for a bell that rings on and on: what comes then is heard at the next emptying.
        for _ in 0..4 {
            let rings = self
                .listener
                .try_wait(|event| match event.id.as_value() {
                    CALL => heard.called = true,
                    ANSWER => heard.answers += event.count as usize,
                    _ => {}
                })
                .map_err(|cause| WireError::transport("waiting for a message", cause))?;
            if rings == 0 {
                break;
            }
            anything = true;
        }
        if anything {
            self.trusted.set(false);
            self.heard.set(Instant::now());
        } else if !self.trusted.get() {
            self.trusted
                .set(self.heard.get().elapsed() >= TRUSTED_AFTER);
        }
        Ok(heard)
    }

    /// The longest sleep on it; `None`: as long as it is silent.
    pub(crate) fn longest_sleep(&self) -> Option<Duration> {
        (!self.trusted.get()).then_some(TRUSTED_AFTER)
    }
}

/// Waits for a bell, for `also` to become readable, for a signal, or for the deadline, whichever is first; and no longer
/// than a bell allows.
pub(crate) fn wait<const N: usize>(
    ears: [Option<&Ear>; N],
    deadline: Option<Instant>,
    also: Option<BorrowedFd>,
) -> Result<(), WireError> {
    /// More than any process listens to.
    const MOST: usize = 8;
    const { assert!(N < MOST) };
    let bells = ears.iter().flatten();
    let longest = bells.clone().filter_map(|ear| ear.longest_sleep()).min();
    let mut descriptors = bells.map(|ear| ear.descriptor()).chain(also);
    let Some(first) = descriptors.next() else {
        return Ok(());
    };
    let mut polled: [PollFd; MOST] =
        std::array::from_fn(|_| PollFd::from_borrowed_fd(first, PollFlags::IN));
    let mut count = 1;
    for descriptor in descriptors {
        polled[count] = PollFd::from_borrowed_fd(descriptor, PollFlags::IN);
        count += 1;
    }
    let left = deadline.map(|deadline| deadline.saturating_duration_since(Instant::now()));
    let left = [left, longest].into_iter().flatten().min();
    let left = left.and_then(|left| Timespec::try_from(left).ok());
    match poll(&mut polled[..count], left.as_ref()) {
        Ok(_) | Err(Errno::INTR) => Ok(()),
        Err(cause) => Err(WireError::transport("waiting for a message", cause)),
    }
}
