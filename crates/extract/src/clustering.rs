//! With another method than the skeleton: the centers of a clustering (`crates/clustering`) in each piece of the mask, what joins them,
//! and the line through them.

mod clusterer;
mod nerve;
pub(crate) mod ordering;

pub(crate) use clusterer::{Center, Clusterer};
