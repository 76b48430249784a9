//! lariat: from a camera's images to the shape of the rope in them, through shared memory.

/// Says a line on standard error. The standard library's own would end the process where nobody reads it, in the middle of its work.
macro_rules! eprintln {
    ($($text:tt)*) => {{
        let text = format!($($text)*);
        let line = format_args!("{}\n", $crate::layout::said(&text));
        let _ = std::io::Write::write_fmt(&mut std::io::stderr(), line);
    }};
}

/// Likewise, without the line's end.
macro_rules! eprint {
    ($($text:tt)*) => {{
        let _ = std::io::Write::write_fmt(&mut std::io::stderr(), format_args!($($text)*));
    }};
}

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
mod exit;
mod export;
mod fit_lines;
mod info;
mod inputs;
mod layout;
mod output;
mod paper;
mod pick;
mod picture;
mod pipeline;
mod plane_file;
mod record;
mod recording;
mod replay;
mod run_files;
mod servo;
mod settings;
mod snapshot;
mod stages;
mod stop;
mod top;
mod topic;
mod trace;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::run().unwrap_or_else(|error| {
        if output::Unread::is_cause_of(&error) {
            return ExitCode::FAILURE;
        }
        eprintln!("lariat: {error:#}");
        exit::code(&error)
    })
}
