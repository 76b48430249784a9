//! The command line: what can be asked of lariat, and who answers.

use std::ffi::OsString;
use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::settings::{ChainArgs, Settings};
use crate::{chain, stages};

/// Sees ropes, cables and hoses through a camera, and gives a control loop their shape through shared memory.
///
/// Without a command: shows the whole chain live on a rendered rope, for 10 seconds.
#[derive(Parser)]
#[command(name = "lariat", version)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Subcommand)]
enum Command {
    /// Runs the whole chain: capture, extract, fit and sink, each in a process of its own.
    Run(ChainArgs),
    /// Runs the first stage alone: sends a source's frames.
    Capture(ChainArgs),
    /// Runs the second stage alone: frames in, centerlines out.
    Extract(ChainArgs),
    /// Runs the third stage alone: centerlines in, descriptors out.
    Fit(ChainArgs),
    /// Runs the last stage alone: counts and times what arrives, and reports at the end.
    Sink(ChainArgs),
}

/// How long the chain runs when nothing was asked of it.
const SHOW: &str = "--duration=10";

/// Does what the command line asks.
pub fn run() -> anyhow::Result<ExitCode> {
    let cli = Cli::parse();
    log_to_stderr();
    let done = |()| ExitCode::SUCCESS;
    match cli.command {
        None => chain::run(&[SHOW.into()]),
        Some(Command::Run(arguments)) => {
            // Checked here, so that a mistake is told once and not by four processes.
            Settings::resolve(&arguments)?;
            chain::run(&after_the_command())
        }
        Some(Command::Capture(arguments)) => {
            stages::capture::run(&Settings::resolve(&arguments)?).map(done)
        }
        Some(Command::Extract(arguments)) => {
            stages::extract::run(&Settings::resolve(&arguments)?).map(done)
        }
        Some(Command::Fit(arguments)) => {
            stages::fit::run(&Settings::resolve(&arguments)?).map(done)
        }
        Some(Command::Sink(arguments)) => {
            stages::sink::run(&Settings::resolve(&arguments)?).map(done)
        }
    }
}

/// The stages understand the same options as `lariat run`, and are given them as they were typed.
fn after_the_command() -> Vec<OsString> {
    std::env::args_os().skip(2).collect()
}

fn log_to_stderr() {
    tracing_subscriber::fmt()
        .with_writer(std::io::stderr)
        .without_time()
        .with_target(false)
        .with_max_level(tracing::Level::INFO)
        .init();
}
