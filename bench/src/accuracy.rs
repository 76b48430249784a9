//! Accuracy of the extractor's curves.
//!
//! On drawn ropes, curves are compared point by point with the known centerlines (`rendered`). On
//! photographs, they are compared with the labels:
//!
//! - `dataset`, `photo` and `labels` read the photographs.
//! - `measure` extracts and times them.
//! - `spline`, `strip` and `drawing` draw the curves as masks.
//! - `assignment`, `overlap`, `coverage`, `whole`, `causes` and `crossings` compare the masks with
//!   the labels.
//! - `curve` compares the points with the curve fitted to them.
//! - `report`, `csv` and `overlay` output the results.

mod assignment;
mod causes;
mod coverage;
mod crossings;
mod csv;
mod curve;
mod dataset;
mod drawing;
pub(crate) mod labelled;
mod labels;
mod measure;
mod overlap;
mod overlay;
mod photo;
mod rendered;
mod report;
pub(crate) mod spline;
mod strip;
mod whole;
mod whole_file;

use std::path::{Path, PathBuf};

use anyhow::Result;
use lariat_extract::Method;

use crate::mask::Mask;
use curve::Curves;
use measure::Bench;

/// Measurements to make, and files to write in addition to the table.
#[derive(clap::Args)]
#[command(group = clap::ArgGroup::new("pictures").required(true).args(["dataset", "rendered", "film"]))]
pub(crate) struct Args {
    /// Photographs with ground-truth labels: a folder of sets, each with `images/` (PNG, JPEG) and
    /// `labels/` (8-bit gray PNG of the same name: 0 is the table, 1… the ropes)
    #[arg(long, value_name = "DIR")]
    dataset: Option<PathBuf>,
    #[command(flatten)]
    rendered: rendered::Args,
    /// Film without labels, a folder of pictures in the order of their names: measure how far its
    /// curves are from their points
    #[arg(long, value_name = "DIR")]
    film: Option<PathBuf>,
    /// Number of control points of the Bezier curve that the points are compared with [default:
    /// chosen by the chain]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(2..))]
    control_points: Option<u16>,
    /// Method that turns the mask into a centerline: skeleton, kmeans, som, gmm or fcm
    /// (`extract.method` of the settings)
    #[arg(long, value_name = "NAME", default_value_t)]
    method: Method,
    /// Method that segments the ropes' pixels in photographs
    #[arg(long, value_name = "NAME", value_enum, default_value_t = Mask::Auto, requires = "dataset")]
    mask: Mask,
    /// Write one line per image, with all its figures, to FILE
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Draw the result over each photograph, with a contact sheet for each set: DIR/SET/IMAGE.png;
    /// or over each drawn picture: DIR/CLASS-SEED.png
    #[arg(long, value_name = "DIR")]
    overlay: Option<PathBuf>,
    /// Which strand is on top at each crossing, judged by eye: a line
    /// `SET/IMAGE,x,y,degrees,yes|no` for each, with the direction of the upper strand and whether
    /// the judgment is certain [default: the list that comes with this bench, if it has one for a
    /// data set of this name]
    #[arg(long, value_name = "FILE")]
    crossings: Option<PathBuf>,
}

/// Runs the selected measurements and prints the results.
///
/// # Errors
/// The data cannot be read or the results cannot be written. The error is a sentence that names the
/// file.
pub(crate) fn run(args: &Args) -> Result<()> {
    match (&args.dataset, &args.film) {
        (Some(folder), _) => run_on_photographs(folder, args),
        (None, Some(folder)) => curve::run_on_film(folder, args.method, args.control_points),
        (None, None) => {
            let files = (args.csv.as_deref(), args.overlay.as_deref());
            rendered::run(&args.rendered, args.method, args.control_points, files)
        }
    }
}

fn run_on_photographs(folder: &Path, args: &Args) -> Result<()> {
    let sets = dataset::find(folder)?;
    let list = args
        .crossings
        .clone()
        .or_else(|| crossings::list_for(folder));
    let seen = list.map(|list| crossings::load(&list)).transpose()?;
    let mut bench = Bench::new(args.method, args.mask)?;
    let mut measured = Vec::new();
    for set in &sets {
        let images: Result<_> = set.pairs.iter().map(|pair| bench.measure(pair)).collect();
        measured.push((set.name.as_str(), images?));
    }
    // Written last, so that a broken picture leaves no partial output.
    if let Some(path) = &args.csv {
        whole_file::write(path, csv::table(&measured).as_bytes())?;
    }
    if let Some(folder) = &args.overlay {
        for (set, (_, images)) in sets.iter().zip(&measured) {
            overlay::write_set(&folder.join(&set.name), &set.pairs, images)?;
        }
    }
    print!("{}", report::table(&measured))?;
    print!("{}", whole::table(&measured))?;
    print!("{}", crossings::table(&measured, &seen.unwrap_or_default()))?;
    let mut curves = Curves::new(args.control_points)?;
    let mut fitted = Vec::new();
    for (name, images) in &measured {
        let found = images.iter().flat_map(|image| &image.curves);
        let fits: Result<_> = found.map(|curve| curves.fit(curve)).collect();
        fitted.push((*name, fits?));
    }
    print!("\n{}", curve::table(fitted))?;
    Ok(())
}
