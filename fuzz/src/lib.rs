//! What a fuzzer's bytes mean to the extractor: a session of a few small frames, and what must hold after each.

mod picture;
mod session;

pub use session::Session;
