//! The live page: a rig in the browser, and in Foxglove.
//!
//! ```text
//!  rig ──► hub: one reader, only while somebody looks ──► the newest moment, shared
//!                                                          │      each client is woken when it has asked for the next
//!     browser ◄── client's thread ◄── its worker: JPEG ◄───┘      (`live`), or sends what is subscribed to (`foxglove`)
//! ```
//!
//! **It costs the chain little.** The hub's receivers are not woken: it looks by itself, once a frame, some milliseconds after the last
//! stage is done (`pace`), and copies an image out of shared memory only when a client has acknowledged the one before. No
//! client: no reader, no thread that wakes. Pictures are encoded at low priority (`worker`), once for all that want the same size; short
//! messages are sent at normal priority.
//!
//! **It is safe.** Without `--listen` it answers this machine's processes of its own user alone; with it whoever has the token that stands in the address. What a
//! browser sends from another site's page is refused by `Host` and `Origin` (`guard`), so is all that is too large, too slow or
//! too much (`server` has the bounds). A client has a thread, and holds up nobody but itself.
//!
//! **The page** lies in `page/`, as a browser loads it, and is part of the program (`page`). What it and the server say to each
//! other stands at the head of `live`.
//!
//! What `lariat top` shows is gathered here too ([`Gatherer`], [`View`]).

mod calibrating;
mod dropped;
mod film;
mod foxglove;
mod gather;
mod guard;
mod http;
mod hub;
mod live;
mod moment;
mod notices;
mod pace;
mod page;
mod peer;
mod picture;
mod processes;
mod recent;
mod server;
mod session;
mod status;
mod tuning;
mod view;
mod worker;

pub use gather::{Gatherer, clock_bound_us};
pub use server::{Options, Server, Shown, serve};
pub use view::{InSpace, Losses, Rope, Shape, StageRow, StepRow, View};
