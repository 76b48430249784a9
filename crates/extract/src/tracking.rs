//! Turns the lines of one image into persistent ropes by comparing them with the prior. Each curve
//! gets its rope's number and direction, and the rope's hidden parts.

mod complete;
mod matching;
pub(crate) mod noise;
pub(crate) mod refit;
pub(crate) mod tips;
pub(crate) mod track;
mod turn;
mod usual;
