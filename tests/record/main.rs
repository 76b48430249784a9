//! Recordings, on the real binary: what is in them, and what becomes of them and of the chain when something goes wrong.

// Of the chain's own tests; not all of it is needed here.
#[allow(dead_code)]
#[path = "../chain/rig.rs"]
mod rig;

mod annotations;
mod contents;
mod faults;
mod recording;
mod rings;
mod traced;
