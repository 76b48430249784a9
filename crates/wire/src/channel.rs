//! The channels of a rig: their names, what they carry, and how much of it they keep.

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

/// One kind of channel. Every rig has one of each.
#[derive(Debug)]
pub struct Channel<P: ?Sized> {
    name: &'static str,
    /// Messages that wait for a reader.
    buffer: usize,
    /// Past messages that a late reader is given.
    history: usize,
    /// Most readers.
    pub(crate) readers: usize,
    payload: PhantomData<fn(&P)>,
}

/// Messages of one channel that a reader may hold at a time: the one in its hands, and the one that replaces it.
const BORROWED: usize = 2;
/// Processes that may have a channel open, whether they read or only look.
const NODES: usize = 40;

/// Images. Three may wait: enough for a stage that is held up for three frame periods, few enough that an old image
/// is never far behind.
pub const FRAMES: Channel<[u8]> = Channel::new("frames", 3, 0, 4);
/// Masks that another process makes of frames, each a `Gray8` of its frame's size that carries the frame's trace.
pub const MASKS: Channel<[u8]> = Channel::new("masks", 3, 0, 4);
/// Depth images beside frames, each a `Gray16` of the depth camera's own size that carries the frame's trace.
/// As many wait as centerlines may, nearly: fit reads each when its frame comes.
pub const DEPTH: Channel<[u8]> = Channel::new("depth", 6, 0, 3);
/// What extract saw. Held up for three frames, it sends those in one go behind what waits already.
pub const CENTERLINES: Channel<Centerlines> = Channel::new("centerlines", 8, 0, 6);
/// What control loops read. A late reader is given the newest at once.
pub const DESCRIPTORS: Channel<Descriptors> = Channel::new("descriptors", 8, 1, 24);
/// The same in space, where there is a depth camera: of each frame before its descriptors.
pub const DESCRIPTORS3: Channel<Descriptors3> = Channel::new("descriptors3", 8, 1, 12);
/// The true centerlines of rendered frames.
pub const TRUTH: Channel<Centerlines> = Channel::new("truth", 8, 0, 4);
/// Where lifted simulated ropes truly are: points without curves, in the robot's frame.
pub const TRUTH3: Channel<Descriptors3> = Channel::new("truth3", 8, 0, 4);
/// What a controller tells the simulated robot. Always with the newest winning: a robot waits for nobody.
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

    /// The channel's name, the same on every rig.
    pub const fn name(&self) -> &'static str {
        self.name
    }

    /// The channel's full name on a rig.
    pub fn on(&self, rig: &Rig) -> String {
        format!("lariat/{rig}/{}", self.name)
    }
}

/// A channel of any messages.
pub(crate) struct Any {
    /// The channel's name.
    pub(crate) name: &'static str,
    /// The versioned name of its messages.
    pub(crate) types: fn() -> String,
    /// Who is at its ends, by its full name on a rig.
    pub(crate) ends: fn(&Domain, &ServiceName) -> Option<ChannelEnds>,
}

/// All channels of a rig, in the order of a frame's way.
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

/// What becomes of a message when a reader is slow.
#[derive(Debug, Clone)]
pub enum Delivery {
    /// The oldest waiting message makes room: a slow reader never slows the writer.
    NewestWins,
    /// The writer waits until there is room. For sources that can wait, as files can.
    Lossless {
        /// Set: the writer is to come to its end, and waits for a slow reader only a few seconds more.
        stop: Arc<AtomicBool>,
    },
}

impl Delivery {
    fn overflows(&self) -> bool {
        matches!(self, Self::NewestWins)
    }
}

/// A type that can travel on a channel: the messages, and the bytes of a frame.
pub trait Payload: IceoryxSend + ZeroCopySend + Debug + sealed::Sealed + 'static {
    /// What stands beside it.
    type Header: ZeroCopySend + Debug + 'static;

    /// The names under which the transport knows this program's types.
    #[doc(hidden)]
    fn types() -> String;

    /// Who is at the ends of a channel that carries it.
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
    /// Opens the channel of a rig, or makes it. `delivery`: `None` takes it as it is.
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

    /// The delivery that a rig's channel is open with, or this one if nobody has it open. `None` takes either as it is, and
    /// else the newest winning; `stop`: of a lossless one.
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

/// Whether it may be otherwise a moment later.
fn passes(cause: &OpenOrCreateError) -> bool {
    matches!(
        cause,
        OpenOrCreateError::SystemInFlux
            | OpenOrCreateError::PublishSubscribeOpenError(
                OpenError::HangsInCreation
                    | OpenError::IsMarkedForDestruction
                    | OpenError::DoesNotExist
                    // A signal came, which is not to end this: whoever asked for it is told when it is done.
                    | OpenError::Interrupt,
            )
            | OpenOrCreateError::PublishSubscribeCreateError(
                CreateError::IsBeingCreatedByAnotherInstance
                    | CreateError::AlreadyExists
                    | CreateError::Interrupt,
            )
    )
}

/// What an existing channel carries.
struct InUse {
    types: String,
    overflow: bool,
}

/// As long as no other process makes or removes it.
fn looked_up(domain: &Domain, name: &ServiceName) -> Result<Option<InUse>, WireError> {
    let passing = domain.door.pass()?;
    tidy::remove_half_made(domain.config(), &passing);
    Ok(in_use(domain, name))
}

/// To be called while passing.
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

/// Both types of a channel's messages, by the names that carry their versions.
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
