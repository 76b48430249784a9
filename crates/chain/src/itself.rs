//! This program, started again: by the file that runs, and not by its path.
//!
//! An upgrade puts another file in the place of the one that runs, or removes it. The kernel keeps that file as long as it runs, and
//! `/proc/self/exe` leads to it: so all processes of a chain are of one version, whatever happens to the path meanwhile.

use std::os::unix::process::CommandExt;
use std::process::Command;

const EXECUTABLE: &str = "/proc/self/exe";

/// A command that runs this program, without arguments.
pub fn command() -> Command {
    let mut command = Command::new(EXECUTABLE);
    if let Some(name) = std::env::args_os().next() {
        command.arg0(name);
    }
    command
}

/// Whether the file that runs is no longer where it was started from.
pub fn is_replaced() -> bool {
    // The kernel adds a word to the path of a file that was removed or replaced.
    std::fs::read_link(EXECUTABLE).is_ok_and(|path| !path.exists())
}
