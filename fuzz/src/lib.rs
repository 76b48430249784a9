//! What a fuzzer's bytes mean to lariat, and what must hold after each: to the extractor a session of a few small frames, to
//! the decoder of a camera's JPEG frames a few of those, to the readers of videos and recordings a file and a part of it.

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
