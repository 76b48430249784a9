//! The messages between lariat's processes, what their numbers stand for, and the clock that all of them read: the contract,
//! without the transport that carries it.
//!
//! `lariat-wire` sends and receives them, and gives out all of this under its own name: a control loop needs no more than that.
//! Whoever makes messages, keeps them or reads them from files needs no shared memory, and depends on this crate alone.

mod clock;
mod codes;
pub mod fields;
mod message;

pub use clock::now_ns;
pub use codes::{Axes, Basis, FitQuality, PixelFormat, Place, SourceKind, Status, Unit};
pub use message::*;

/// Confidence below which a rope's curve is more likely wrong than right, so that nothing should steer by it: the default of
/// readers, and the mark at which commands and pages make a rope stand out.
pub const MIN_CONFIDENCE: f32 = 0.5;
