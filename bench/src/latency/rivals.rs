//! The same four stages, joined by others: threads and channels, Unix sockets, and scripts in Python.

mod encoding;
mod scripts;
mod sockets;
mod steps;
mod threads;

pub(super) use scripts::{Script, measure as script};
pub(super) use sockets::{StageArgs, measure as sockets, run as socket_stage};
pub(super) use threads::{ThreadsArgs, measure as threads, run as run_threads};
