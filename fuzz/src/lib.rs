//! Converts a fuzzer's bytes to input for lariat, and checks the invariants after each. The
//! extractor gets a session of a few small frames, and the JPEG decoder a few camera frames. The
//! readers of videos and recordings get a file and a part of it.

mod frame;
#[path = "../../crates/test-support/tests/hostile/targets/mod.rs"]
pub mod hostile;
mod picture;
pub mod recording;
mod session;
mod shown;
pub mod video;

pub use frame::Frames;
pub use session::Session;
