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

/// A reader of a channel. It may be opened before the writer, and outlives it: messages arrive
/// again when there is a new writer.
pub struct Receiver<P: Payload + ?Sized> {
    // Declared before the service, so that it is dropped first.
    subscriber: Held<Subscriber<ipc::Service, P, P::Header>>,
    service: Held<PortFactory<ipc::Service, P, P::Header>>,
    /// `None` for a reader that is never woken.
    ear: Option<Ear>,
    /// Time for which it spins before it sleeps.
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

    /// Creates a reader of descriptors that wants only the newest one, so that a single message
    /// waits for it. On a lossless channel, the writer would then wait after every message, so
    /// there the usual number of messages may wait.
    pub(crate) fn newest_descriptors(domain: &Domain, rig: &Rig) -> Result<Self, WireError> {
        let ear = Ear::new(domain, &DESCRIPTORS.on(rig), DESCRIPTORS.readers)?;
        Self::new(domain, rig, &DESCRIPTORS, None, Some(ear), Waiting::Newest)
    }
}

/// Number of messages that wait for a reader.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Waiting {
    /// Up to the limit of the channel.
    All,
    /// Only the newest, if it may replace the previous one.
    Newest,
}

impl<P: Payload + ?Sized> Receiver<P> {
    /// Creates a reader of a rig's channel. `delivery` is the required delivery; `None` accepts
    /// either.
    pub fn create(
        domain: &Domain,
        rig: &Rig,
        channel: &Channel<P>,
        delivery: Option<&Delivery>,
    ) -> Result<Self, WireError> {
        // The listener comes first, so that a message in between is noticed.
        let ear = Ear::new(domain, &channel.on(rig), channel.readers)?;
        Self::new(domain, rig, channel, delivery, Some(ear), Waiting::All)
    }

    /// Creates a reader that is never woken. It checks for messages when something else wakes its
    /// process, and saves the writer a notification.
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

    /// Returns whether this reader receives every message, because the writer waits for slow
    /// readers.
    pub(crate) fn is_lossless(&self) -> bool {
        !self.service.static_config().has_safe_overflow()
    }

    /// Lets [`sleep`](Self::sleep) and [`wait`](Self::wait) spin for this time before they sleep.
    /// Use it for a reader with its own core. A message that arrives in that time is received some
    /// microseconds earlier, and its writer need not wake anyone. The default is zero.
    pub fn look_for(&mut self, time: Duration) {
        self.looks_for = time;
    }

    /// Returns the oldest waiting message without blocking; `None` if nothing waits.
    ///
    /// A reader may hold two messages at a time; calling this while it holds both is an error.
    pub fn next(&self) -> Result<Option<Message<P>>, WireError> {
        let sample = P::receive(&self.subscriber)
            .map_err(|cause| WireError::transport(format!("reading from {}", self.name), cause))?;
        Ok(sample.map(|sample| Message { sample }))
    }

    /// Returns the newest waiting message without blocking; `None` if nothing new has arrived.
    pub fn latest(&self) -> Result<Option<Message<P>>, WireError> {
        self.next()?
            .map(|first| self.newest_after(first))
            .transpose()
    }

    /// Returns the newest waiting message without blocking, or `message` if nothing waits.
    pub fn newest_after(&self, mut message: Message<P>) -> Result<Message<P>, WireError> {
        while let Some(newer) = self.next()? {
            message = newer;
        }
        Ok(message)
    }

    /// Waits for the newest message until the deadline; `None` if nothing arrived.
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

    /// Sleeps until a message waits or may wait, `also` is readable, a signal arrives, or the
    /// deadline passes. Call [`next`](Self::next) or [`latest`](Self::latest) afterwards.
    pub fn sleep(
        &self,
        deadline: Option<Instant>,
        also: Option<BorrowedFd>,
    ) -> Result<(), WireError> {
        sleep_for_any([self], deadline, also)
    }

    /// Prepares for a `poll` on the [`descriptor`](Self::descriptor). Returns its maximum timeout:
    /// `None` is unlimited, and zero means that a message waits.
    pub fn before_poll(&self) -> Result<Option<Duration>, WireError> {
        if self.attend()? {
            return Ok(Some(Duration::ZERO));
        }
        Ok(self.ear.as_ref().and_then(Ear::longest_sleep))
    }

    /// Descriptor that becomes readable when a message arrives. Use it in your own `poll`, with a
    /// timeout of at most 100 ms. Before the `poll`, drain it by a [`sleep`](Self::sleep) with an
    /// expired deadline. `None` for a reader that is never woken.
    pub fn descriptor(&self) -> Option<BorrowedFd<'_>> {
        self.ear.as_ref().map(Ear::descriptor)
    }
}

/// A reader of any channel, for [`sleep_for_any`].
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

    /// Prepares to sleep. Returns `true` if there is no need to, because a message waits.
    ///
    /// Drains the notifications, because the descriptor would stay readable otherwise. Then checks
    /// for messages, because one with a drained notification would be missed. Also answers a
    /// lossless writer's call.
    fn attend(&self) -> Result<bool, WireError> {
        let Some(ear) = &self.ear else {
            return Ok(false);
        };
        let called = ear.empty()?.called;
        // This check also connects this reader to a new writer, as a call requests.
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

/// Sleeps until a message waits or may wait for one of the readers, `also` is readable, a signal
/// arrives, or the deadline passes.
pub fn sleep_for_any<const N: usize>(
    readers: [&dyn Woken; N],
    deadline: Option<Instant>,
    also: Option<BorrowedFd>,
) -> Result<(), WireError> {
    // Spin before draining: while a notification is pending, writers need not send another.
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

/// Spins until a message arrives, for at most this time; `false` if none arrived.
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

/// A message in shared memory. While it exists, its slot is not used again.
pub struct Message<P: Payload + ?Sized> {
    sample: Sample<ipc::Service, P, P::Header>,
}

impl<P: Payload + ?Sized> Message<P> {
    /// The writer that sent it.
    pub(crate) fn writer(&self) -> WriterId {
        self.sample.origin()
    }
}

impl Message<[u8]> {
    /// Header of the image.
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
