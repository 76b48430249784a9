//! The shapes of ropes for a control loop, and the channels between lariat's processes.
//!
//! A control loop needs only this crate:
//!
//! ```no_run
//! use std::time::{Duration, Instant};
//! use lariat_wire::{Reader, Seen};
//!
//! fn main() -> Result<(), Box<dyn std::error::Error>> {
//!     let mut reader = Reader::open("default")?;
//!     loop {
//!         let frame = reader.wait(Instant::now() + Duration::from_millis(50))?;
//!         match frame.only_rope(Duration::from_millis(100)) {
//!             Seen::Fresh(rope) => steer(rope.shape()?.point_at(0.5)),
//!             seen => hold(&seen), // covered, unsure, lost, stale, absent: it says which
//!         }
//!     }
//! }
//! # fn steer(_: [f64; 2]) {}
//! # fn hold(_: &Seen) {}
//! ```
//!
//! [`Reader::open`] names the rig: one camera and its chain of processes (`lariat run`). The chain
//! may start later and may be restarted. [`Reader::wait`] sleeps until a frame arrives.
//! [`Reader::latest`] never sleeps, for a loop with its own period. [`Reader::before_poll`] is for
//! a `poll` on other descriptors too. All three give a [`Frame`]: the newest message, in place in
//! shared memory, and the age of its image *now*.
//!
//! A loop asks a frame for [the only rope](Frame::only_rope) or [the rope of a track](Frame::rope),
//! and states how old the image may be. It gets a [`Seen`]. Only its first case,
//! [`Fresh`](Seen::Fresh), is the rope as it is. Covered, doubtful, lost and old shapes have to be
//! matched by name. A track of an earlier run of the chain never matches.
//!
//! Coordinates are pixels of the image, x right and y down, or in the chain's [`Unit`].
//!
//! - [`Reader`], [`Frame`], [`Seen`], [`Doubt`], [`LastKnown`], [`Absent`]: what is known now, and
//!   how reliable it is
//! - [`Rope`], [`Track`]: one rope, with its [age](Rope::age), [control
//!   points](Rope::control_points) and [confidence](Rope::confidence)
//! - [`Centerline`]: the observed points, with widths
//! - [`Shape`]: the curve `f(ρ)`: points, tangents, curvature, [`Jacobian`](Shape::jacobian_at),
//!   [`Covariance`]
//! - [`Prediction`], [`Motion`]: the rope [at a later time](Rope::predict)
//! - [`Descriptors`], [`Descriptor`], [`Trace`]: the message itself
//! - [`WireError`], [`NoShape`], [`NoPrediction`]: errors that say what to do
//!
//! A slow, stopped or killed reader disturbs neither the chain (unless it is `--lossless`) nor
//! other readers. An open reader does not allocate, and [`latest`](Reader::latest) makes no system
//! call. The exception is the connection to a chain that has just started.
//!
//! # Your own frames and masks
//!
//! [`FrameWriter`] is for a camera that lariat does not support (`lariat run --source external`).
//! [`FrameReader`] and [`MaskWriter`] are for a network that finds ropes (`mask = "external"`).
//!
//! # Channels
//!
//! Programs that replace a stage or read other channels open a [`Domain`] once, then [`Receiver`]s
//! and [`Writer`]s of the [`Channel`]s of a [`Rig`]. The messages are `lariat-message`'s. Only this
//! crate uses the transport, iceoryx2.
//!
//! # Notes
//!
//! - An exposure later than fit's own stamp counts as that stamp, so no message stays young
//!   forever.
//! - A doubtful rope is [`Unsure`](Seen::Unsure) even if part of it is covered. A writer that does
//!   not judge its fit (`fit` 0) is trusted.
//! - Messages are only bytes: every count and number is checked before use. Invalid ones are
//!   [`Unreadable`](Absent::Unreadable).
//! - A message has one covariance block per control point. Correlations are those of the fit,
//!   computed by this crate. They are approximate for some fits ([`Covariance::is_exact`]).
//! - The velocity variance, which messages lack, is taken from the steady state of the chain's
//!   filter.
//!
//! # Known limitations
//!
//! - The centerline joins points by straight lines. Between points it is off by up to h²/8r, for
//!   steps h on a bend of radius r.
//! - At most 24 readers per rig read descriptors.

mod centerline;
mod channel;
mod command_reader;
mod domain;
mod door;
mod error;
mod frame;
mod frame_reader;
mod holdings;
mod image_writer;
mod leftovers;
mod making;
mod memory;
mod owner;
mod patience;
mod quiet;
mod reader;
mod ready;
mod receiver;
mod rope;
mod roster;
mod seen;
mod shape;
mod slices;
mod survey;
mod tidy;
mod umask;
mod writer;

pub use centerline::Centerline;
pub use channel::*;
pub use command_reader::CommandReader;
pub use domain::{Domain, Rig};
pub use error::{WireError, WriteError};
pub use frame::{Frame, KeptFrame};
pub use frame_reader::FrameReader;
pub use holdings::holdings;
pub use image_writer::{DepthWriter, FrameWriter, MaskWriter, Stamp, Waiting};
#[doc(inline)]
pub use lariat_message::*;
pub use leftovers::{Leftover, leftovers, remove_leftovers, shared_by_others};
pub use owner::user_name;
pub use reader::Reader;
pub use receiver::{Message, Receiver, Woken, sleep_for_any};
pub use rope::{FARTHEST, Motion, NoPrediction, NoSpace, Prediction, Rope, Track};
pub use roster::{Announcement, Member, control_socket, members};
pub use seen::{Absent, Doubt, LastKnown, Seen};
pub use shape::{Covariance, Jacobian, Nearest, NoShape, Shape};
pub use slices::take_short_slices;
pub use survey::{ChannelEnds, ChannelState, ChannelWriter};
pub use writer::{Slot, Writer};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
