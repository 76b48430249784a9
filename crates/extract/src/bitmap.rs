//! Pictures of one bit a pixel, 64 to a word: their neighborhoods, connected pieces, morphology, and how far each set
//! pixel is from the nearest unset one.

pub(crate) mod bits;
pub(crate) mod components;
pub(crate) mod edge_distance;
pub(crate) mod morphology;
pub(crate) mod neighbors;
mod octagon;
pub(crate) mod pieces;
pub(crate) mod spread;
pub(crate) mod strips;
mod tiles;
