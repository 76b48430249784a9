//! `lariat ros2` and `lariat bridge`: each hands over to a program of its own (`crates/ros2`, `crates/bridge`).

use std::ffi::OsString;
use std::io::ErrorKind;
use std::os::unix::process::CommandExt;
use std::process::{Command, ExitCode};

use anyhow::{Context, Result, bail};
use clap::Args;

/// What another program is told
#[derive(Debug, Args)]
pub(crate) struct Words {
    /// What the program is told: its own --help lists it
    #[arg(
        value_name = "WORD",
        trailing_var_arg = true,
        allow_hyphen_values = true
    )]
    words: Vec<OsString>,
}

/// Runs `lariat <name>`: this process becomes `lariat-<name>`, which lies beside it, else the one on the path.
///
/// # Errors
/// There is none, or it cannot be started.
pub(crate) fn run(name: &str, args: &Words) -> Result<ExitCode> {
    let file_name = format!("lariat-{name}");
    let beside = std::env::current_exe().ok();
    let beside = beside.map(|program| program.with_file_name(&file_name));
    let program = beside.filter(|beside| beside.is_file());
    let program = program.map_or_else(|| file_name.clone().into(), OsString::from);
    let error = Command::new(&program).args(&args.words).exec();
    if error.kind() == ErrorKind::NotFound {
        bail!(
            "{file_name} is neither beside this program nor on the path: `cargo install --locked --path crates/{name}` builds it"
        );
    }
    Err(error).with_context(|| format!("{} could not be started", program.display()))
}
