//! `lariat config`: write a settings file, read one critically, show what holds.

use crate::settings::{ChainArgs, FILE_NAME, Resolved, Settings, template};
use crate::whole_file::{self, Existing};
use anyhow::{Result, bail};
use clap::{Args, Subcommand};
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
    /// Write lariat.toml into this folder: every setting with its default and what it does
    Init {
        /// Replace the file that is there
        #[arg(long)]
        force: bool,
    },
    /// Say what is wrong with a settings file
    Check {
        /// The file
        #[arg(default_value = FILE_NAME)]
        file: PathBuf,
    },
    /// Print the settings that hold here, and where each came from
    Show {
        #[command(flatten)]
        chain: Box<ChainArgs>,
    },
}

/// Runs `lariat config`.
///
/// # Errors
/// A file that cannot be read or written, one that would be overwritten, and all that is wrong with settings.
pub(crate) fn run(args: ConfigArgs) -> Result<ExitCode> {
    match args.command {
        ConfigCommand::Init { force } => {
            let path = Path::new(FILE_NAME);
            if path.exists() && !force {
                bail!("there is a {FILE_NAME} already: `lariat config init --force` replaces it");
            }
            // Without --force not even a file that has appeared just now is replaced.
            let existing = if force {
                Existing::Replace
            } else {
                Existing::Keep
            };
            whole_file::write(path, template().as_bytes(), existing)?;
            println!("wrote {FILE_NAME}");
        }
        ConfigCommand::Check { file } => {
            Settings::of_file(&file)?;
            println!("{} is good", file.display());
        }
        ConfigCommand::Show { chain } => print!("{}", Resolved::new(&chain)?.show()),
    }
    Ok(ExitCode::SUCCESS)
}
