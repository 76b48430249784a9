//! The shape of ropes in a control loop: all that one links of lariat.
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
//! [`Reader::open`] names the rig: one camera and its chain of processes (`lariat run`). The chain may start later, and be
//! started anew. [`Reader::wait`] sleeps until a frame comes; [`Reader::latest`] never sleeps, for a loop with a beat of its
//! own; [`Reader::before_poll`] is for a `poll` that waits for other things too. All three give a [`Frame`]: the newest
//! message, where it lies in shared memory, and how old its image is *now*.
//!
//! Of a frame a loop asks [the only rope](Frame::only_rope), or [the rope of a track](Frame::rope), and says how old the
//! image may be. The answer is a [`Seen`], and only its first case is the rope as it is. A covered, a doubtful, a lost or an old
//! shape has to be taken by its name, and a rope of a chain that was started anew is never taken for one of before.
//!
//! A [`Rope`] has its [centerline](Rope::centerline), the points where it was seen, with widths; its [control
//! points](Rope::control_points), its [age](Rope::age), a [prediction](Rope::predict) of where
//! it will be when the robot moves, and its [`Shape`]: the curve `f(ρ)` with points, directions, bends,
//! [`Jacobian`](Shape::jacobian_at) and [`Covariance`]. Coordinates are pixels of the image, x to the right and y down, or
//! the [`Unit`] that the chain was asked for.
//!
//! | a control loop has | |
//! |---|---|
//! | [`Reader`], [`Frame`], [`Seen`], [`Doubt`], [`LastKnown`], [`Absent`] | what is known now, and how sure it is that this is the rope |
//! | [`Rope`], [`Track`], [`Centerline`], [`Shape`], [`Covariance`], [`Prediction`], [`Motion`] | what a control law asks of it |
//! | [`Descriptors`], [`Descriptor`], [`Trace`] | the message itself, as it lies in shared memory |
//! | [`WireError`], [`NoShape`], [`NoPrediction`] | what can go wrong, in sentences that say what to do |
//!
//! Reading disturbs nobody: a reader that is slow, stopped or killed holds up neither the chain nor other readers. An open
//! reader allocates nothing, and [`latest`](Reader::latest) makes no system call, but for the one look that takes up the
//! channel of a chain that has just started.
//!
//! # Frames and masks of one's own
//!
//! [`FrameWriter`] is for a camera that lariat does not know (`lariat run --source external`), [`FrameReader`] and [`MaskWriter`]
//! for a network that finds the ropes (`mask = "external"`).
//!
//! # Below that
//!
//! The rest is the contract between lariat's own processes, for who writes a stage, or looks in at other channels: a process
//! opens a [`Domain`] once, then [`Receiver`]s and [`Writer`]s of the [`Channel`]s of a [`Rig`]. This crate is the only one
//! that knows the transport (iceoryx2).

mod centerline;
mod channel;
mod clock;
mod codes;
mod command;
mod command_reader;
mod domain;
mod error;
mod frame;
mod frame_reader;
mod holdings;
mod image_writer;
mod leftovers;
mod making;
mod memory;
mod message;
mod owner;
mod patience;
mod reader;
mod ready;
mod receiver;
mod relay;
mod rope;
mod roster;
mod seen;
mod shape;
mod survey;
mod writer;

pub use centerline::Centerline;
pub use channel::{
    CENTERLINES, COMMANDS, Channel, DESCRIPTORS, Delivery, FRAMES, MASKS, Payload, TRUTH,
};
pub use clock::now_ns;
pub use codes::{Basis, FitQuality, PixelFormat, SourceKind, Status, Unit};
pub use command::{Command, MAX_GRIPPERS};
pub use command_reader::CommandReader;
pub use domain::{Domain, Rig};
pub use error::{WireError, WriteError};
pub use frame::{Frame, KeptFrame};
pub use frame_reader::FrameReader;
pub use holdings::holdings;
pub use image_writer::{FrameWriter, MaskWriter, Stamp, Waiting};
pub use leftovers::{Leftover, leftovers, remove_leftovers, shared_by_others};
pub use message::*;
pub use owner::user_name;
pub use reader::Reader;
pub use receiver::{Message, Receiver, Woken, sleep_for_any};
pub use relay::{RelayMessage, RelayReceiver, RelaySender};
pub use rope::{FARTHEST, Motion, NoPrediction, Prediction, Rope, Track};
pub use roster::{Announcement, Member, members};
pub use seen::{Absent, Doubt, LastKnown, Seen};
pub use shape::{Covariance, Jacobian, Nearest, NoShape, Shape};
pub use survey::{ChannelEnds, ChannelState, ChannelWriter};
pub use writer::{Slot, Writer};
