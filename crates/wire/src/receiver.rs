//! The receiving side of a channel.

use std::fmt;
use std::ops::Deref;
use std::os::fd::BorrowedFd;
use std::time::{Duration, Instant};

use iceoryx2::port::subscriber::{Subscriber, SubscriberCreateError};
use iceoryx2::prelude::*;
use iceoryx2::sample::Sample;
use iceoryx2::service::port_factory::PortFactory as _;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;

use crate::channel::{Channel, DESCRIPTORS, Delivery, Payload};
use crate::door::Held;
use crate::reader::WriterId;
use crate::ready::{self, Ear};
use crate::{Centerlines, Command, Descriptors, Descriptors3, Domain, FrameHeader, Rig, WireError};

/// A reader of a channel. It can be there before the writer, and outlives it: messages come again when a writer does.
pub struct Receiver<P: Payload + ?Sized> {
    // Before the service, so that it is dropped first.
    subscriber: Held<Subscriber<ipc::Service, P, P::Header>>,
    service: Held<PortFactory<ipc::Service, P, P::Header>>,
    /// `None`: a reader that is never woken.
    ear: Option<Ear>,
    /// How long it looks for a message before it sleeps.
    looks_for: Duration,
    name: String,
}

impl<P: Payload + ?Sized> fmt::Debug for Receiver<P> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_struct("Receiver")
            .field("channel", &self.name)
            .finish_non_exhaustive()
    }
}

impl Receiver<Descriptors> {
    /// Reads the descriptors of a rig, as a control loop does.
    ///
    /// ```no_run
    /// use std::time::{Duration, Instant};
    /// let domain = lariat_wire::Domain::open()?;
    /// let reader = lariat_wire::Receiver::descriptors(&domain, &"default".parse()?)?;
    /// while let Some(shapes) = reader.wait(Instant::now() + Duration::from_millis(100))? {
    ///     for curve in shapes.curves() {
    ///         println!("{:?}", curve.control_points());
    ///     }
    /// }
    /// # Ok::<(), lariat_wire::WireError>(())
    /// ```
    pub fn descriptors(domain: &Domain, rig: &Rig) -> Result<Self, WireError> {
        Self::create(domain, rig, &DESCRIPTORS, None)
    }

    /// The same for a reader who wants the newest only: then one message waits for it, and there is none to be skipped. On
    /// a lossless channel, whose writer would wait for it with each, as many wait as ever.
    pub(crate) fn newest_descriptors(domain: &Domain, rig: &Rig) -> Result<Self, WireError> {
        let ear = Ear::new(domain, &DESCRIPTORS.on(rig), DESCRIPTORS.readers)?;
        Self::new(domain, rig, &DESCRIPTORS, None, Some(ear), Waiting::Newest)
    }
}

/// How many messages wait for a reader.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Waiting {
    /// As many as the channel has room for.
    All,
    /// The newest, where it may take the place of the one before.
    Newest,
}

impl<P: Payload + ?Sized> Receiver<P> {
    /// Becomes a reader of a rig's channel. `delivery`: how the channel must be; `None` takes it as it is.
    pub fn create(
        domain: &Domain,
        rig: &Rig,
        channel: &Channel<P>,
        delivery: Option<&Delivery>,
    ) -> Result<Self, WireError> {
        // The ear first: a message that comes between the two is then heard of.
        let ear = Ear::new(domain, &channel.on(rig), channel.readers)?;
        Self::new(domain, rig, channel, delivery, Some(ear), Waiting::All)
    }

    /// The same, but never woken: it looks when something else wakes its process, and costs the writer no notification.
    pub fn create_unwoken(
        domain: &Domain,
        rig: &Rig,
        channel: &Channel<P>,
        delivery: Option<&Delivery>,
    ) -> Result<Self, WireError> {
        Self::new(domain, rig, channel, delivery, None, Waiting::All)
    }

    fn new(
        domain: &Domain,
        rig: &Rig,
        channel: &Channel<P>,
        delivery: Option<&Delivery>,
        ear: Option<Ear>,
        waiting: Waiting,
    ) -> Result<Self, WireError> {
        let name = channel.on(rig);
        let service = channel.open(domain, rig, delivery)?;
        let mut builder = service.subscriber_builder();
        if waiting == Waiting::Newest && service.static_config().has_safe_overflow() {
            builder = builder.buffer_size(1);
        }
        let subscriber = domain
            .door
            .hold(|| builder.create())?
            .map_err(|cause| match cause {
                SubscriberCreateError::ExceedsMaxSupportedSubscribers => {
                    WireError::TooManyReaders {
                        channel: name.clone(),
                        most: channel.readers,
                    }
                }
                cause => WireError::transport(format!("becoming a reader of {name}"), cause),
            })?;
        Ok(Self {
            subscriber,
            service,
            ear,
            looks_for: Duration::ZERO,
            name,
        })
    }

    /// Whether each message reaches it, because the writer waits for it.
    pub(crate) fn is_lossless(&self) -> bool {
        !self.service.static_config().has_safe_overflow()
    }

    /// Lets [`sleep`](Self::sleep) and [`wait`](Self::wait) look for messages for so long, with the core all to
    /// themselves, before they sleep: what comes meanwhile is in hand some microseconds earlier, and its writer need
    /// not wake anyone. For a reader with a core of its own. From the start on, this is zero.
    pub fn look_for(&mut self, time: Duration) {
        self.looks_for = time;
    }

    /// The oldest message that waits, without blocking; `None` if there is none.
    ///
    /// A reader may hold two messages at a time: called with both in hand, this is an error.
    pub fn next(&self) -> Result<Option<Message<P>>, WireError> {
        let sample = P::receive(&self.subscriber)
            .map_err(|cause| WireError::transport(format!("reading from {}", self.name), cause))?;
        Ok(sample.map(|sample| Message { sample }))
    }

    /// The newest message that waits, without blocking; `None` if nothing came since the last.
    pub fn latest(&self) -> Result<Option<Message<P>>, WireError> {
        self.next()?
            .map(|first| self.newest_after(first))
            .transpose()
    }

    /// The newest message that waits, without blocking; this one if nothing came after it.
    pub fn newest_after(&self, mut message: Message<P>) -> Result<Message<P>, WireError> {
        while let Some(newer) = self.next()? {
            message = newer;
        }
        Ok(message)
    }

    /// The newest message, waited for until the deadline; `None` if nothing came.
    pub fn wait(&self, deadline: Instant) -> Result<Option<Message<P>>, WireError> {
        loop {
            if let Some(message) = self.latest()? {
                return Ok(Some(message));
            }
            if Instant::now() >= deadline {
                return Ok(None);
            }
            self.sleep(Some(deadline), None)?;
        }
    }

    /// Sleeps until a message waits or may wait, until `also` is readable, a signal came, or the deadline is over.
    /// Call [`next`](Self::next) or [`latest`](Self::latest) after it.
    pub fn sleep(
        &self,
        deadline: Option<Instant>,
        also: Option<BorrowedFd>,
    ) -> Result<(), WireError> {
        sleep_for_any([self], deadline, also)
    }

    /// Makes ready for a `poll` on the [`descriptor`](Self::descriptor): how long it may sleep at most; `None` without
    /// limit, zero if a message waits.
    pub fn before_poll(&self) -> Result<Option<Duration>, WireError> {
        if self.attend()? {
            return Ok(Some(Duration::ZERO));
        }
        Ok(self.ear.as_ref().and_then(Ear::longest_sleep))
    }

    /// Becomes readable when a message came: for a `poll` of one's own, with a timeout of 100 ms at most, after a
    /// [`sleep`](Self::sleep) whose deadline is over has emptied it. `None` for a reader that is never woken.
    pub fn descriptor(&self) -> Option<BorrowedFd<'_>> {
        self.ear.as_ref().map(Ear::descriptor)
    }
}

/// A reader of any channel, to [`sleep_for_any`].
pub trait Woken {
    #[doc(hidden)]
    fn ear(&self) -> Option<&Ear>;

    #[doc(hidden)]
    fn attend(&self) -> Result<bool, WireError>;

    #[doc(hidden)]
    fn waits(&self) -> Result<bool, WireError>;

    #[doc(hidden)]
    fn looks_for(&self) -> Duration;
}

impl<P: Payload + ?Sized> Woken for Receiver<P> {
    fn ear(&self) -> Option<&Ear> {
        self.ear.as_ref()
    }

    /// Makes ready to sleep; `true` if there is no reason to, because a message waits.
    ///
    /// Empties the bell, which would ring for ever otherwise; looks for messages after it, because one whose ring was
    /// emptied would be slept over; and answers a lossless writer's call.
    fn attend(&self) -> Result<bool, WireError> {
        let Some(ear) = &self.ear else {
            return Ok(false);
        };
        let called = ear.empty()?.called;
        // Looking also takes up this reader's end of a new writer's channel, which is what a call asks for.
        let waits = self.waits()?;
        if called {
            ear.answer();
        }
        Ok(waits)
    }

    fn waits(&self) -> Result<bool, WireError> {
        self.subscriber
            .has_samples()
            .map_err(|cause| WireError::transport(format!("reading from {}", self.name), cause))
    }

    fn looks_for(&self) -> Duration {
        self.looks_for
    }
}

/// Sleeps until a message waits or may wait for one of the readers, until `also` is readable, a signal came, or the
/// deadline is over.
pub fn sleep_for_any<const N: usize>(
    readers: [&dyn Woken; N],
    deadline: Option<Instant>,
    also: Option<BorrowedFd>,
) -> Result<(), WireError> {
    // Before the bells are emptied: while they are rung, writers need not ring them again.
    let looks_for = readers.iter().map(|reader| reader.looks_for()).max();
    if let Some(time) = looks_for.filter(|time| !time.is_zero())
        && look(&readers, time, deadline)?
    {
        return Ok(());
    }
    for reader in readers {
        if reader.attend()? {
            return Ok(());
        }
    }
    ready::wait(readers.map(Woken::ear), deadline, also)
}

/// Looks for a message for so long; `false` if none came.
fn look(
    readers: &[&dyn Woken],
    time: Duration,
    deadline: Option<Instant>,
) -> Result<bool, WireError> {
    let began = Instant::now();
    let until = deadline.map_or(began + time, |deadline| deadline.min(began + time));
    loop {
        for reader in readers {
            if reader.waits()? {
                return Ok(true);
            }
        }
        if Instant::now() >= until {
            return Ok(false);
        }
        std::hint::spin_loop();
    }
}

/// A message in shared memory. Held, it keeps its slot from being used again.
pub struct Message<P: Payload + ?Sized> {
    sample: Sample<ipc::Service, P, P::Header>,
}

impl<P: Payload + ?Sized> Message<P> {
    /// Who sent it.
    pub(crate) fn writer(&self) -> WriterId {
        self.sample.origin()
    }
}

impl Message<[u8]> {
    /// What stands beside the pixels.
    pub fn header(&self) -> &FrameHeader {
        self.sample.user_header()
    }
}

macro_rules! message_access {
    ($payload:ty) => {
        impl Deref for Message<$payload> {
            type Target = $payload;
            fn deref(&self) -> &$payload {
                self.sample.payload()
            }
        }
    };
}
message_access!(Centerlines);
message_access!(Command);
message_access!(Descriptors);
message_access!(Descriptors3);
message_access!([u8]);
