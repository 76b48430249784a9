//! The command line: what can be asked of lariat, and who answers.

use std::ffi::OsString;
use std::process::ExitCode;

use anyhow::Result;
use clap::{Parser, Subcommand};

use crate::bench::{self, BenchArgs, PartArgs};
use crate::calibrate::{self, CalibrateArgs};
use crate::compare::{self, CompareArgs};
use crate::config_command::{self, ConfigArgs};
use crate::devices::{self, DevicesArgs};
use crate::doctor::{self, DoctorArgs};
use crate::export::{self, ExportArgs};
use crate::fit_lines::{self, FitArgs};
use crate::info::{self, InfoArgs};
use crate::paper::{self, PaperArgs};
use crate::pick::{self, PickArgs};
use crate::record::{self, RecordArgs};
use crate::replay::{self, ReplayArgs};
use crate::servo::{self, ControllerArgs, ServoArgs};
use crate::settings::{ChainArgs, Settings};
use crate::snapshot::{self, SnapshotArgs};
use crate::stages::Seat;
use crate::top::{self, TopArgs};
use crate::topic::{self, TopicArgs};
use crate::trace::{self, TraceArgs};
use crate::{chain, stages};

/// Sees ropes, cables and hoses through a camera, and gives a control loop their shape through shared memory
///
/// Without a command: shows the whole chain live on a rendered rope, for 10 seconds.
#[derive(Parser)]
#[command(name = "lariat", version)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Subcommand)]
enum Command {
    /// The whole chain: capture, extract, fit and sink, each in a process of its own
    Run(ChainArgs),
    /// The first stage alone: sends a source's frames
    Capture(ChainArgs),
    /// The second stage alone: frames in, centerlines out
    Extract(ChainArgs),
    /// The third stage alone; or descriptors of centerlines, line by line
    Fit(FitArgs),
    /// The last stage alone: counts and times what arrives, and reports at the end
    Sink(ChainArgs),
    /// Records what a chain sees and says, from outside, as an MCAP file
    Record(RecordArgs),
    /// The recorder that `run --record` starts
    #[command(hide = true)]
    Recorder(ChainArgs),
    /// Computes a recording again: to check that the same comes out, or what other settings change
    Replay(Box<ReplayArgs>),
    /// What was recorded, as a table, JSON lines, a video or pictures
    Export(ExportArgs),
    /// What a recording holds
    Info(InfoArgs),
    /// The shapes of the ropes in pictures
    Trace(TraceArgs),
    /// The colours of the ropes in a picture, as a mask for lariat.toml
    Pick(PickArgs),
    /// Where what the camera sees lies: the table, from points whose place on it is known
    Calibrate(CalibrateArgs),
    /// The experiments of the paper that lariat is built on, again and with numbers, as one page
    Paper(PaperArgs),
    /// The cameras of this machine: formats, sizes, rates and controls
    Devices(DevicesArgs),
    /// One frame of a camera, or any other source, as a PNG picture
    Snapshot(SnapshotArgs),
    /// A running chain, live on the terminal
    Top(TopArgs),
    /// What passes on the channels of a running chain
    Topic(TopicArgs),
    /// Writes, checks and shows lariat.toml
    Config(ConfigArgs),
    /// A simulated rope driven to a shape through the whole chain, and what that depends on
    Servo(ServoArgs),
    /// The controller that `servo` starts
    #[command(hide = true)]
    Controller(Box<ControllerArgs>),
    /// What of this machine makes lariat slower than it could be, and what to type
    Doctor(DoctorArgs),
    /// How long a frame is under way on this machine, beside its floors and beside others
    Bench(BenchArgs),
    /// What got better or worse from one summary.json to another
    Compare(CompareArgs),
    /// A program that `bench` starts
    #[command(hide = true)]
    BenchPart(PartArgs),
}

/// What is asked of the chain when nothing was asked.
const SHOW: [&str; 1] = ["--duration=10s"];

/// Does what the command line asks.
pub(crate) fn run() -> Result<ExitCode> {
    let cli = Cli::parse();
    log_to_stderr();
    match cli.command {
        None => {
            let settings = Settings::resolve(&ChainArgs::default())?;
            settings.check_frames()?;
            chain::run(&SHOW.map(OsString::from), settings)
        }
        Some(Command::Run(args)) => {
            // Resolved here too, so that a mistake is told once and not by four processes.
            let settings = Settings::resolve(&args)?;
            settings.check_frames()?;
            chain::run(&after_the_command(), settings)
        }
        Some(Command::Capture(args)) => stage(&args, stages::capture::run),
        Some(Command::Extract(args)) => stage(&args, stages::extract::run),
        Some(Command::Fit(args)) if fit_lines::is_line_filter(&args) => fit_lines::run(args),
        Some(Command::Fit(args)) => stage(&args.chain, stages::fit::run),
        Some(Command::Sink(args)) => stage(&args, stages::sink::run),
        Some(Command::Record(args)) => record::run(args),
        Some(Command::Recorder(args)) => record::run_for_chain(&args),
        Some(Command::Replay(args)) => replay::run(*args),
        Some(Command::Export(args)) => export::run(args),
        Some(Command::Info(args)) => info::run(args),
        Some(Command::Trace(args)) => trace::run(args),
        Some(Command::Pick(args)) => pick::run(args),
        Some(Command::Calibrate(args)) => calibrate::run(args),
        Some(Command::Paper(args)) => paper::run(args),
        Some(Command::Devices(args)) => devices::run(args),
        Some(Command::Snapshot(args)) => snapshot::run(args),
        Some(Command::Top(args)) => top::run(&args),
        Some(Command::Topic(args)) => topic::run(args),
        Some(Command::Config(args)) => config_command::run(args),
        Some(Command::Servo(args)) => servo::run(&args),
        Some(Command::Controller(args)) => servo::run_controller(&args),
        Some(Command::Doctor(args)) => doctor::run(args),
        Some(Command::Bench(args)) => bench::run(&args),
        Some(Command::Compare(args)) => compare::run(&args),
        Some(Command::BenchPart(args)) => bench::run_part(&args),
    }
}

fn stage(args: &ChainArgs, run: fn(&Settings, Seat) -> Result<()>) -> Result<ExitCode> {
    run(&Settings::resolve(args)?, Seat::of_this_process()?).map(|()| ExitCode::SUCCESS)
}

/// The stages understand the flags of `lariat run`, and are given them as they were typed.
fn after_the_command() -> Vec<OsString> {
    std::env::args_os().skip(2).collect()
}

fn log_to_stderr() {
    tracing_subscriber::fmt()
        .with_writer(std::io::stderr)
        .without_time()
        .with_target(false)
        // It would be said where nothing can be said.
        .log_internal_errors(false)
        .with_max_level(tracing::Level::INFO)
        .init();
}
