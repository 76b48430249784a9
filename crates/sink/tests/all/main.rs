//! All tests of the crate's public interface in one program, which is built and linked once.

#[path = "../chain/mod.rs"]
mod chain;

mod accounting;
mod allocation;
mod report;
mod saved;
mod truth;
