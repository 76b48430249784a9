//! Recordings, on the real binary: what is in them, and what becomes of them and of the chain when something goes wrong.

pub(crate) mod annotations;
mod contents;
mod faults;
mod recording;
mod rings;
mod traced;
