//! `lariat set` and `lariat restart`: a running chain is told what to do.

use std::process::ExitCode;

use anyhow::Result;
use clap::Args;
use lariat_chain::control::{Asked, ask};
use lariat_chain::output::print;
use lariat_chain::settings::Flags;

/// The rig whose chain is told.
#[derive(Debug, Args)]
struct Rig {
    /// Name of the chain
    #[arg(long, value_name = "NAME", default_value = "default")]
    rig: lariat_wire::Rig,
}

/// What is asked of `lariat set`.
#[derive(Debug, Args)]
pub(crate) struct SetArgs {
    #[command(flatten)]
    rig: Rig,
    /// Settings and values, named as in lariat.toml; without any, prints the current ones
    #[arg(value_name = "SECTION.SETTING=VALUE")]
    changes: Vec<String>,
}

/// The parts of a chain that can be started again.
const PARTS: [&str; 5] = ["capture", "extract", "fit", "sink", "recorder"];

/// What is asked of `lariat restart`.
#[derive(Debug, Args)]
pub(crate) struct RestartArgs {
    #[command(flatten)]
    rig: Rig,
    /// Stage, or the recorder
    #[arg(value_parser = PARTS)]
    stage: String,
}

/// Has settings hold from now on, or says which do.
///
/// # Errors
/// No chain runs, or it refuses.
pub(crate) fn run(args: &SetArgs) -> Result<ExitCode> {
    // Told at once, whether a chain runs or not.
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

/// Has a stage restarted.
///
/// # Errors
/// No chain runs, or it has no such stage.
pub(crate) fn restart(args: &RestartArgs) -> Result<ExitCode> {
    print(&ask(
        args.rig.rig.as_str(),
        &Asked::Restart(args.stage.clone()),
    )?)?;
    Ok(ExitCode::SUCCESS)
}
