//! `lariat set` and `lariat restart`: requests to a running chain.

use std::process::ExitCode;

use anyhow::Result;
use clap::Args;
use lariat_chain::control::{Asked, ask};
use lariat_chain::output::print;
use lariat_chain::settings::Flags;

/// Rig whose chain gets the request.
#[derive(Debug, Args)]
struct Rig {
    /// Name of the chain
    #[arg(long, value_name = "NAME", default_value = "default")]
    rig: lariat_wire::Rig,
}

/// Arguments of `lariat set`.
#[derive(Debug, Args)]
pub(crate) struct SetArgs {
    #[command(flatten)]
    rig: Rig,
    /// Settings and values, named as in lariat.toml; without any, prints the current ones
    #[arg(value_name = "SECTION.SETTING=VALUE")]
    changes: Vec<String>,
}

/// Parts of a chain that can be restarted.
const PARTS: [&str; 5] = ["capture", "extract", "fit", "sink", "recorder"];

/// Arguments of `lariat restart`.
#[derive(Debug, Args)]
pub(crate) struct RestartArgs {
    #[command(flatten)]
    rig: Rig,
    /// Stage, or the recorder
    #[arg(value_parser = PARTS)]
    stage: String,
}

/// Changes settings of a running chain, or prints the current ones.
///
/// # Errors
/// Returns an error if no chain runs, or if it refuses.
pub(crate) fn run(args: &SetArgs) -> Result<ExitCode> {
    // Mistakes are reported at once, whether a chain runs or not.
    for change in &args.changes {
        Flags::default().with_change(change)?;
    }
    let asked = match args.changes.is_empty() {
        true => Asked::Settings,
        false => Asked::Set(args.changes.clone()),
    };
    print(&ask(args.rig.rig.as_str(), &asked)?)?;
    Ok(ExitCode::SUCCESS)
}

/// Restarts a stage of a running chain.
///
/// # Errors
/// Returns an error if no chain runs, or if it has no such stage.
pub(crate) fn restart(args: &RestartArgs) -> Result<ExitCode> {
    print(&ask(
        args.rig.rig.as_str(),
        &Asked::Restart(args.stage.clone()),
    )?)?;
    Ok(ExitCode::SUCCESS)
}
