//! `lariat view`: the page of a chain that runs, as a browser gets it: files, moments, status; who is refused; and what it leaves
//! alone. A browser itself looks at it in `tests/view/run`.

mod admission;
mod beside;
mod film;
mod foxglove;
mod moments;
mod page;
mod plane;
mod tuning;
mod viewing;
