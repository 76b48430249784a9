//! Cost of an extraction, next to a pass that only reads the frame: `cargo bench --manifest-path bench/Cargo.toml --bench extract`.
//!
//! The floor, "read", sums the bytes of the same frame by the widest loads of the machine. For each frame in turn, on one
//! thread, three things are timed: the floor; an extraction by an extractor that was told to forget the past (cold);
//! one by an extractor that has seen the frames before (tracked; a film's first frame is left out). Before each of them
//! the frame is read once more, untimed, so that all three find its bytes where a stage finds them that runs right
//! after the camera's writer: in the second-level cache, as far as they fit. Frames lie on a cache line, as the chain's
//! do. The cases of a table take turns, film by film, until the table's time is used; the first turn is not counted.
//! Figures are medians over frames and turns; "÷ read" is the median of
//! the ratios to the read of the same frame in the same turn, other ratios are of two medians of one table.
//!
//! `-- --quick` uses a tenth of the time; `-- --dataset DIR`, or the environment's `LARIAT_MBEST`, adds photographs.

mod case;
mod formats;
mod hostile;
mod photos;
mod sizes;

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use anyhow::Result;
use clap::Parser;
use lariat_bench::{Picture, rendered};
use lariat_capture::RenderOptions;

/// Times extraction, step by step, beside a pass that only reads the frame
#[derive(Parser)]
struct Args {
    /// A tenth of the time, for a first look
    #[arg(long)]
    quick: bool,
    /// Photographs: a folder with `images` in it, or of such folders [default: $LARIAT_MBEST, else none]
    #[arg(long, value_name = "DIR")]
    dataset: Option<PathBuf>,
    /// Given by `cargo bench`
    #[arg(long, hide = true)]
    bench: bool,
}

/// How much is measured.
struct Effort {
    quick: bool,
}

impl Effort {
    /// The time for a table.
    fn time(&self, seconds: f64) -> Duration {
        Duration::from_secs_f64(if self.quick { 0.1 * seconds } else { seconds })
    }

    /// The first frames of a film, as many as are asked for, or a quarter.
    fn film(&self, options: RenderOptions, frames: u64) -> Result<Vec<Picture>> {
        let frames = if self.quick { frames / 4 } else { frames };
        let options = RenderOptions {
            frames: Some(frames),
            ..options
        };
        let film = rendered(&options)?;
        Ok(film.into_iter().map(|frame| frame.picture).collect())
    }
}

fn run(args: &Args) -> Result<()> {
    let effort = Effort { quick: args.quick };
    formats::run(&effort)?;
    sizes::run(&effort)?;
    hostile::run(&effort)?;
    let named = std::env::var_os("LARIAT_MBEST").map(PathBuf::from);
    match args.dataset.clone().or(named) {
        Some(folder) => photos::run(&effort, &folder)?,
        None => println!("\nno photographs: name a folder of them by `-- --dataset DIR`"),
    }
    Ok(())
}

fn main() -> ExitCode {
    match run(&Args::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("extract: {error:#}");
            ExitCode::FAILURE
        }
    }
}
