//! Code shared by the tests of several crates.
//!
//! - [`allocations`], [`bytes`], [`held_bytes`], [`watch`]: counters of an allocator that every
//!   program linking this crate uses.
//! - [`documents`]: the commands in README.md, in `docs/` and in the other documents.
//!
//! The test `hostile` of this crate sends messages with arbitrary bytes to all receivers. `fuzz/`
//! has a fuzz target for each of its targets (`tests/hostile/targets`).

mod counting;
pub mod documents;

pub use counting::{allocations, bytes, held_bytes, watch};
