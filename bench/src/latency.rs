//! `lariat bench`: the end-to-end latency of a frame on this machine, with its lower bounds and the
//! latency of other systems.
//!
//! Everything is measured once per round, so that drift of the machine affects all measurements. A
//! figure is the median of its rounds. Its noise is the range from the least to the greatest round.
//!
//! # How it works
//!
//! Each round of `lariat bench` (`bench/src/latency/`) measures floors, the chain and rivals
//! (`plan`). A figure is the median of its rounds; a ratio is taken within each round. The bench
//! starts `lariat` and parts of this program (`lariat-bench latency-part …`, hidden) in a domain, a
//! folder and a process group of their own.
//!
//! Each process is started through `latency-part guard` (`guard`). The guard asks the kernel to end
//! it with the bench. It moves to its core and to FIFO scheduling if requested, and then becomes
//! the program (`exec`). A Ctrl-C, an error or a `kill -9` of the bench leaves nothing running.
//!
//! | module | content |
//! |---|---|
//! | `choice`, `plan`, `job` | the user's options; the order and duration of measurements; one measurement |
//! | `floors` | reading and copying the frame; a wake on a futex and an eventfd, on one core and across cores; lateness of a timer, with default scheduling and under FIFO, which bounds every chain's 99.9th percentile |
//! | `relay` | four processes that forward 64 bytes over bare iceoryx2 (`bare`), in each arrangement; the best arrangement of a run is the floor |
//! | `chain` | `lariat run` as users start it. Its own figures are read from its `--out`. The share of a core is sampled over the middle of the run (`usage`). Memory is measured in a separate run, because examining a process's pages delays it |
//! | `rivals/` | the same stages' work (`steps`) as threads with channels, and over Unix sockets (`encoding`); the scripts of `bench/rivals`, which are embedded in the executable |
//! | `figures`, `targets` | merging of rounds; targets |
//! | `table`, `plot`, `report`, `summary` | output: text, SVG, HTML, JSON |
//!
//! *Overhead* is the time from a frame's due time until a reader has its result, minus the work of
//! extract and fit on it. It is computed frame by frame (`overhead.hgrm`). *Links* is the overhead
//! minus the lateness of capture. The floor of 64 bytes also counts from the due time.
//!
//! **The tail** (640×480, 1000 frames/s, `--realtime`, one minute under `perf sched record`, on a
//! virtual machine):
//!
//! - Up to about 0.8 ms, the cause is extraction. One frame in a few dozen gets a full extraction,
//!   which takes 0.5 to 0.75 ms because tracking has left the caches cold. The median frame takes
//!   0.1 ms in all.
//! - Several such frames in a row, together with rendering, cause delays of up to 30 ms.
//!   `slowest.txt` of `lariat run --out` shows them.
//! - Beyond that, the cause is the host. Stages stay on their core for 2 to 25 ms without a kernel
//!   tick, so the core itself was stopped. In phases of 0.1 s every stage takes ten to thirty times
//!   as long.
//! - The chain itself does not wait. The kernel's own workers preempted stages twenty times in the
//!   minute. The longest delay from a wake to the first step was 3 ms, in a slow phase.
//! - Rendering the rope is half of the work at that rate, all on one core. Catching up therefore
//!   takes three times the length of a pause.
//!
//! `lariat-bench soak` runs a day of rope frames by a simulated clock through extraction, fit and
//! filter (2.6 million frames in two minutes). The last hour costs as much as the first in time,
//! memory and file descriptors. A test of the sink uses the same number of messages.

mod chain;
mod choice;
mod figures;
mod floors;
pub(crate) mod guard;
mod job;
mod plan;
mod plot;
mod relay;
mod report;
mod rivals;
mod summary;
mod table;
mod targets;
mod usage;
mod workplace;

use std::io::IsTerminal;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use anyhow::{Result, bail, ensure};
use clap::{Args, Subcommand};

use lariat_chain::load::Load;
use lariat_chain::output::{Existing, OutputFolder, print};
use lariat_chain::stop::Stop;
use plan::Plan;
pub(crate) use summary::KIND;
use workplace::Workplace;

/// What to measure.
#[derive(Debug, Clone, Args)]
pub(crate) struct BenchArgs {
    /// Write report.html, summary.json and a histogram (.hgrm) of every measurement into this
    /// folder
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Overwrite an existing report
    #[arg(long)]
    pub force: bool,
    /// Measure one short round, in a few seconds
    #[arg(long, conflicts_with = "full")]
    pub quick: bool,
    /// Measure every size at every rate, and 640×480 at 1000 frames/s for a minute: takes half an
    /// hour
    #[arg(long)]
    pub full: bool,
    /// Measure also with every core kept busy by another program
    #[arg(long)]
    pub load: bool,
    /// Sizes of the picture in pixels, instead of the usual ones
    #[arg(long, value_name = "WxH", num_args = 1.., value_parser = choice::size)]
    pub size: Vec<[u32; 2]>,
    /// Rates in frames per second, or `max`, instead of the usual ones
    #[arg(long, value_name = "NUMBER", num_args = 1.., value_parser = choice::rate)]
    pub fps: Vec<choice::Rate>,
    /// Number of rounds
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub rounds: Option<u32>,
    /// Python interpreter that has the rivals' packages
    #[arg(long, value_name = "PATH", default_value = "python3")]
    pub python: PathBuf,
    /// Flags of `lariat run` that the chain is measured with, after `--`
    #[arg(last = true, value_name = "FLAGS")]
    pub flags: Vec<String>,
}

/// A helper program of a measurement. Not for users.
#[derive(Debug, Clone, Args)]
pub(crate) struct PartArgs {
    #[command(subcommand)]
    part: Part,
}

#[derive(Debug, Clone, Subcommand)]
enum Part {
    /// Run another program that ends with the bench
    Guard(guard::GuardArgs),
    /// Run one of four processes that forward 64 bytes
    Relay(relay::RelayArgs),
    /// Run the four stages as threads
    Threads(rivals::ThreadsArgs),
    /// Run one of four stages over sockets
    SocketStage(rivals::StageArgs),
    /// Keep a core busy
    Spin,
}

/// Runs one part of a measurement.
pub(crate) fn run_part(args: &PartArgs) -> Result<ExitCode> {
    match &args.part {
        Part::Guard(args) => return guard::run(args),
        Part::Relay(args) => relay::run(args)?,
        Part::Threads(args) => rivals::run_threads(args)?,
        Part::SocketStage(args) => rivals::socket_stage(args)?,
        Part::Spin => spin()?,
    }
    Ok(ExitCode::SUCCESS)
}

/// Spins until a signal arrives.
fn spin() -> Result<()> {
    let stop = Stop::on_signals()?;
    while !stop.asked() {
        std::hint::spin_loop();
    }
    Ok(())
}

/// Runs `lariat bench`.
///
/// # Errors
/// The chain does not run here, or the report cannot be written. Unavailable rivals are reported as
/// missing, not as errors.
pub(crate) fn run(args: &BenchArgs) -> Result<ExitCode> {
    // Fail early, before minutes of measuring.
    let existing = Existing::forced(args.force);
    let folder = args
        .out
        .as_ref()
        .map(|dir| OutputFolder::new(dir, existing, ["report.html", "summary.json"]))
        .transpose()?;
    // A relative path refers to the current folder, not to the one where the scripts run. Symbolic
    // links are kept, because the Python of a virtual environment is one.
    let python = match args.python.components().count() {
        1 => args.python.clone(),
        _ => std::path::absolute(&args.python).unwrap_or_else(|_| args.python.clone()),
    };
    if let Some(warning) = Load::now().and_then(Load::warning) {
        eprintln!("lariat-bench: {warning}");
    }
    let workplace = Workplace::open(python)?;
    let mut plan = Plan::new(args, &workplace);
    let begin = Instant::now();
    let rounds = measure(&mut plan, &workplace)?;
    let seconds = begin.elapsed().as_secs_f64();
    drop(workplace);
    plan.compare_with_the_floor();
    let summary = summary::Summary::new(&plan, args, rounds, seconds);
    // The report is written even if nobody reads the standard output.
    let said = print(&table::table(&plan, &summary));
    if let Some(folder) = &folder {
        report::write(folder, &plan, &summary)?;
        let page = folder.path().join("report.html");
        eprintln!("lariat-bench: the report is {}", page.display());
    }
    said?;
    Ok(ExitCode::SUCCESS)
}

/// Measures everything, round by round. On a signal, returns with the rounds that are complete.
fn measure(plan: &mut Plan, workplace: &Workplace) -> Result<u32> {
    let mut whole = 0;
    for round in 1..=plan.rounds {
        let mut outcomes = Vec::new();
        for job in 0..plan.jobs.len() {
            if !plan.is_wanted(job) {
                continue;
            }
            say(&format!(
                "round {round} of {}: {}",
                plan.rounds,
                plan.item(job).title
            ));
            let measured = plan.jobs[job].measure(workplace);
            if workplace.stop.asked() {
                say("");
                ensure!(
                    whole > 0,
                    "stopped by a signal before anything was measured whole"
                );
                return Ok(whole);
            }
            match measured {
                Ok(outcome) => outcomes.push((job, outcome)),
                Err(why) if plan.jobs[job].optional => plan.give_up(job, &format!("{why:#}")),
                Err(why) => {
                    say("");
                    bail!("{}: {why:#}", plan.item(job).title);
                }
            }
        }
        for (job, outcome) in outcomes {
            plan.add(job, outcome);
        }
        whole = round;
    }
    say("");
    Ok(whole)
}

/// Shows the current measurement in place, on a terminal.
fn say(line: &str) {
    if std::io::stderr().is_terminal() {
        eprint!("\r\x1b[K{line}");
    }
}
