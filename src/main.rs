//! lariat: from a camera's images to the shape of the ropes in them, through shared memory.

#[macro_use]
extern crate lariat_chain;

mod beside;
mod calibrate;
mod cli;
mod config_command;
mod descriptor_json;
mod devices;
mod doctor;
mod export;
mod fit_lines;
mod info;
mod man;
mod message_json;
mod pick;
mod record;
mod recording;
mod replay;
mod service;
mod set;
mod snapshot;
mod topic;
mod trace;
mod version;
mod versioned;
mod view;

use lariat_chain::notify::Notify;
use lariat_chain::{exit, output};
use std::process::ExitCode;

fn main() -> ExitCode {
    // Stages are started under another file name (`itself`), which tools would show otherwise.
    let _ = rustix::thread::set_name(c"lariat");
    cli::run().unwrap_or_else(|error| {
        if output::Unread::is_cause_of(&error) {
            return ExitCode::FAILURE;
        }
        eprintln!("lariat: {error:#}");
        // `systemctl status` shows it.
        Notify::from_env().status(&format!("{error:#}"));
        exit::code(&error)
    })
}
