//! The contract between lariat's processes: messages, services, clock, readers and writers.
//!
//! The only crate that knows the transport (iceoryx2), and all that a control loop links.

mod clock;
mod message;

pub use clock::now_ns;
pub use message::*;
