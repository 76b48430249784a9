//! All tests of the crate's public face in one program, which is built and linked once; what counts allocations has one of its own.

#[path = "../made/mod.rs"]
mod made;

mod hostile_recordings;
mod reading;
