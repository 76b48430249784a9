//! `lariat-bench rivals`: the same work on the same pictures by OpenCV and scikit-image, one thread
//! each, side by side.
//!
//! Pictures are collected and written as PNG files (`pictures`). The scripts of `bench/rivals` and
//! lariat then take turns on them, pass by pass (`script`, `ours`). The medians of all passes make
//! one table (`report`). Libraries that are not installed are reported and left out.

mod ours;
mod pictures;
mod report;
mod script;

use std::path::PathBuf;

use anyhow::Result;

use ours::Ours;
use pictures::Pictures;
use script::{Done, Work};

/// What to measure.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Folder of photographs: it contains `images`, or folders that do
    #[arg(long, value_name = "DIR")]
    dataset: Option<PathBuf>,
    /// Picture files (PNG, JPEG)
    #[arg(long, value_name = "FILE", num_args = 1..)]
    images: Vec<PathBuf>,
    /// Python interpreter that has the libraries
    #[arg(long, value_name = "PATH", default_value = "python3")]
    python: PathBuf,
    /// Number of drawn frames of 640×480
    #[arg(long, value_name = "N", default_value_t = 10)]
    frames: u64,
    /// Number of turns of each program on all pictures
    #[arg(long, value_name = "N", default_value_t = 3)]
    passes: usize,
    /// Measurements of each picture in a turn
    #[arg(long, value_name = "N", default_value_t = 5)]
    rounds: usize,
}

/// A script's passes, or the reason why there are none.
struct Rival {
    work: Work,
    done: Result<Done, String>,
}

/// Measures and prints the table.
///
/// # Errors
/// The pictures cannot be read, or cannot be written for the scripts.
pub(crate) fn run(args: &Args) -> Result<()> {
    anyhow::ensure!(
        args.passes > 0 && args.rounds > 0 && args.frames > 0,
        "there is nothing to measure: give --frames, --passes and --rounds of 1 or more"
    );
    let (pictures, left_out) = Pictures::gather(args)?;
    for sentence in left_out {
        eprintln!("{sentence}");
    }
    let list = pictures.write(args.rounds)?;
    let mut ours = Ours::new(&pictures)?;
    let mut rivals = Work::ALL.map(|work| Rival {
        work,
        done: Ok(Done::default()),
    });
    for _ in 0..args.passes {
        ours.measure(&pictures, args.rounds);
        for rival in &mut rivals {
            // A missing library will also be missing in the next pass.
            if let Ok(done) = &mut rival.done
                && let Err(why) = script::run(rival.work, &args.python, list.path(), done)
            {
                rival.done = Err(why);
            }
        }
    }
    print!("{}", report::report(&pictures, &ours, &rivals, args.passes))?;
    Ok(())
}
