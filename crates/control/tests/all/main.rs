//! All tests of the crate's public face in one program, which is built and linked once.

#[path = "../support/mod.rs"]
mod support;

mod allocation;
mod bounds;
mod holds;
mod loops;
mod refusals;
