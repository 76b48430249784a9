//! All tests of the crate's public face in one program, which is built and linked once.

mod scenes;
mod space;
