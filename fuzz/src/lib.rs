//! What a fuzzer's bytes mean to lariat, and what must hold after each: to the extractor a session of a few small frames, to
//! the decoder of a camera's JPEG frames a few of those.

mod frame;
mod picture;
mod session;

pub use frame::Frames;
pub use session::Session;
