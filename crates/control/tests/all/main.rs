//! All tests of the crate's public face in one program, which is built and linked once; what counts allocations has one of its own.

#[path = "../support/mod.rs"]
mod support;

mod bounds;
mod holds;
mod loops;
mod refusals;
