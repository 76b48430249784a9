//! All tests of the public interface in one binary, which is built and linked once.

#[path = "../support/mod.rs"]
mod support;

mod allocation;
mod bounds;
mod holds;
mod loops;
mod refusals;
