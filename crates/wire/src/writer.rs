#![allow(unsafe_code)] // Slots of shared memory are written in place, as they are.
//! The sending side of a channel: borrow a slot of shared memory, write into it, send it.

use std::cell::Cell;
use std::fmt;
use std::ops::{Deref, DerefMut};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use iceoryx2::port::SendError;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::*;
use iceoryx2::sample_mut::SampleMut;
use iceoryx2::service::port_factory::PortFactory as _;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;

use crate::channel::{Channel, DEPTH, Delivery, FRAMES, MASKS, Payload};
use crate::door::Held;
use crate::patience::Meanwhile;
use crate::ready::{self, Bell, Ear};
use crate::{
    Centerlines, Command, Descriptors, Descriptors3, Domain, FrameHeader, Rig, WireError, memory,
    patience, quiet,
};

/// Maximum wait of a lossless writer for its readers' answers. Only a reader that sleeps can
/// answer.
const GATHER_TIMEOUT: Duration = Duration::from_secs(2);

/// The only writer of a channel.
pub struct Writer<P: Payload + ?Sized> {
    // Declared before the service, so that it is dropped first.
    publisher: Held<Publisher<ipc::Service, P, P::Header>>,
    service: Held<PortFactory<ipc::Service, P, P::Header>>,
    bell: Bell,
    name: String,
    /// Set for a lossless writer.
    gathering: Option<Gathering>,
}

/// State of a lossless writer that connects its readers. Messages to a reader that has not
/// connected yet are dropped once its buffer is full. The writer therefore calls all readers before
/// the first message.
struct Gathering {
    ear: Ear,
    stop: Arc<AtomicBool>,
    meanwhile: Option<Meanwhile>,
    /// Number of connected readers.
    gathered: Cell<usize>,
}

impl<P: Payload + ?Sized> fmt::Debug for Writer<P> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_struct("Writer")
            .field("channel", &self.name)
            .finish_non_exhaustive()
    }
}

macro_rules! message_writer {
    ($message:ty) => {
        impl Writer<$message> {
            /// Creates the writer of a rig's channel. Fails if the channel already has a writer, or
            /// if `/dev/shm` lacks the space for its slots.
            pub fn create(
                domain: &Domain,
                rig: &Rig,
                channel: &Channel<$message>,
                delivery: &Delivery,
            ) -> Result<Self, WireError> {
                let service = Self::open(domain, rig, channel, delivery, size_of::<$message>(), 1)?;
                let builder = service.publisher_builder().max_loaned_samples(1);
                let wait = patience::with_slow_readers(domain, delivery, None);
                let publisher = domain.door.hold(|| match wait {
                    None => builder.create(),
                    Some(wait) => builder.set_backpressure_handler(wait).create(),
                })?;
                Self::finish(domain, rig, channel, delivery, service, publisher, None)
            }

            /// Borrows a slot. The slot still holds an earlier message: fields that are not written
            /// keep their old values.
            pub fn slot(&self) -> Result<Slot<'_, $message>, WireError> {
                self.gather()?;
                let sample = self
                    .publisher
                    .loan_uninit()
                    .map_err(|cause| self.broken(cause))?;
                // SAFETY: shared memory is zeroed at first and then holds only such messages; every
                // bit pattern is valid.
                let sample = unsafe { sample.assume_init() };
                Ok(Slot {
                    sample,
                    writer: self,
                })
            }
        }
    };
}
message_writer!(Centerlines);
message_writer!(Command);
message_writer!(Descriptors);
message_writer!(Descriptors3);

impl Writer<[u8]> {
    /// Creates the writer of a rig's frames, of up to `largest` bytes each.
    pub fn frames(
        domain: &Domain,
        rig: &Rig,
        delivery: &Delivery,
        largest: usize,
    ) -> Result<Self, WireError> {
        Self::images(domain, rig, &FRAMES, delivery, largest, 1, None)
    }

    /// Creates the writer of a rig's frames, which borrows up to `borrowed` slots at a time, each
    /// of up to `largest` bytes. For pixels that are written ahead of time.
    pub fn frames_ahead(
        domain: &Domain,
        rig: &Rig,
        delivery: &Delivery,
        largest: usize,
        borrowed: usize,
    ) -> Result<Self, WireError> {
        Self::images(domain, rig, &FRAMES, delivery, largest, borrowed, None)
    }

    /// Creates the writer of a rig's masks, of up to `largest` bytes each.
    pub fn masks(
        domain: &Domain,
        rig: &Rig,
        delivery: &Delivery,
        largest: usize,
    ) -> Result<Self, WireError> {
        Self::images(domain, rig, &MASKS, delivery, largest, 1, None)
    }

    /// Creates the writer of a rig's depth images, which borrows up to `borrowed` slots at a time,
    /// each of up to `largest` bytes.
    pub fn depths(
        domain: &Domain,
        rig: &Rig,
        delivery: &Delivery,
        largest: usize,
        borrowed: usize,
    ) -> Result<Self, WireError> {
        Self::images(domain, rig, &DEPTH, delivery, largest, borrowed, None)
    }

    /// Creates the writer of an image channel. `meanwhile` is called repeatedly while it waits for
    /// a slow reader.
    pub(crate) fn images(
        domain: &Domain,
        rig: &Rig,
        channel: &Channel<[u8]>,
        delivery: &Delivery,
        largest: usize,
        borrowed: usize,
        meanwhile: Option<Meanwhile>,
    ) -> Result<Self, WireError> {
        let service = Self::open(domain, rig, channel, delivery, largest, borrowed)?;
        let builder = service
            .publisher_builder()
            .max_loaned_samples(borrowed)
            .initial_max_slice_len(largest);
        let wait = patience::with_slow_readers(domain, delivery, meanwhile.clone());
        let publisher = domain.door.hold(|| match wait {
            None => builder.create(),
            Some(wait) => builder.set_backpressure_handler(wait).create(),
        })?;
        Self::finish(
            domain, rig, channel, delivery, service, publisher, meanwhile,
        )
    }

    /// Borrows a slot of `bytes` bytes for a frame or a mask. It still holds the pixels of an
    /// earlier one.
    pub fn frame_slot(&self, bytes: usize) -> Result<Slot<'_, [u8]>, WireError> {
        self.gather()?;
        let sample = self
            .publisher
            .loan_slice_uninit(bytes)
            .map_err(|cause| self.broken(cause))?;
        // SAFETY: shared memory is zeroed at first, and every byte is valid.
        let sample = unsafe { sample.assume_init() };
        Ok(Slot {
            sample,
            writer: self,
        })
    }
}

impl<P: Payload + ?Sized> Writer<P> {
    fn open(
        domain: &Domain,
        rig: &Rig,
        channel: &Channel<P>,
        delivery: &Delivery,
        slot_bytes: usize,
        borrowed: usize,
    ) -> Result<Held<PortFactory<ipc::Service, P, P::Header>>, WireError> {
        let service = channel.open(domain, rig, Some(delivery))?;
        if service.dynamic_config().number_of_publishers() > 0 {
            return Err(WireError::SecondWriter {
                channel: channel.on(rig),
            });
        }
        let kept = service.static_config();
        let slots = kept.max_subscribers()
            * (kept.subscriber_max_buffer_size() + kept.subscriber_max_borrowed_samples())
            + kept.history_size()
            + borrowed;
        // The transport's header, the user header and the alignment precede each slot.
        let slot = slot_bytes + size_of::<P::Header>() + 256;
        memory::require_space(&channel.on(rig), (slots * slot) as u64)?;
        Ok(service)
    }

    fn finish(
        domain: &Domain,
        rig: &Rig,
        channel: &Channel<P>,
        delivery: &Delivery,
        service: Held<PortFactory<ipc::Service, P, P::Header>>,
        publisher: Result<
            Held<Publisher<ipc::Service, P, P::Header>>,
            iceoryx2::port::publisher::PublisherCreateError,
        >,
        meanwhile: Option<Meanwhile>,
    ) -> Result<Self, WireError> {
        use iceoryx2::port::publisher::PublisherCreateError;
        let name = channel.on(rig);
        let publisher = publisher.map_err(|cause| match cause {
            PublisherCreateError::ExceedsMaxSupportedPublishers => WireError::SecondWriter {
                channel: name.clone(),
            },
            cause => WireError::transport(format!("becoming the writer of {name}"), cause),
        })?;
        memory::reserve_segment(&name, &publisher.id().value().to_string())?;
        let bell = Bell::new(domain, &name, channel.readers)?;
        let gathering = match delivery {
            Delivery::NewestWins => None,
            Delivery::Lossless { stop } => Some(Gathering {
                ear: Ear::new(domain, &name, channel.readers)?,
                stop: stop.clone(),
                meanwhile,
                gathered: Cell::new(0),
            }),
        };
        // Readers that sleep connect now, not with the first message.
        bell.call();
        Ok(Self {
            publisher,
            service,
            bell,
            name,
            gathering,
        })
    }

    /// The transport's ID of this writer, as in the names of its files in `/dev/shm`.
    pub fn id(&self) -> String {
        self.publisher.id().value().to_string()
    }

    /// Current number of readers of the channel.
    pub fn readers(&self) -> usize {
        self.service.dynamic_config().number_of_subscribers()
    }

    /// Delivers the newest message to readers that joined after it was sent. Otherwise they receive
    /// it together with the next message.
    pub fn welcome(&self) -> Result<(), WireError> {
        self.publisher
            .update_connections()
            .map_err(|cause| self.broken(cause))
    }

    /// Waits until every reader that joined since the last call has connected. Does nothing unless
    /// the writer is lossless.
    fn gather(&self) -> Result<(), WireError> {
        let Some(Gathering {
            ear,
            stop,
            meanwhile,
            gathered,
        }) = &self.gathering
        else {
            return Ok(());
        };
        // This writer's own listener receives the message events too and must be drained.
        ear.empty()?;
        let readers = self.readers();
        if readers <= gathered.get() {
            gathered.set(readers);
            return Ok(());
        }
        let deadline = Instant::now() + GATHER_TIMEOUT;
        self.bell.call();
        let mut answers = 0;
        while answers < readers && !stop.load(Ordering::Relaxed) && Instant::now() < deadline {
            let look_up = deadline.min(Instant::now() + patience::LOOK);
            ready::wait([Some(ear)], Some(look_up), None)?;
            meanwhile.iter().for_each(|meanwhile| meanwhile());
            answers += ear.empty()?.answers;
        }
        gathered.set(readers);
        Ok(())
    }

    fn broken(&self, cause: impl fmt::Debug) -> WireError {
        WireError::transport(format!("writing to {}", self.name), cause)
    }
}

/// A slot of shared memory that is being written. If dropped, it is returned unsent.
pub struct Slot<'a, P: Payload + ?Sized> {
    sample: SampleMut<ipc::Service, P, P::Header>,
    writer: &'a Writer<P>,
}

impl<P: Payload + ?Sized> Slot<'_, P> {
    /// Sends the message and wakes the readers. Returns `false` if the message was lost because the
    /// writer gave up waiting for a reader.
    pub fn send(self) -> Result<bool, WireError> {
        let send = || self.sample.send();
        let sent = match self.writer.gathering {
            None => send(),
            Some(_) => quiet::quietly(send),
        };
        let delivered = match sent {
            Ok(_) => true,
            Err(SendError::UnableToDeliver) => false,
            Err(cause) => return Err(self.writer.broken(cause)),
        };
        self.writer.bell.ring();
        Ok(delivered)
    }
}

/// A slot that is stored apart from its writer and returned to it for sending.
pub(crate) struct KeptSlot(SampleMut<ipc::Service, [u8], FrameHeader>);

impl KeptSlot {
    pub(crate) fn bytes_mut(&mut self) -> &mut [u8] {
        self.0.payload_mut()
    }

    /// Returns the slot to `writer`, which must be the one that it was borrowed from.
    pub(crate) fn back_to(self, writer: &Writer<[u8]>) -> Slot<'_, [u8]> {
        Slot {
            sample: self.0,
            writer,
        }
    }
}

impl Slot<'_, [u8]> {
    pub(crate) fn keep(self) -> KeptSlot {
        KeptSlot(self.sample)
    }

    /// Header of the image.
    pub fn header_mut(&mut self) -> &mut FrameHeader {
        self.sample.user_header_mut()
    }
}

macro_rules! slot_access {
    ($payload:ty) => {
        impl Deref for Slot<'_, $payload> {
            type Target = $payload;
            fn deref(&self) -> &$payload {
                self.sample.payload()
            }
        }
        impl DerefMut for Slot<'_, $payload> {
            fn deref_mut(&mut self) -> &mut $payload {
                self.sample.payload_mut()
            }
        }
    };
}
slot_access!(Centerlines);
slot_access!(Command);
slot_access!(Descriptors);
slot_access!(Descriptors3);
slot_access!([u8]);
