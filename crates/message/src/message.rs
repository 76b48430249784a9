//! The messages that travel between the processes.
//!
//! Each is `#[repr(C)]`, of fixed size, without pointers or padding, and made only of plain
//! integers and floats. *Every* bit pattern is therefore a valid value. A writer may refill a used
//! slot of shared memory in place and leave the rest as it was. A reader in C or Python needs only
//! the offsets. `count` fields give the number of valid entries of an array; the entries after them
//! are stale.
//!
//! The type names end in a version. Raise the version whenever a field changes.

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

/// Maximum number of curves in one frame.
pub const MAX_CURVES: usize = 24;
/// Maximum number of points of one centerline.
pub const MAX_POINTS: usize = 256;
/// Maximum number of control points of one descriptor.
pub const MAX_CONTROL_POINTS: usize = 32;
/// Maximum number of crossings reported for one frame.
pub const MAX_CROSSINGS: usize = 32;
