//! `lariat set` and `lariat restart`: a running chain is told what to do.

use std::process::ExitCode;

use anyhow::Result;
use clap::Args;
use lariat_chain::control::{Asked, ask};
use lariat_chain::output::print;

/// The rig whose chain is told.
#[derive(Debug, Args)]
struct Rig {
    /// Name of the chain
    #[arg(long, value_name = "NAME", default_value = "default")]
    rig: String,
}

/// What is asked of `lariat set`.
#[derive(Debug, Args)]
pub(crate) struct SetArgs {
    #[command(flatten)]
    rig: Rig,
    /// Settings as lariat.toml names them, and their values; none: prints what holds
    #[arg(value_name = "SECTION.SETTING=VALUE")]
    changes: Vec<String>,
}

/// What is asked of `lariat restart`.
#[derive(Debug, Args)]
pub(crate) struct RestartArgs {
    #[command(flatten)]
    rig: Rig,
    /// capture, extract, fit, sink or recorder
    stage: String,
}

/// Has settings hold from now on, or says which do.
///
/// # Errors
/// No chain runs, or it refuses.
pub(crate) fn run(args: &SetArgs) -> Result<ExitCode> {
    let asked = match args.changes.is_empty() {
        true => Asked::Settings,
        false => Asked::Set(args.changes.clone()),
    };
    print(&ask(&args.rig.rig, &asked)?)?;
    Ok(ExitCode::SUCCESS)
}

/// Has a stage started anew.
///
/// # Errors
/// No chain runs, or it has no such stage.
pub(crate) fn restart(args: &RestartArgs) -> Result<ExitCode> {
    print(&ask(&args.rig.rig, &Asked::Restart(args.stage.clone()))?)?;
    Ok(ExitCode::SUCCESS)
}
