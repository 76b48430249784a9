//! `lariat config`: writes a settings file, checks one, and shows the current settings.

use anyhow::Result;
use clap::{Args, Subcommand};
use lariat_chain::output::{Existing, Output, print};
use lariat_chain::settings::{FILE_NAME, Flags, Resolved, Settings, template};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Write, check and show lariat.toml
#[derive(Debug, Args)]
pub(crate) struct ConfigArgs {
    #[command(subcommand)]
    command: ConfigCommand,
}

#[derive(Debug, Subcommand)]
enum ConfigCommand {
    /// Write lariat.toml into this folder: every setting with its default and a description
    Init {
        /// Overwrite an existing file
        #[arg(long)]
        force: bool,
    },
    /// Check a settings file
    Check {
        /// The file
        #[arg(default_value = FILE_NAME)]
        file: PathBuf,
    },
    /// Print the current settings and the origin of each
    Show {
        #[command(flatten)]
        flags: Flags,
    },
}

/// Runs `lariat config`.
///
/// # Errors
/// Returns an error if a file cannot be read or written, if it would be overwritten, or if settings
/// are invalid.
pub(crate) fn run(args: ConfigArgs) -> Result<ExitCode> {
    match args.command {
        ConfigCommand::Init { force } => {
            let file = Output::new(Path::new(FILE_NAME), Existing::forced(force), [])?;
            file.write(template().as_bytes())?;
            print(&format!("wrote {FILE_NAME}\n"))?;
        }
        ConfigCommand::Check { file } => {
            Settings::of_file(&file)?;
            print(&format!("{} is good\n", file.display()))?;
        }
        ConfigCommand::Show { flags } => print(&Resolved::new(&flags)?.show())?,
    }
    Ok(ExitCode::SUCCESS)
}
