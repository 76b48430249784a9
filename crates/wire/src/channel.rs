//! The channels of a rig: their names, their message types and their buffer sizes.

use std::fmt::Debug;
use std::marker::PhantomData;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use iceoryx2::prelude::*;
use iceoryx2::sample::Sample;
use iceoryx2::service::builder::publish_subscribe::{
    Builder, PublishSubscribeCreateError as CreateError, PublishSubscribeOpenError as OpenError,
    PublishSubscribeOpenOrCreateError as OpenOrCreateError,
};
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;
use iceoryx2::service::static_config::message_type_details::{TypeDetail, TypeVariant};

use crate::door::Held;
use crate::making;
use crate::survey::{ChannelEnds, ends_of};
use crate::{
    Centerlines, Command, Descriptors, Descriptors3, Domain, FrameHeader, Rig, WireError, tidy,
};

/// A kind of channel. Every rig has one channel of each kind.
#[derive(Debug)]
pub struct Channel<P: ?Sized> {
    name: &'static str,
    /// Maximum number of messages waiting for a reader.
    buffer: usize,
    /// Number of past messages given to a late reader.
    history: usize,
    /// Maximum number of readers.
    pub(crate) readers: usize,
    payload: PhantomData<fn(&P)>,
}

/// Messages of one channel that a reader may hold at once: the current one and its replacement.
const BORROWED: usize = 2;
/// Maximum number of processes that may have a channel open, including those that only inspect it.
const NODES: usize = 40;

/// Images. Three may wait: enough for a stage that is delayed by three frame periods, few enough
/// that the oldest waiting image stays recent.
pub const FRAMES: Channel<[u8]> = Channel::new("frames", 3, 0, 4);
/// Masks that another process computes from frames. Each is a `Gray8` of its frame's size and
/// carries the frame's trace.
pub const MASKS: Channel<[u8]> = Channel::new("masks", 3, 0, 4);
/// Depth images that accompany frames. Each is a `Gray16` of the depth camera's own size and
/// carries the frame's trace. Nearly as many depth images as centerlines may wait, because fit
/// reads each depth image only when its frame arrives.
pub const DEPTH: Channel<[u8]> = Channel::new("depth", 6, 0, 3);
/// Output of extract. After a delay of three frames, extract sends those three at once in addition
/// to the messages that already wait.
pub const CENTERLINES: Channel<Centerlines> = Channel::new("centerlines", 8, 0, 6);
/// Input of control loops. A late reader receives the newest message at once.
pub const DESCRIPTORS: Channel<Descriptors> = Channel::new("descriptors", 8, 1, 24);
/// Shapes in space, if there is a depth camera. The message of a frame is sent before its
/// descriptors.
pub const DESCRIPTORS3: Channel<Descriptors3> = Channel::new("descriptors3", 8, 1, 12);
/// True centerlines of rendered frames.
pub const TRUTH: Channel<Centerlines> = Channel::new("truth", 8, 0, 4);
/// True positions of lifted simulated ropes: points without curves, in the robot's frame.
pub const TRUTH3: Channel<Descriptors3> = Channel::new("truth3", 8, 0, 4);
/// Commands from a controller to the simulated robot. The newest always wins, because a robot does
/// not wait for a reader.
pub const COMMANDS: Channel<Command> = Channel::new("commands", 8, 0, 4);

impl<P: ?Sized> Channel<P> {
    const fn new(name: &'static str, buffer: usize, history: usize, readers: usize) -> Self {
        Self {
            name,
            buffer,
            history,
            readers,
            payload: PhantomData,
        }
    }

    /// Name of the channel, the same on every rig.
    pub const fn name(&self) -> &'static str {
        self.name
    }

    /// Full name of the channel on a rig.
    pub fn on(&self, rig: &Rig) -> String {
        format!("lariat/{rig}/{}", self.name)
    }
}

/// A channel of any message type.
pub(crate) struct Any {
    /// Name of the channel.
    pub(crate) name: &'static str,
    /// Versioned names of its message types.
    pub(crate) types: fn() -> String,
    /// Finds the processes at the channel's ends, by the channel's full name on a rig.
    pub(crate) ends: fn(&Domain, &ServiceName) -> Option<ChannelEnds>,
}

/// All channels of a rig, in the order in which a frame passes them.
pub(crate) const ALL: &[Any] = &[
    Any::of(&FRAMES),
    Any::of(&MASKS),
    Any::of(&DEPTH),
    Any::of(&CENTERLINES),
    Any::of(&DESCRIPTORS3),
    Any::of(&DESCRIPTORS),
    Any::of(&TRUTH),
    Any::of(&TRUTH3),
    Any::of(&COMMANDS),
];

impl Any {
    const fn of<P: Payload + ?Sized>(channel: &Channel<P>) -> Self {
        Self {
            name: channel.name,
            types: P::types,
            ends: P::ends,
        }
    }
}

/// Policy for messages when a reader is slow.
#[derive(Debug, Clone)]
pub enum Delivery {
    /// A new message replaces the oldest waiting one, so a slow reader never slows the writer.
    NewestWins,
    /// The writer waits for free space. For sources that can wait, such as files.
    Lossless {
        /// Set when the writer shuts down: it then waits only a few more seconds for a slow reader.
        stop: Arc<AtomicBool>,
    },
}

impl Delivery {
    fn overflows(&self) -> bool {
        matches!(self, Self::NewestWins)
    }
}

/// A type that can travel on a channel: the messages and the bytes of a frame.
pub trait Payload: IceoryxSend + ZeroCopySend + Debug + sealed::Sealed + 'static {
    /// Header sent along with the payload.
    type Header: ZeroCopySend + Debug + 'static;

    /// Names of this program's types in the transport.
    #[doc(hidden)]
    fn types() -> String;

    /// Finds the processes at the ends of a channel that carries this type.
    #[doc(hidden)]
    fn ends(domain: &Domain, name: &ServiceName) -> Option<ChannelEnds>;

    #[doc(hidden)]
    fn open_or_create(
        builder: Builder<Self, Self::Header, ipc::Service>,
    ) -> Result<PortFactory<ipc::Service, Self, Self::Header>, OpenOrCreateError>;

    #[doc(hidden)]
    fn receive(
        subscriber: &iceoryx2::port::subscriber::Subscriber<ipc::Service, Self, Self::Header>,
    ) -> Result<Option<Sample<ipc::Service, Self, Self::Header>>, iceoryx2::port::ReceiveError>;
}

mod sealed {
    pub trait Sealed {}
}

macro_rules! payload {
    ($type:ty, $header:ty, $element:ty) => {
        impl sealed::Sealed for $type {}
        impl Payload for $type {
            type Header = $header;
            fn types() -> String {
                describe(
                    &TypeDetail::new::<$element>(TypeVariant::FixedSize),
                    &TypeDetail::new::<$header>(TypeVariant::FixedSize),
                )
            }
            fn ends(domain: &Domain, name: &ServiceName) -> Option<ChannelEnds> {
                let builder = domain.node.service_builder(name);
                let service = builder.publish_subscribe::<Self>().user_header::<$header>();
                Some(ends_of(&service.open().ok()?, size_of::<$element>()))
            }
            fn open_or_create(
                builder: Builder<Self, Self::Header, ipc::Service>,
            ) -> Result<PortFactory<ipc::Service, Self, Self::Header>, OpenOrCreateError> {
                builder.open_or_create()
            }
            fn receive(
                subscriber: &iceoryx2::port::subscriber::Subscriber<
                    ipc::Service,
                    Self,
                    Self::Header,
                >,
            ) -> Result<
                Option<Sample<ipc::Service, Self, Self::Header>>,
                iceoryx2::port::ReceiveError,
            > {
                subscriber.receive()
            }
        }
    };
}
payload!(Centerlines, (), Centerlines);
payload!(Command, (), Command);
payload!(Descriptors, (), Descriptors);
payload!(Descriptors3, (), Descriptors3);
payload!([u8], FrameHeader, u8);

impl<P: Payload + ?Sized> Channel<P> {
    /// Opens the channel of a rig, or creates it. A `delivery` of `None` accepts either kind.
    pub(crate) fn open(
        &self,
        domain: &Domain,
        rig: &Rig,
        delivery: Option<&Delivery>,
    ) -> Result<Held<PortFactory<ipc::Service, P, P::Header>>, WireError> {
        let name = self.on(rig);
        let service_name = ServiceName::new(&name)
            .map_err(|cause| WireError::transport(format!("naming {name}"), cause))?;
        let overflow = || match delivery {
            Some(delivery) => delivery.overflows(),
            None => in_use(domain, &service_name).is_none_or(|seen| seen.overflow),
        };
        let attempt = || {
            let builder = domain
                .node
                .service_builder(&service_name)
                .publish_subscribe::<P>()
                .user_header::<P::Header>()
                .enable_safe_overflow(overflow())
                .subscriber_max_buffer_size(self.buffer)
                .subscriber_max_borrowed_samples(BORROWED)
                .history_size(self.history)
                .max_publishers(1)
                .max_subscribers(self.readers)
                .max_nodes(NODES);
            P::open_or_create(builder)
        };
        making::make(domain, attempt, passes)?
            .map_err(|cause| self.explain(domain, &service_name, cause, overflow()))
    }

    /// Returns the delivery for a rig's channel. `lossless` sets it; `None` takes the delivery of
    /// the open channel, or `NewestWins` if the channel is not open. `stop` becomes part of a
    /// lossless delivery.
    pub(crate) fn delivery(
        &self,
        domain: &Domain,
        rig: &Rig,
        lossless: Option<bool>,
        stop: &Arc<AtomicBool>,
    ) -> Result<Delivery, WireError> {
        let name = self.on(rig);
        let service_name = ServiceName::new(&name)
            .map_err(|cause| WireError::transport(format!("naming {name}"), cause))?;
        let is_lossless = match lossless {
            Some(lossless) => lossless,
            None => looked_up(domain, &service_name)?.is_some_and(|seen| !seen.overflow),
        };
        Ok(if is_lossless {
            Delivery::Lossless { stop: stop.clone() }
        } else {
            Delivery::NewestWins
        })
    }

    fn explain(
        &self,
        domain: &Domain,
        name: &ServiceName,
        cause: OpenOrCreateError,
        overflow: bool,
    ) -> WireError {
        let channel = name.as_str().to_string();
        match cause {
            OpenOrCreateError::PublishSubscribeOpenError(
                OpenError::IncompatibleOverflowBehavior,
            ) => {
                let word = |overflow| {
                    if overflow {
                        "with the newest winning"
                    } else {
                        "with --lossless"
                    }
                };
                WireError::Delivery {
                    channel,
                    ours: word(overflow),
                    theirs: word(!overflow),
                }
            }
            OpenOrCreateError::PublishSubscribeOpenError(OpenError::InsufficientPermissions)
            | OpenOrCreateError::PublishSubscribeCreateError(
                CreateError::InsufficientPermissions,
            ) => WireError::Permission { channel },
            cause => match looked_up(domain, name) {
                Ok(Some(seen)) if seen.types != P::types() => WireError::Version {
                    channel,
                    ours: P::types(),
                    theirs: seen.types,
                },
                _ => WireError::transport(format!("opening {channel}"), cause),
            },
        }
    }
}

/// Returns whether the failure is transient.
fn passes(cause: &OpenOrCreateError) -> bool {
    matches!(
        cause,
        OpenOrCreateError::SystemInFlux
            | OpenOrCreateError::PublishSubscribeOpenError(
                OpenError::HangsInCreation
                    | OpenError::IsMarkedForDestruction
                    | OpenError::DoesNotExist
                    // A signal arrived. It must not end this call; the code that handles the signal
                    // learns of it afterwards.
                    | OpenError::Interrupt,
            )
            | OpenOrCreateError::PublishSubscribeCreateError(
                CreateError::IsBeingCreatedByAnotherInstance
                    | CreateError::AlreadyExists
                    | CreateError::Interrupt,
            )
    )
}

/// Properties of an existing channel.
struct InUse {
    types: String,
    overflow: bool,
}

/// Inspects a channel while no other process creates or removes it.
fn looked_up(domain: &Domain, name: &ServiceName) -> Result<Option<InUse>, WireError> {
    let passing = domain.door.pass()?;
    tidy::remove_half_made(domain.config(), &passing);
    Ok(in_use(domain, name))
}

/// Inspects a channel; the caller must hold the door's pass.
fn in_use(domain: &Domain, name: &ServiceName) -> Option<InUse> {
    let details =
        ipc::Service::details(name, domain.config(), MessagingPattern::PublishSubscribe).ok()??;
    let service = details.static_details.publish_subscribe();
    let types = service.message_type_details();
    Some(InUse {
        types: describe(&types.payload, &types.user_header),
        overflow: service.has_safe_overflow(),
    })
}

/// Names both types of a channel's messages, with their versions.
pub(crate) fn describe(payload: &TypeDetail, header: &TypeDetail) -> String {
    let (payload, header) = (
        payload.type_name().to_string(),
        header.type_name().to_string(),
    );
    if header == "()" {
        payload
    } else {
        format!("{payload} with {header}")
    }
}
