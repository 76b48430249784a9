//! `lariat man`: a manual page for each command, generated from the command line's definition, for
//! packages.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Result;
use clap::{Args, Command};
use clap_mangen::Man;
use lariat_chain::output::{Existing, OutputFolder, print};

/// Write the manual pages of all commands
#[derive(Debug, Args)]
pub(crate) struct ManArgs {
    /// Folder for the pages
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Overwrite existing files
    #[arg(long)]
    force: bool,
}

/// Runs `lariat man` for this command line.
///
/// # Errors
/// Returns an error if the folder is not writable or already has such pages.
pub(crate) fn run(args: &ManArgs, command: Command) -> Result<ExitCode> {
    // The long version is specific to this machine, so the pages leave it out.
    let mut command = command
        .disable_help_subcommand(true)
        .long_version(None::<&str>);
    command.build();
    let mut pages = Vec::new();
    add(command, &mut pages)?;
    let names = pages.iter().map(|(name, _)| name.as_str());
    let folder = OutputFolder::new(&args.folder, Existing::forced(args.force), names)?;
    for (name, page) in &pages {
        folder.write(name, page)?;
    }
    print(&format!("wrote {} pages\n", pages.len()))?;
    Ok(ExitCode::SUCCESS)
}

/// Adds the pages of a command and of all its visible subcommands.
fn add(command: Command, pages: &mut Vec<(String, Vec<u8>)>) -> Result<()> {
    let below = command
        .get_subcommands()
        .filter(|below| !below.is_hide_set());
    for below in below.cloned() {
        add(below, pages)?;
    }
    let source = concat!("lariat ", env!("CARGO_PKG_VERSION"));
    let man = Man::new(command).source(source);
    let mut page = Vec::new();
    man.render(&mut page)?;
    pages.push((man.get_filename(), page));
    Ok(())
}
