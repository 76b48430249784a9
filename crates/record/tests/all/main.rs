//! All tests of the crate's public face in one program, which is built and linked once.

#[path = "../made/mod.rs"]
mod made;

mod allocation;
mod hostile_recordings;
mod others;
mod reading;
