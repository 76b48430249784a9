//! From the lines of one image to persistent ropes. Compares the prior with what this image shows.
//! Each curve gets its rope's number and direction, and the rope's hidden parts.

mod complete;
mod matching;
pub(crate) mod noise;
pub(crate) mod part;
pub(crate) mod plausible;
pub(crate) mod refit;
pub(crate) mod tips;
pub(crate) mod track;
mod turn;
mod usual;
