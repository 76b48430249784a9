//! Cost of an extraction, next to a pass that only reads the frame.
//!
//! Run it with `cargo bench --manifest-path bench/Cargo.toml --bench extract`. `-- --quick` uses a
//! tenth of the time. `-- --dataset DIR`, or the environment variable `LARIAT_MBEST`, adds
//! photographs.
//!
//! Three things are timed for each frame, on one thread:
//!
//! - "read", the floor, sums the frame's bytes with the machine's widest loads.
//! - "cold" is an extraction whose extractor was reset before.
//! - "tracked" is an extraction whose extractor has seen the previous frames. A film's first frame
//!   is left out.
//!
//! Before each of them, the frame is read once more, untimed. As much of it as fits is then in the
//! second-level cache, as for a stage that runs right after the camera's writer. Frames are aligned
//! to a cache line, as in the chain.
//!
//! The cases of a table take turns, film by film, until the table's time is used up. The first turn
//! is not counted. Figures are medians over frames and turns. "÷ read" is the median of the ratios
//! to the read of the same frame in the same turn. Other ratios divide two medians of one table.

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

/// Time extraction step by step, next to a pass that only reads the frame
#[derive(Parser)]
struct Args {
    /// Use a tenth of the time, for a quick estimate
    #[arg(long)]
    quick: bool,
    /// Folder of photographs: it contains `images`, or folders that do [default: $LARIAT_MBEST
    /// if set]
    #[arg(long, value_name = "DIR")]
    dataset: Option<PathBuf>,
    /// Passed by `cargo bench`
    #[arg(long, hide = true)]
    bench: bool,
}

/// Amount of measuring.
struct Effort {
    quick: bool,
}

impl Effort {
    /// Returns the time for a table, given its full time in seconds.
    fn time(&self, seconds: f64) -> Duration {
        Duration::from_secs_f64(if self.quick { 0.1 * seconds } else { seconds })
    }

    /// Returns the first `frames` frames of a film, or a quarter of them with `--quick`.
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
