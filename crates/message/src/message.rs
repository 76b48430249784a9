//! The messages that travel between the processes.
//!
//! Each is `#[repr(C)]`, of a fixed size, without pointers and without padding, and made of plain integers and
//! floats only, so that *every* bit pattern is a valid value: a writer may fill a used slot of shared memory in
//! place and leave the rest of it as it was, and a reader in C or Python needs no more than the offsets.
//! `count` fields say how much of an array is meant; what lies behind is stale.
//!
//! The type names end in a version. Change a field, raise the version.

#[macro_use]
mod declare;

mod centerlines;
mod command;
mod descriptors;
mod descriptors3;
mod frame_header;
pub(crate) mod hidden;
mod trace;

pub use centerlines::{Centerlines, Crossing, Curve};
pub use command::{Command, MAX_GRIPPERS};
pub use descriptors::{CenterlinePoints, Descriptor, Descriptors};
pub use descriptors3::{Descriptor3, Descriptors3};
pub use frame_header::FrameHeader;
pub use trace::Trace;

/// Most curves in one frame.
pub const MAX_CURVES: usize = 24;
/// Most points of one centerline.
pub const MAX_POINTS: usize = 256;
/// Most control points of one descriptor.
pub const MAX_CONTROL_POINTS: usize = 32;
/// Most crossings reported for one frame.
pub const MAX_CROSSINGS: usize = 32;
