//! lariat
mod config_command;
mod descriptor_json;
mod fit_lines;
mod settings;
mod trace;
mod whole_file;

use clap::{Parser, Subcommand};
use std::process::ExitCode;

#[derive(Parser)]
#[command(name = "lariat")]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// The shapes of the ropes in pictures
    Trace(trace::TraceArgs),
    /// Descriptors of centerlines, line by line
    Fit(fit_lines::FitArgs),
    /// Write, check and show lariat.toml
    Config(config_command::ConfigArgs),
}

fn main() -> ExitCode {
    let result = match Cli::parse().command {
        Command::Trace(args) => trace::run(args),
        Command::Fit(args) if fit_lines::is_line_filter(&args) => fit_lines::run(args),
        Command::Fit(_) => Err(anyhow::anyhow!("the fit stage is not part of this build")),
        Command::Config(args) => config_command::run(args),
    };
    result.unwrap_or_else(|error| {
        eprintln!("lariat: {error:#}");
        ExitCode::FAILURE
    })
}
