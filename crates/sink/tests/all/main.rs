//! All tests of the crate's public face in one program, which is built and linked once; what counts allocations has one of its own.

#[path = "../chain/mod.rs"]
mod chain;

mod accounting;
mod report;
mod truth;
