//! The third step: turns the skeleton into strands. A strand is one rope's edges in order, through
//! its crossings and overlaps.

mod arm;
pub(crate) mod assignment;
pub(crate) mod bending;
mod edges;
mod forest;
pub(crate) mod shared;
pub(crate) mod strands;
pub(crate) mod zones;

pub(crate) use edges::Graph;
