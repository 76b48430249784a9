//! Recordings, on the real binary: their contents, and the effects of faults on them and on the
//! chain.

// Shared with the chain's tests; not all of it is needed here.
#[allow(dead_code)]
#[path = "../chain/rig.rs"]
mod rig;

mod annotations;
mod contents;
mod faults;
mod recording;
mod rings;
mod traced;
