//! All tests of the crate's public face in one program, which is built and linked once; what counts allocations has one of its own.

#[path = "../jpeg/mod.rs"]
mod jpeg;

mod follow;
mod kinds;
mod lent;
mod mjpeg;
mod mjpeg_rope;
mod pictures;
mod png;
mod range;
mod recorded;
mod rendered;
mod scenes;
mod simulated;
mod video;
