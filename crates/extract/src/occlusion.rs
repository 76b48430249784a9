//! Occluders: finds them, removes them from the mask, and joins the fragments of ropes across them.

pub(crate) mod bridge;
pub(crate) mod ends;
pub(crate) mod occluder;
mod pieces;
pub(crate) mod way;
