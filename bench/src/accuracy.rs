//! How close the extractor's curves are to the truth: on drawn ropes of every class (`rendered`).

mod rendered;

use std::path::PathBuf;

use anyhow::{Result, bail};

/// What to measure, and what to write beside the table.
#[derive(clap::Args)]
pub(crate) struct Args {
    #[command(flatten)]
    rendered: rendered::Args,
    /// Also writes one line for each image, with all its figures
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Also draws what was found over each picture
    #[arg(long, value_name = "DIR")]
    overlay: Option<PathBuf>,
}

/// Measures what was asked for and prints it.
///
/// # Errors
/// The results cannot be written: a sentence that names the file.
pub(crate) fn run(args: &Args) -> Result<()> {
    if !args.rendered.are_asked_for() {
        bail!("nothing to measure was named: give --rendered");
    }
    rendered::run(&args.rendered, args.csv.as_deref(), args.overlay.as_deref())
}
