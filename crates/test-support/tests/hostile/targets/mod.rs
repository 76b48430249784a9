//! Invariants that must hold for a message, whatever its bytes.
//!
//! Each target takes the bytes of a fuzzer. It changes some fields of a valid message accordingly
//! and sends it through shared memory, as a faulty writer would. Then all queries are made of the
//! readers, in Rust and in C, and of the receiving stages. They must answer or refuse, within
//! bounds, and continue. Another target does the same with clients of the page's server.
//!
//! `fuzz/` includes this folder and has a fuzz target for each target. The test next to this folder
//! runs the same targets on seeds (`seeds/`) and mutations of them.

mod centerlines;
mod command;
mod curve;
mod descriptors;
mod descriptors3;
mod edit;
mod frame;
mod front;
mod in_c;
mod input;
mod rig;
mod words;

pub use centerlines::centerlines;
pub use command::command;
pub use descriptors::descriptors;
pub use descriptors3::descriptors3;
pub use frame::frame;
pub use front::front;
pub use words::words;

/// Function that takes a fuzzer's bytes, and panics if an invariant does not hold.
pub type Target = fn(&[u8]);

/// All targets, by the names of their fuzz targets and of their seed folders.
pub const TARGETS: [(&str, Target); 7] = [
    ("descriptors", descriptors),
    ("descriptors3", descriptors3),
    ("centerlines", centerlines),
    ("frame", frame),
    ("command", command),
    ("words", words),
    ("front", front),
];
