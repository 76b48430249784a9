//! The third step: turns the skeleton into strands. A strand is one rope's edges in order, through
//! its crossings and overlaps.

mod arm;
mod edges;
pub(crate) mod necks;
pub(crate) mod overlaps;
pub(crate) mod pairing;
pub(crate) mod strands;
mod unroll;
pub(crate) mod walk;
pub(crate) mod zones;

pub(crate) use edges::Graph;
