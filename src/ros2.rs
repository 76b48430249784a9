//! `lariat ros2`: hands over to `lariat-ros2` (`crates/ros2`), a program of its own, so that nobody else builds what it needs.

use std::ffi::OsString;
use std::io::ErrorKind;
use std::os::unix::process::CommandExt;
use std::process::{Command, ExitCode};

use anyhow::{Context, Result, bail};
use clap::Args;

const PROGRAM: &str = "lariat-ros2";

/// A rig in a ROS 2 graph
#[derive(Debug, Args)]
pub(crate) struct Ros2Args {
    /// What lariat-ros2 is told: `lariat-ros2 --help` lists it
    #[arg(
        value_name = "WORD",
        trailing_var_arg = true,
        allow_hyphen_values = true
    )]
    words: Vec<OsString>,
}

/// Runs `lariat ros2`: this process becomes the program that lies beside it, else the one on the path.
///
/// # Errors
/// There is none, or it cannot be started.
pub(crate) fn run(args: &Ros2Args) -> Result<ExitCode> {
    let beside = std::env::current_exe().ok();
    let beside = beside.map(|program| program.with_file_name(PROGRAM));
    let program = beside.filter(|beside| beside.is_file());
    let program = program.map_or_else(|| PROGRAM.into(), OsString::from);
    let error = Command::new(&program).args(&args.words).exec();
    if error.kind() == ErrorKind::NotFound {
        bail!(
            "{PROGRAM} is neither beside this program nor on the path: `cargo install --path crates/ros2` builds it"
        );
    }
    Err(error).with_context(|| format!("{} could not be started", program.display()))
}
