//! Code that the tests of several crates share.
//!
//! - [`allocations`], [`bytes`], [`held_bytes`], [`watch`]: the counters of an allocator, which every program that links this crate has.
//! - [`documents`]: the commands in README.md, in `docs/` and in the other documents.
//!
//! This crate's own test `hostile` sends messages with arbitrary bytes to everything that receives one. `fuzz/` has a fuzz
//! target for each of its targets (`tests/hostile/targets`).

mod counting;
pub mod documents;

pub use counting::{allocations, bytes, held_bytes, watch};
