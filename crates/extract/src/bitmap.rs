//! Pictures of one bit per pixel, 64 to a word: neighborhoods, connected components, morphology,
//! and the distance of each set pixel to the nearest unset one.

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
