//! The contract between lariat's processes: messages, channels, clock, readers and writers.
//!
//! The only crate that knows the transport (iceoryx2), and all that a control loop links. A process opens a
//! [`Domain`] once, then [`Receiver`]s and [`Writer`]s of the channels of a [`Rig`].

mod channel;
mod clock;
mod codes;
mod domain;
mod error;
mod holdings;
mod leftovers;
mod memory;
mod message;
mod patience;
mod ready;
mod receiver;
mod relay;
mod roster;
mod survey;
mod writer;

pub use channel::{CENTERLINES, Channel, DESCRIPTORS, Delivery, FRAMES, MASKS, Payload, TRUTH};
pub use clock::now_ns;
pub use codes::{Basis, PixelFormat, SourceKind, Status, Unit};
pub use domain::{Domain, Rig};
pub use error::WireError;
pub use holdings::holdings;
pub use leftovers::{Leftover, leftovers, remove_leftovers};
pub use message::*;
pub use receiver::{Message, Receiver, Woken, sleep_for_any};
pub use relay::{RelayMessage, RelayReceiver, RelaySender};
pub use roster::{Announcement, Member, members};
pub use survey::{ChannelEnds, ChannelState, ChannelWriter};
pub use writer::{Slot, Writer};
