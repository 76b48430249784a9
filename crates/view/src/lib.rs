//! The live page: a rig in the browser, and in Foxglove.
//!
//! ```text
//!  rig ──► hub: one reader, only while somebody looks ──► the newest moment, shared
//!                                                          │      each client is woken when it has asked for the next
//!     browser ◄── client's thread ◄── its worker: JPEG ◄───┘      (`live`), or sends what is subscribed to (`foxglove`)
//! ```
//!
//! **It costs the chain little.** Messages do not wake the hub's receivers. The hub polls once per
//! frame, some milliseconds after the last stage is done (`pace`). It copies an image out of shared
//! memory only when a client has acknowledged the one before. Without a client, it has no reader,
//! and its thread sleeps. Pictures are encoded at low priority (`worker`), once for all clients
//! that want the same size. Short messages are sent at normal priority.
//!
//! **It is safe.** Without `--listen`, the server answers only processes of its own user on this
//! machine. With `--listen`, it answers whoever has the token in the address. The headers `Host`
//! and `Origin` reveal requests that a browser sends from another site's page, which are refused
//! (`guard`). The server also refuses what is too large, too slow or too much (`server` has the
//! limits). Each client has its own thread, and delays only itself.
//!
//! **The page** is in `page/`, in the form that a browser loads. The program contains these files
//! (`page`). The module documentation of `live` describes the protocol between page and server.
//!
//! This crate also gathers the figures for `lariat top` ([`Gatherer`], [`View`]).

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
