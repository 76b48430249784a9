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
//! restarted. [`Reader::wait`] sleeps until a frame comes; [`Reader::latest`] never sleeps, for a loop with a beat of its
//! own; [`Reader::before_poll`] is for a `poll` that waits for other things too. All three give a [`Frame`]: the newest
//! message, where it lies in shared memory, and how old its image is *now*.
//!
//! Of a frame a loop asks [the only rope](Frame::only_rope), or [the rope of a track](Frame::rope), and says how old the
//! image may be. The answer is a [`Seen`], and only its first case is the rope as it is. A covered, a doubtful, a lost or an old
//! shape has to be taken by its name, and a rope of a chain that was restarted is never taken for one of before.
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
//! opens a [`Domain`] once, then [`Receiver`]s and [`Writer`]s of the [`Channel`]s of a [`Rig`]. The messages themselves are
//! `lariat-message`'s; this crate is the only one that knows the transport (iceoryx2).
//!
//! # Readers
//!
//! `crates/wire/src/reader.rs` and what it lends: a frame, of it what is known of a rope (`frame`, `seen`), the rope and its
//! prediction (`rope`), its curve (`shape/`). `crates/c` puts C's names before it, with structs of the messages' own layout, held to
//! it field by field when it is compiled.
//!
//! - **The newest stays in the reader's hands**, in shared memory, until the next comes: a look with nothing new is some
//!   atomics and the clock. One message waits for such a reader, not eight: with overflow there is then none to be skipped. On
//!   a lossless channel eight wait for it as for others.
//! - **Age** is from the exposure to the moment of the question, each time again. An exposure later than the fit's own stamp counts
//!   as that stamp: no message stays young for ever.
//! - **Runs.** A new writer is a new run of the chain, and so is an `extracted` that goes back, or goes on by less than `fitted`
//!   (an extract that was restarted by hand). Tracks belong to a run.
//! - **Unsure** comes before covered and after lost: a curve that misses its points (`fit`), or a status `doubtful`, is not to be
//!   steered by, whatever is hidden. A writer that does not judge (`fit` 0) is trusted, so that writers of one's own are not shut out.
//!   A coarse curve passes where the loop says so when it opens the reader; a doubtful rope is taken by its name only.
//! - **The centerline** is read in place like all else, joined by straight lines: of 120 points on a bend of radius r with steps h they are
//!   off by h²/8r at most, far less than a width. `Shape::nearest` looks along the curve in even steps and finds the foot of the
//!   perpendicular by Newton's method in each valley (`shape/nearest`).
//! - **A message is only bytes**: numbers of control points, knots, weights, points and coordinates are checked before anything is
//!   evaluated (`shape/form`). What does not fit is `Unreadable`, not a rope.
//! - **Curves** are rows of the fit's `B` and its derivatives (`shape/rows`): one recurrence serves Bezier curves, B-splines and
//!   rational ones. `lariat-fit` evaluates by other recurrences; the tests hold the two together.
//! - **Covariance.** The message has a block for each control point; how two of them err together is `(BᵀB)⁻¹`, worked out from
//!   basis, knots and N by Givens's rotations and kept for the last two kinds of curve in each thread (`shape/inverse`,
//!   `shape/covariance`).
//! - **Prediction** adds to each variance what the chain's filter would: the velocity's variance and its covariance with the
//!   position, which the message lacks, follow from the position's in the filter's steady state (`shape/growth`). A test holds it
//!   to the filter itself at 30 to 1000 Hz.
//! - **Waiting** is that of all receivers, above. A descriptor for one's own `poll` comes with the rule that makes it safe:
//!   `before_poll` empties the bell, looks for messages after it, and says how long the sleep may be.
//! - A reader may go to another thread, whole; two threads use two. No panic crosses into C: each function catches it, and says
//!   `LARIAT_ERROR_FAULT`.
//! - **Python** (`python/`) is PyO3 over `wire`'s reader. The other way, ctypes over iceoryx2's own wheel, was measured beside it, in turns on
//!   one chain, and reads views of the slot itself (`python python/bench/readers.py`; p50 and p99 in µs): a new message 5.0 and 8.0 against 25 and 67,
//!   its control points as an array 3.1 and 5.2 against 8.2 and 14, a point of the curve 2.8 and 4.1 against 26 and 52, from sent to in
//!   hand 43 against 77 (p50); only a look at nothing new is slower, 1.8 against 0.6.
//!   Beyond that, ages, runs, the checks and the way of waiting would have to be written twice. The two do not go together: a reader is cut
//!   off from its channel when the wheel joins its domain in the same process.
//! - **A frame in Python is a copy** of what the message means, made once when it is looked at (4 KB a rope, 0.4 µs; all 44 KB would take 1.5), and its arrays are views
//!   of that. Views of the slot would need rules that Python cannot keep for its users: a reader is lent two messages, so that a
//!   list of arrays would end the reading; and the transport counts its samples without atomics, while Python drops an object in whichever thread
//!   is the last to hold it. So there is no limit to what is kept, and no thread that it belongs to.

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
