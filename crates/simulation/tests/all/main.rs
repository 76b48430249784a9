//! All tests of the crate's public face in one program, which is built and linked once.

mod physics;
mod space;
mod targets;
