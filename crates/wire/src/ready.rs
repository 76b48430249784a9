#![allow(unsafe_code)] // The transport gives its file descriptor only as a number.
//! The event service of each channel. It wakes a waiting reader, so that nothing polls or sleeps.
//!
//! Every channel has an event service named `…-ready`. A reader sleeps in one `poll` on this
//! service, on its signal pipe and on a deadline. Before it sleeps, it drains the notifications
//! until none is left, and then checks for messages once more, in this order.
//!
//! In iceoryx2 0.10, a notification that arrives during draining can be lost and block all later
//! ones until the next draining. The first sleep after a notification is therefore limited to 100
//! ms. If that sleep ends without a notification, no notification is in flight that could be lost,
//! and later sleeps are unlimited. In a rig without frames, readers never wake.
//!
//! After sending, capture yields its core. The kernel puts a woken reader on the core of the
//! process that woke it, where the work on the next frame would delay it.
//!
//! The service carries three events:
//!
//! | event | from → to | meaning |
//! |---:|---|---|
//! | 0 | writer → readers | a message was sent |
//! | 1 | writer → readers | call: connect your end of the channel |
//! | 2 | reader → writer | answer: connected |
//!
//! Calls and answers serve lossless writers. In iceoryx2, a new reader is connected only after both
//! sides have checked for changes. Until then, messages beyond that reader's buffer are dropped,
//! whatever the overflow setting. A lossless writer that sees more readers than are connected
//! therefore calls before it borrows the next slot. It waits until all have answered, but at most 2
//! s, because only a reader that sleeps can answer. For this reason, sink listens to all its
//! channels in a lossless chain. In other chains, only `descriptors` wakes sink, once per frame,
//! and sink then checks the other two channels.

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

/// Silence after which later sleeps need no limit.
///
/// In iceoryx2 0.10, a notification that arrives while its listener drains can be drained too and
/// yet leave the listener marked as notified. Every later notification then counts as already sent,
/// and none arrives. Readers check for messages after draining, so this happens only if a
/// notification is late and its message was already read. Draining again repairs it. A reader
/// therefore drains until nothing is left, and limits the first sleep after a notification to this
/// duration. If that sleep ends in silence, no notification is in flight that could be lost, and
/// later sleeps are unlimited. In a rig without frames, readers do nothing at all.
const TRUSTED_AFTER: Duration = Duration::from_millis(100);

/// A message was sent.
const MESSAGE: usize = 0;
/// The writer asks its readers to connect their ends of the channel.
const CALL: usize = 1;
/// A reader answers that it has connected.
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

/// Returns whether the failure is transient.
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

/// The error for a reader that finds no free listener or notifier. The channel is then full as
/// well.
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

    /// Wakes every waiting reader. A failed notification is ignored: the message was delivered in
    /// any case.
    pub(crate) fn ring(&self) {
        self.notify(MESSAGE);
    }

    /// Asks every reader to connect its end of the channel.
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
    /// Sends the answers.
    bell: Bell,
    /// Time of the last notification, or of creation.
    heard: Cell<Instant>,
    /// True after [`TRUSTED_AFTER`] without a notification.
    trusted: Cell<bool>,
}

/// Notifications that a reader has drained.
#[derive(Debug, Default)]
pub(crate) struct Heard {
    /// True if the writer has called.
    pub(crate) called: bool,
    /// Number of readers that answered.
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

    /// Descriptor that becomes readable on a notification.
    pub(crate) fn descriptor(&self) -> BorrowedFd<'_> {
        let descriptor = self.listener.file_descriptor();
        // SAFETY: the listener owns the descriptor and keeps it open for its lifetime, which covers
        // this borrow.
        unsafe { BorrowedFd::borrow_raw(descriptor.native_handle()) }
    }

    /// Answers a writer's call.
    pub(crate) fn answer(&self) {
        self.bell.notify(ANSWER);
    }

    /// Drains the notifications since the last time, without waiting.
    pub(crate) fn empty(&self) -> Result<Heard, WireError> {
        let mut heard = Heard::default();
        let mut anything = false;
        // Two rounds usually suffice. The limit matters only if notifications keep arriving; the
        // next draining gets those.
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

    /// Maximum duration of the next sleep; `None` is unlimited.
    pub(crate) fn longest_sleep(&self) -> Option<Duration> {
        (!self.trusted.get()).then_some(TRUSTED_AFTER)
    }
}

/// Waits for a notification, for `also` to become readable, for a signal or for the deadline. The
/// wait is no longer than each listener allows.
pub(crate) fn wait<const N: usize>(
    ears: [Option<&Ear>; N],
    deadline: Option<Instant>,
    also: Option<BorrowedFd>,
) -> Result<(), WireError> {
    /// Maximum number of descriptors, more than any process listens to.
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
