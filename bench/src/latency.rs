//! `lariat bench`: how long a frame is under way on this machine, beside what it cannot be faster than and what others
//! take.
//!
//! Everything is measured in rounds, one thing after the other, and again: what drifts on a machine drifts for all.
//! A figure is the median of its rounds; between the least and the greatest round lies its noise.
//!
//! # How it works
//!
//! `lariat bench` (`bench/src/latency/`) measures everything in rounds (`plan`): floors, the chain, rivals, and again, so that what
//! drifts on a machine drifts for all; a figure is the median of its rounds, a ratio is taken within each round. It starts
//! `lariat`, and parts of this program (`lariat-bench latency-part …`, hidden), in a domain, a folder and a process group of their own.
//! Each is started through `latency-part guard` (`guard`), which asks the kernel to end it with the bench, puts it on its core
//! and under FIFO if so asked, and then becomes it: a Ctrl-C, an error or a `kill -9` of the bench leaves nothing
//! running.
//!
//! | module | what |
//! |---|---|
//! | `choice`, `plan`, `job` | what the user can choose, what is measured in which order and for how long, one measurement |
//! | `floors` | reading and copying the frame, a wake on a futex and an eventfd on one core and across, lateness of a timer, as other programs have it and under FIFO: no chain's 99.9th percentile is better than that one's for long |
//! | `relay` | four processes that pass 64 bytes on over bare iceoryx2 (`bare`), in each arrangement; the best of a run is its floor |
//! | `chain` | `lariat run` as users start it. What it says itself is read from its `--out`; the share of a core is looked up over the middle of the run (`usage`), memory in a run of its own, as a look at a process's pages holds it up |
//! | `rivals/` | the same stages' work (`steps`) as threads with channels, and over Unix sockets (`encoding`); the scripts of `bench/rivals`, which are in the executable |
//! | `figures`, `targets` | rounds merged; what is to be reached |
//! | `table`, `plot`, `report`, `summary` | what is shown: text, SVG, HTML, JSON |
//!
//! *Overhead* is the way of a frame from its due moment into the reader's hands without the time extract and fit worked on it,
//! frame by frame (`overhead.hgrm`); *links* the same without how late capture was. The floor of 64 bytes counts from the due
//! moment, too.
//!
//! **Where the tail is** (640×480, 1000 frames/s, `--realtime`, one minute under `perf sched record`, on a virtual machine). Up to
//! about 0.8 ms it is extraction: one frame in some tens is looked at whole, 0.5 to 0.75 ms of work with caches that following
//! has left cold, where the median frame takes 0.1 ms in all. Where many in a row are, beside the drawing, each is later than the one
//! before, up to 30 ms: `slowest.txt` of `lariat run --out` shows which. Beyond that it is the host: stages that stay on their core for
//! 2 to 25 ms without the kernel's own ticks in between, which says that the core itself stood still, and phases of 0.1 s in
//! which every stage takes ten to thirty times as long. The chain itself waits for nothing there: in the minute stages were put
//! off their core twenty times, by the kernel's own workers, and the longest from a wake to the woken's first step was 3 ms,
//! within such a phase. Drawing the rope is half of the work at
//! that rate, all on the one core, so that each such pause takes three times its length to catch up with.
//!
//! `lariat-bench soak` shows the film of a rope for a day by the frames' own clock, through extraction, fit and filter (2.6
//! million frames in two minutes): the last hour costs what the first did, in time, memory and descriptors. Sink has a test of
//! as many messages.

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
    /// Write report.html, summary.json and a histogram (.hgrm) of everything into this folder
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Overwrite a report that is there already
    #[arg(long)]
    pub force: bool,
    /// A look in a few seconds: one short round
    #[arg(long, conflicts_with = "full")]
    pub quick: bool,
    /// Every size at every rate, 640×480 at 1000 frames/s for a minute: takes half an hour
    #[arg(long)]
    pub full: bool,
    /// Also with every core kept busy by another program
    #[arg(long)]
    pub load: bool,
    /// Sizes of the picture, instead of the usual ones
    #[arg(long, value_name = "WxH", num_args = 1.., value_parser = choice::size)]
    pub size: Vec<[u32; 2]>,
    /// Rates in frames per second, or `max`, instead of the usual ones
    #[arg(long, value_name = "NUMBER", num_args = 1.., value_parser = choice::rate)]
    pub fps: Vec<choice::Rate>,
    /// How often everything is measured
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub rounds: Option<u32>,
    /// The Python that has the rivals' packages
    #[arg(long, value_name = "PATH", default_value = "python3")]
    pub python: PathBuf,
    /// Flags of `lariat run` that the chain is measured with, after `--`
    #[arg(last = true, value_name = "FLAGS")]
    pub flags: Vec<String>,
}

/// A program that a measurement is made of. Not for users.
#[derive(Debug, Clone, Args)]
pub(crate) struct PartArgs {
    #[command(subcommand)]
    part: Part,
}

#[derive(Debug, Clone, Subcommand)]
enum Part {
    /// Becomes another program, which ends with the bench
    Guard(guard::GuardArgs),
    /// One of four processes that pass 64 bytes on
    Relay(relay::RelayArgs),
    /// The four stages as threads
    Threads(rivals::ThreadsArgs),
    /// One of four stages over sockets
    SocketStage(rivals::StageArgs),
    /// Keeps a core busy
    Spin,
}

/// Is a part of a measurement.
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

/// Counts until a signal comes.
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
/// The chain does not run here, or the report cannot be written. Rivals that are not there are said to be missing.
pub(crate) fn run(args: &BenchArgs) -> Result<ExitCode> {
    // Asked before the minutes pass.
    let existing = Existing::forced(args.force);
    let folder = args
        .out
        .as_ref()
        .map(|dir| OutputFolder::new(dir, existing, ["report.html", "summary.json"]))
        .transpose()?;
    // A path is meant from here, and not from where the scripts run; symbolic links stay, as a virtual environment's
    // Python is one.
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
    // The report is written also where nobody reads this.
    let said = print(&table::table(&plan, &summary));
    if let Some(folder) = &folder {
        report::write(folder, &plan, &summary)?;
        let page = folder.path().join("report.html");
        eprintln!("lariat-bench: the report is {}", page.display());
    }
    said?;
    Ok(ExitCode::SUCCESS)
}

/// Measures everything, round after round; a signal ends it after the rounds that are whole.
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

/// Says in place what is measured just now, on a terminal.
fn say(line: &str) {
    if std::io::stderr().is_terminal() {
        eprint!("\r\x1b[K{line}");
    }
}
