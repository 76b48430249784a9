//! Methods other than the skeleton. A clustering (`crates/clustering`) puts centers in each piece
//! of the mask. They are then joined, and a line is laid through them.

mod clusterer;
mod nerve;
pub(crate) mod ordering;

pub(crate) use clusterer::{Center, Clusterer};
