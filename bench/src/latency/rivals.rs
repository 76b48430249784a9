//! The same four stages connected by other means: threads and channels, Unix sockets, and Python
//! scripts.

mod encoding;
mod scripts;
mod sockets;
mod steps;
mod threads;

pub(super) use scripts::{Script, measure as script};
pub(super) use sockets::{StageArgs, measure as sockets, run as socket_stage};
pub(super) use threads::{ThreadsArgs, measure as threads, run as run_threads};
