//! `lariat view`: the page of a running chain as a browser gets it: files, moments, status, access
//! rights, and what it leaves alone. `tests/view/run` tests it with a real browser.

// Shared with the chain's tests; not all of it is needed here.
#[allow(dead_code)]
#[path = "../chain/rig.rs"]
mod rig;

#[path = "../record/annotations.rs"]
mod annotations;
mod page;
mod viewing;

mod admission;
mod beside;
mod film;
mod foxglove;
mod moments;
mod plane;
mod tuning;
