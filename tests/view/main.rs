//! `lariat view`: the page of a chain that runs, as a browser gets it: files, moments, status; who is refused; and what it leaves
//! alone. A browser itself looks at it in `tests/view/run`.

// Of the chain's own tests; not all of it is needed here.
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
