//! How close the extractor's curves are to the truth.
//!
//! Photographs are read (`dataset`, `photo`, `labels`), extracted and timed (`measure`), drawn as masks (`spline`,
//! `strip`, `drawing`), compared with the labels (`assignment`, `overlap`, `coverage`, `causes`), and told (`report`,
//! `csv`, `overlay`).

mod assignment;
mod causes;
mod coverage;
mod csv;
mod dataset;
mod drawing;
mod labels;
mod measure;
mod overlap;
mod overlay;
mod paint;
mod photo;
mod report;
mod spline;
mod strip;
mod whole_file;

use std::path::PathBuf;

use anyhow::Result;

use measure::Bench;

/// What to measure, and what to write beside the table.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Photographs with ground-truth labels: a folder of sets, each with `images/` (PNG, JPEG) and `labels/` (8-bit grey
    /// PNG of the same name: 0 is the table, 1… the ropes)
    #[arg(long, value_name = "DIR")]
    dataset: PathBuf,
    /// Also writes one line for each image, with all its figures
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Also draws what was found over each photograph, and a contact sheet for each set: DIR/SET/IMAGE.png
    #[arg(long, value_name = "DIR")]
    overlay: Option<PathBuf>,
}

/// Measures what was asked for and prints it.
///
/// # Errors
/// The data cannot be read or the results cannot be written: a sentence that names the file.
pub(crate) fn run(args: &Args) -> Result<()> {
    let sets = dataset::find(&args.dataset)?;
    let mut bench = Bench::new()?;
    let mut measured = Vec::new();
    for set in &sets {
        let images: Result<_> = set.pairs.iter().map(|pair| bench.measure(pair)).collect();
        measured.push((set.name.as_str(), images?));
    }
    // Only now, so that a broken picture leaves nothing half-written behind.
    if let Some(path) = &args.csv {
        whole_file::write(path, csv::table(&measured).as_bytes())?;
    }
    if let Some(folder) = &args.overlay {
        for (set, (_, images)) in sets.iter().zip(&measured) {
            overlay::write_set(&folder.join(&set.name), &set.pairs, images)?;
        }
    }
    print!("{}", report::table(&measured));
    Ok(())
}
