//! What hides a rope: it is found and taken out of the mask, and the rope's pieces are joined across it.

pub(crate) mod bridge;
pub(crate) mod ends;
pub(crate) mod occluder;
mod pieces;
pub(crate) mod way;
