//! All tests of the public interface in one program, which is built and linked once.

#[path = "../jpeg/mod.rs"]
mod jpeg;

mod allocation;
mod depth_files;
mod field;
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
mod simulated;
mod video;
