//! From the lines of one image to ropes that last: what the last image knew of them is held against what this one shows,
//! and each curve gets its rope's number, its direction, and the parts of it that are out of sight.

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
