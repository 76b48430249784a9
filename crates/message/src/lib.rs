//! The messages between lariat's processes, the meaning of their numbers, and the common clock,
//! without the transport.
//!
//! `lariat-wire` sends and receives these messages and re-exports this crate, so control loops need
//! only that one. Programs that create, store or read messages without shared memory depend on this
//! crate alone.
//!
//! - [`FrameHeader`]: describes an image
//! - [`Centerlines`]: what extract saw
//! - [`Descriptors`], [`Descriptors3`]: the shapes of ropes, in the image and in 3-D
//! - [`Command`]: velocities for the simulated robot's grippers
//! - [`Trace`]: a frame's counters and stamps
//! - [`Basis`], [`PixelFormat`], [`Status`], [`Unit`] and others: codes in messages
//! - [`now_ns`]: the clock
//! - [`fields`]: the layout of every message, for other languages
//!
//! # Known limitations
//!
//! - A message has a fixed size, whatever it contains. Entries after a `count` are stale.
//! - Messages of different versions (`lariat.Descriptors.v9`) are not compatible.

mod clock;
mod codes;
pub mod fields;
mod message;

pub use clock::now_ns;
pub use codes::{Axes, Basis, FitQuality, PixelFormat, Place, SourceKind, Status, Unit};
pub use message::*;

/// Confidence below which a rope's curve is more likely wrong than right, and should not be used
/// for steering. It is the default threshold of readers. Commands and pages mark ropes below it.
pub const MIN_CONFIDENCE: f32 = 0.5;
