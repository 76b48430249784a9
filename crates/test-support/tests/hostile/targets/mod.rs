//! What must hold of a message, whatever its bytes.
//!
//! Each target takes what a fuzzer made up. Of that it makes a message, a sound one with some of its fields changed, and sends it through
//! shared memory, as a writer that has lost its wits would. The readers, in Rust and in C, and the stages that receive it are asked
//! all that can be asked: they answer or refuse, within bounds, and go on. And of those who connect to the page's server.
//!
//! `fuzz/` includes this folder and has a fuzz target for each. The test next to it drives the same over seeds (`seeds/`) and changes of them.

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

/// What takes a fuzzer's bytes, and panics where something does not hold.
pub type Target = fn(&[u8]);

/// All of them, by the names of their fuzz targets and of the folders of their seeds.
pub const TARGETS: [(&str, Target); 7] = [
    ("descriptors", descriptors),
    ("descriptors3", descriptors3),
    ("centerlines", centerlines),
    ("frame", frame),
    ("command", command),
    ("words", words),
    ("front", front),
];
