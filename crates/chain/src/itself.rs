//! Starts this program again, from the running executable rather than from its path.
//!
//! An upgrade replaces or removes the file at that path. The kernel keeps the running file, and
//! `/proc/self/exe` refers to it. Therefore all processes of a chain have the same version.

use std::os::unix::process::CommandExt;
use std::process::Command;

const EXECUTABLE: &str = "/proc/self/exe";

/// Creates a command that runs this program, without arguments.
pub fn command() -> Command {
    let mut command = Command::new(EXECUTABLE);
    if let Some(name) = std::env::args_os().next() {
        command.arg0(name);
    }
    command
}

/// Returns true if the running executable is no longer at its path.
pub fn is_replaced() -> bool {
    // The kernel appends " (deleted)" to the path of a file that was removed or replaced.
    std::fs::read_link(EXECUTABLE).is_ok_and(|path| !path.exists())
}
