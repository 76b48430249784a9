//! Centers in a mask: the ways that the paper (F. Chen, arXiv 2312.16502, fig. 1) tries on the way to a centerline.
//!
//! Each takes the pixels of one rope and moves K centers, of which it says nothing else: not their order. All are begun the
//! same way, from centers chosen among the pixels (k-means++) or from those of the last frame.
//!
//! Pure: no I/O, no clock, no threads; once warm nothing allocates. The same bits on every machine, whatever vectors it has.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod aligned;
mod blocks;
mod cells;
mod exponential;
mod extent;
mod fuzzy;
mod kmeans;
mod mixture;
mod nearest;
mod pixels;
#[cfg(test)]
mod references;
mod seeding;
mod som;
mod tiles;

pub use cells::{Cell, Cells};
pub use fuzzy::FuzzyMeans;
pub use kmeans::KMeans;
pub use mixture::Mixture;
pub use pixels::{Pixels, Run};
pub use seeding::seed_centers;
pub use som::Som;

/// Where the centers come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// Chosen among the pixels, by a generator that begins at this number.
    Seeded(u64),
    /// As they are handed in: those of the last frame, or of anyone else.
    Given,
}

/// How a clustering ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// Rounds over the pixels that it took.
    pub rounds: u32,
    /// What it makes small (of mixtures: large), at the end; each method says what that is and in which unit.
    pub objective: f64,
}
