//! lariat: from a camera's images to the shape of the rope in them, through shared memory.

mod bench;
mod calibrate;
mod calibrated;
mod chain;
mod cli;
mod compare;
mod config_command;
mod descriptor_json;
mod devices;
mod doctor;
mod doubts;
mod export;
mod fit_lines;
mod info;
mod inputs;
mod paper;
mod pick;
mod picture;
mod plane_file;
mod record;
mod recording;
mod replay;
#[cfg(test)]
mod servo;
mod settings;
mod snapshot;
mod stages;
mod stop;
mod top;
mod topic;
mod trace;
mod whole_file;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::run().unwrap_or_else(|error| {
        eprintln!("lariat: {error:#}");
        ExitCode::FAILURE
    })
}
