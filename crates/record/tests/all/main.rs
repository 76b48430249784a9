//! All tests of the public interface in one binary, which is built and linked once.

#[path = "../made/mod.rs"]
mod made;

mod allocation;
mod hostile_recordings;
mod others;
mod reading;
