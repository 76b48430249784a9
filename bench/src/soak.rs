//! `lariat-bench soak`: runs a day of frames through extraction, fit and filter by a simulated
//! clock. It compares the cost of the last hour with that of the first.

use std::fs;
use std::time::Instant;

use crate::{Samples, Table, micros, rendered};
use anyhow::{Context, Result, ensure};
use lariat_capture::RenderOptions;
use lariat_extract::Extractor;
use lariat_fit::{Filter, FilterOptions, Fitter, Noise};

/// Length of the day.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Hours of simulated time
    #[arg(long, value_name = "N", default_value_t = 24)]
    hours: u64,
    /// Frames per second of simulated time
    #[arg(long, value_name = "N", default_value_t = 30)]
    fps: u64,
}

/// Pictures of the film. It is shown forward and backward, so that the rope never jumps.
const PICTURES: usize = 120;
const NS_PER_S: u64 = 1_000_000_000;

/// Shows the film until the day is over. Prints a line for the first, the last and every third
/// hour.
///
/// # Errors
/// A stage rejects its input, the rope is lost, or the kernel does not report the memory.
pub(crate) fn run(args: &Args) -> Result<()> {
    ensure!(
        (1..=1000).contains(&args.hours) && (1..=1000).contains(&args.fps),
        "invalid day of {} hours at {} frames/s: give 1 to 1000 of each",
        args.hours,
        args.fps
    );
    let options = RenderOptions {
        frame_interval_s: 1.0 / args.fps as f64,
        frames: Some(PICTURES as u64),
        ..RenderOptions::default()
    };
    let film = rendered(&options)?;
    let mut extractor = Extractor::new(lariat_extract::Options::default())?;
    let mut fitter = Fitter::new(lariat_fit::Options::default())?;
    let space = fitter.curve_space()?;
    let count = fitter.options().basis.control_points();
    let mut filter: Filter<2> = Filter::new(count, FilterOptions::default())?;
    let mut points: Vec<[f64; 2]> = Vec::new();
    let mut table = Table::new(&[
        "hour",
        "frames",
        "curves",
        "µs a frame: p50",
        "p99",
        "resident, MB",
        "descriptors",
    ]);
    let a_turn = 2 * PICTURES - 2;
    let mut number = 0;
    for hour in 1..=args.hours {
        let mut times: Samples = Samples::default();
        let mut curves = 0u64;
        for _ in 0..3600 * args.fps {
            let step = number as usize % a_turn;
            let image = film[step.min(a_turn - step)].picture.image();
            let exposed_ns = NS_PER_S + number * NS_PER_S / args.fps;
            let start = Instant::now();
            let scene = extractor.at(exposed_ns).extract(&image);
            if let Some(curve) = scene.curves.first() {
                points.clear();
                points.extend(curve.points.iter().map(|p| p.map(f64::from)));
                let fit = fitter.fit(&points)?;
                let noise = Noise::Even {
                    variance_px2: fit.residual_variance,
                };
                filter.update(exposed_ns, &space, &fit.control_points, noise)?;
                filter.predict(exposed_ns)?;
                curves += 1;
            }
            times.push(start.elapsed().as_nanos() as f64);
            number += 1;
        }
        if hour == 1 || hour % 3 == 0 || hour == args.hours {
            let [resident_mb, descriptors] = of_this_process()?;
            table.push([
                hour.to_string(),
                number.to_string(),
                curves.to_string(),
                micros(times.median()),
                micros(times.percentile(0.99)),
                format!("{resident_mb:.1}"),
                format!("{descriptors}"),
            ]);
        }
    }
    print!("{table}")?;
    Ok(())
}

/// Returns the resident memory in MB of 10⁶ bytes and the number of open descriptors.
fn of_this_process() -> Result<[f64; 2]> {
    let status = fs::read_to_string("/proc/self/status").context("no /proc/self/status")?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let kib = line.and_then(|line| line.split_whitespace().next()?.parse::<f64>().ok());
    let descriptors = fs::read_dir("/proc/self/fd").context("no /proc/self/fd")?;
    Ok([
        kib.context("the kernel does not tell the resident memory")? * 1024.0 / 1e6,
        descriptors.count() as f64,
    ])
}
