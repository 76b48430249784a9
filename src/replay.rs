//! `lariat replay`: recomputes a recording's frames, to check that the results are the same or to
//! see what other settings change.

mod check;
mod compare;
mod difference;
mod distance;
mod stages;
mod table;

use crate::recording::RecordingArgs;
use anyhow::Result;
use clap::Args;
use lariat_chain::exit::wrong_use;
use lariat_chain::settings::Flags;
use std::process::ExitCode;

/// Recompute a recording, to check it or to try other settings
///
/// With --check: recompute everything from the recorded frames with the recorded settings. Each
/// centerline and each descriptor must be the recorded one, bit for bit on a machine of the same
/// kind. With --compare: compute the same frames with other settings, next to what was recorded.
#[derive(Debug, Args)]
pub(crate) struct ReplayArgs {
    #[command(flatten)]
    recording: RecordingArgs,
    /// Compare each result with the recorded one, and show the first difference
    #[arg(long, conflicts_with = "compare")]
    check: bool,
    /// Allow this distance between recomputed and recorded curves, in pixels, for recordings that
    /// cannot be recomputed exactly
    #[arg(long, value_name = "PX", requires = "check", value_parser = pixels)]
    within: Option<f64>,
    /// Run with other settings (--config, or any of the flags below) and show what changes
    #[arg(long)]
    compare: bool,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    flags: Flags,
}

fn pixels(text: &str) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|_| "a number of pixels".to_owned())?;
    if number.is_finite() && number >= 0.0 {
        Ok(number)
    } else {
        Err("a number of pixels, 0 or more".to_owned())
    }
}

/// Runs `lariat replay`.
///
/// # Errors
/// Returns an error if the recording cannot be read or does not allow the request.
pub(crate) fn run(args: ReplayArgs) -> Result<ExitCode> {
    match (args.check, args.compare) {
        (true, _) => check::run(&args),
        (_, true) => compare::run(&args),
        _ => wrong_use!(
            "say what to do with the recording: --check computes everything again and compares it with what was recorded, \
             --compare shows what other settings change (--config FILE, or flags such as --control-points 7). To see it run, \
             `lariat run --source {0}`; for its figures, `lariat info {0}`",
            args.recording.file.display()
        ),
    }
}

#[cfg(test)]
mod tests;
