//! Commands that run a separate program: `lariat top` (`crates/top`), `lariat ros2`
//! (`crates/ros2`), `lariat bridge` (`crates/bridge`), and the measurements (`bench/`).

use std::ffi::OsString;
use std::io::ErrorKind;
use std::os::unix::process::CommandExt;
use std::process::{Command, ExitCode};

use anyhow::{Context, Result, bail};
use clap::Args;

/// Arguments for another program
#[derive(Debug, Args)]
pub(crate) struct Words {
    /// Arguments for the program; its own --help lists them
    #[arg(
        value_name = "WORD",
        trailing_var_arg = true,
        allow_hyphen_values = true
    )]
    words: Vec<OsString>,
}

/// Runs `lariat <name>` as `lariat-<name>`.
///
/// # Errors
/// Returns an error if the program does not exist or cannot be started.
pub(crate) fn run(name: &str, args: &Words) -> Result<ExitCode> {
    let how = format!("`cargo install --locked --path crates/{name}` builds it");
    hand_over(&format!("lariat-{name}"), None, args, &how)
}

/// Runs a measurement as `lariat-bench <command>`.
///
/// # Errors
/// Returns an error if the program does not exist or cannot be started.
pub(crate) fn measure(command: &str, args: &Words) -> Result<ExitCode> {
    // The program is expected next to this one, in cargo's folder for the profile.
    let profile = if cfg!(debug_assertions) {
        ""
    } else {
        " --release"
    };
    let how = format!(
        "`cargo build{profile} --manifest-path bench/Cargo.toml` builds it, from a checkout of lariat"
    );
    hand_over("lariat-bench", Some(command), args, &how)
}

/// Replaces this process by a program from this one's folder or from the path. `how` tells how to
/// install it.
fn hand_over(file_name: &str, command: Option<&str>, args: &Words, how: &str) -> Result<ExitCode> {
    let beside = std::env::current_exe().ok();
    let beside = beside.map(|program| program.with_file_name(file_name));
    let program = beside.filter(|beside| beside.is_file());
    let program = program.map_or_else(|| file_name.into(), OsString::from);
    let error = Command::new(&program)
        .args(command)
        .args(&args.words)
        .exec();
    if error.kind() == ErrorKind::NotFound {
        bail!("{file_name} is neither next to this program nor on the path: {how}");
    }
    Err(error).with_context(|| format!("{} could not be started", program.display()))
}
