//! `lariat servo`: drives a simulated rope to a shape by camera feedback through the real chain,
//! and measures how well this works and what it depends on.
//!
//! # How it works
//!
//! `lariat servo` (`bench/src/servo/`) drives ropes for each case of a study (`cases`) and each
//! seed. It uses the same processes as any user (`episode`): `lariat run --source simulated` and a
//! controller. The judge reads the ground truth from the source.
//!
//! ```text
//!  capture (rope, robot, pictures) ──► extract ──► fit ──► descriptors ──► controller ─┐
//!    ▲        └──► truth ──► judge                                                     │
//!    └──────────────────────── commands ◄──────────────────────────────────────────────┘
//! ```
//!
//! - **The controller** (`controller`) is `crates/control` between a `Reader` and the command
//!   channel. It knows the initial positions of its grippers, their speed limits and their
//!   workspace (`job`). It also knows the target's points, which it fits as the chain fits ropes.
//!   It sends a command for each image, and every 20 ms without one. The robot stops by itself 250
//!   ms after the last command.
//! - **Observations** (`controller/observer`): the ends are in the jaws, so a rope is always
//!   `Partial`. An observation counts as incomplete if one of its points is hidden, or if its
//!   length differs by more than 3 % from that of the first observations.
//! - **Color**: the rig's ropes are segmented by color. The automatic mask would also find the
//!   rope, and more accurately. But after a hand has passed over a gripped rope, that mask can
//!   leave the rope connected to a gripper. The controller then holds permanently.
//! - **A slower link** is a queue in the observer. It delays each observation, which keeps its own
//!   exposure time.
//! - **The judge** (`judge`) computes the mean distance of 120 points at equal steps. A target is
//!   reached when the rope stays there: a case ends when the rope has been within 5 px for 1.5 s,
//!   or after `--time`.
//! - **The film** (`camera/`, `film/`) is made from the rig's frames as they pass. The film of a
//!   lifted rope has two views. `report/` makes table, sentences and page from the errors alone.

mod camera;
mod cases;
mod controller;
mod episode;
mod film;
mod job;
mod judge;
mod report;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use anyhow::{Context, Result};
use clap::Args;

use cases::{Case, Target};
pub(crate) use controller::{ControllerArgs, run as run_controller};
use lariat_chain::exit::wrong_use;
use lariat_chain::output::{Existing, Output, OutputFolder, print};
use lariat_chain::settings::duration;
use lariat_chain::stop::Stop;
use lariat_sink::Machine;
use report::{Row, Study};

/// Minimum share of ropes that must reach their target for a successful exit code.
const ENOUGH: f64 = 0.95;

/// Options of `lariat servo`.
#[derive(Debug, Args)]
pub(crate) struct ServoArgs {
    /// Target shape: u, s, line, or a file with its points in pixels, as `lariat fit` reads them
    #[arg(long, default_value = "u", value_name = "u|s|line|FILE")]
    target: String,
    /// Lift the rope, add a depth camera, and drive it in 3-D: lengths are then in mm instead of px
    #[arg(long)]
    lifted: bool,
    /// Number of ropes: each seed has another start and another target position
    #[arg(long, default_value_t = 5, value_name = "COUNT", value_parser = clap::value_parser!(u64).range(1..=1000))]
    seeds: u64,
    /// First seed
    #[arg(long, default_value_t = 1, value_name = "NUMBER")]
    first_seed: u64,
    /// Frames per second, 5 to 1000
    #[arg(long, default_value_t = 60.0, value_name = "RATE", value_parser = fps)]
    fps: f64,
    /// Maximum time that one rope is driven
    #[arg(long, default_value = "20s", value_name = "TIME", value_parser = duration::parse)]
    time: Duration,
    /// Also measure dependencies, of all groups or of one: latency, frame rate, occlusion, noise,
    /// order and basis, features, estimator. For a lifted rope: frame rate, noise, order and basis,
    /// estimator
    #[arg(long, value_name = "GROUP", num_args = 0..=1, default_missing_value = "")]
    study: Option<String>,
    /// Write the table and a page with all figures to this folder
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Film the first rope; - for standard output
    #[arg(long, value_name = "FILE.gif")]
    gif: Option<PathBuf>,
    /// Overwrite existing files
    #[arg(long)]
    force: bool,
    /// Domain of the controller, which a bridge connects to the chain of the rig servo
    #[arg(long, value_name = "NAME", hide = true)]
    controller_domain: Option<String>,
}

fn fps(text: &str) -> Result<f64, String> {
    let rate = text.parse().ok();
    rate.filter(|rate| (5.0..=1000.0).contains(rate))
        .ok_or_else(|| "choose a rate from 5 to 1000".to_owned())
}

/// Drives the ropes and prints the results.
pub(crate) fn run(args: &ServoArgs) -> Result<ExitCode> {
    let stop = Stop::on_signals()?;
    let target = Target::named(&args.target)?;
    if args.lifted && target.is_in_picture() {
        wrong_use!(
            "{} is a target in the picture: a lifted rope takes u, s or line",
            args.target
        );
    }
    // Unwritable outputs are reported before anything is driven.
    let existing = Existing::forced(args.force);
    let folder = args
        .out
        .as_ref()
        .map(|folder| OutputFolder::new(folder, existing, ["servo.html", "servo.txt", "servo.gif"]))
        .transpose()?;
    let gif = args
        .gif
        .as_ref()
        .map(|file| Output::new(file, existing, [Path::new(&args.target)]))
        .transpose()?;
    let is_filmed = gif.is_some() || folder.is_some();
    let mut film = None;
    let mut latencies_ms = Vec::new();
    let mut rows = Vec::new();
    for case in Case::asked(args.fps, args.lifted, args.study.as_deref())? {
        let mut outcomes = Vec::new();
        for seed in args.first_seed..args.first_seed + args.seeds {
            let filmed = is_filmed && film.is_none();
            let domain = args.controller_domain.as_deref();
            let Some(driven) = case.drive(seed, &target, args.time, filmed, domain, &stop)? else {
                return Ok(ExitCode::FAILURE);
            };
            eprintln!("lariat-bench: {}", case.said(&driven.outcome));
            outcomes.push(driven.outcome);
            film = film.or(driven.film);
            if rows.is_empty() {
                latencies_ms.extend(driven.latencies_ms);
            }
        }
        rows.push(case.row(outcomes));
    }
    let study = study(args, rows, latencies_ms);
    let table = report::table(&study);
    // The files are written even if nobody reads the standard output.
    let said = match &gif {
        Some(gif) => gif.print(&table),
        None => print(&table),
    };
    if let (Some(gif), Some(film)) = (&gif, &film) {
        gif.write(film)?;
    }
    if let Some(folder) = &folder {
        write_report(folder, &study, film.as_deref())?;
    }
    said?;
    Ok(verdict(&study.rows))
}

fn study(args: &ServoArgs, rows: Vec<Row>, mut latencies_ms: Vec<f64>) -> Study {
    latencies_ms.sort_by(f64::total_cmp);
    let machine = Machine::this();
    let words = std::env::args().skip(1).collect::<Vec<_>>().join(" ");
    let seeds = format!("{} from {} on", args.seeds, args.first_seed);
    Study {
        title: "A rope driven to a shape through the camera".to_owned(),
        target: args.target.clone(),
        unit: if args.lifted { "mm" } else { "px" },
        rows,
        command: format!("lariat {words}"),
        parameters: vec![
            ("lariat", env!("CARGO_PKG_VERSION").to_owned()),
            ("seeds", seeds),
            ("frames/s", args.fps.to_string()),
            ("kernel", machine.kernel),
            ("CPU", machine.cpu.unwrap_or_default()),
        ],
        own_latency_ms: latencies_ms.get(latencies_ms.len() / 2).copied(),
    }
}

fn write_report(folder: &OutputFolder, study: &Study, film: Option<&[u8]>) -> Result<()> {
    let page = report::page(study, film).context("the figures could not be drawn")?;
    folder.write("servo.html", page.as_bytes())?;
    folder.write("servo.txt", report::table(study).as_bytes())?;
    if let Some(film) = film {
        folder.write("servo.gif", film)?;
    }
    let page = folder.path().join("servo.html");
    eprintln!("lariat-bench: wrote {}", page.display());
    Ok(())
}

/// Returns success if the default chain brings enough ropes to their target.
fn verdict(rows: &[Row]) -> ExitCode {
    let Some(row) = rows.first() else {
        return ExitCode::FAILURE;
    };
    let reached = row.outcomes.iter().filter(|o| o.is_reached()).count();
    if reached as f64 >= ENOUGH * row.outcomes.len() as f64 {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}
