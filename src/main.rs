//! lariat: from a camera's images to the shape of the rope in them, through shared memory.

mod chain;
mod cli;
mod settings;
mod stages;
mod stop;

use std::process::ExitCode;

fn main() -> ExitCode {
    match cli::run() {
        Ok(code) => code,
        Err(error) => {
            eprintln!("lariat: {error:#}");
            ExitCode::FAILURE
        }
    }
}
