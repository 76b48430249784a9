//! Clusters the pixels of a mask. These are the methods that the paper (F. Chen, arXiv 2312.16502,
//! fig. 1) compares as a step toward a centerline.
//!
//! Each method takes the pixels of one rope and moves K centers. It does not order them. All start
//! the same way: from centers chosen among the pixels (k-means++), or from those of the last frame.
//!
//! The crate does no I/O, reads no clock and starts no threads. Once warm, it does not allocate.
//! Results have the same bits on every machine, whatever its vector registers.

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

/// Origin of the initial centers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// Centers are chosen among the pixels, by a generator with this seed.
    Seeded(u64),
    /// Centers are used as given, for example those of the last frame.
    Given,
}

/// Result of a clustering.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// Number of rounds over the pixels.
    pub rounds: u32,
    /// Final value of the objective, whose meaning and unit each method documents. It is minimized,
    /// except that a mixture maximizes it.
    pub objective: f64,
}
