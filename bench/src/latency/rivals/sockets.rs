//! The four stages as processes connected by Unix sockets: pixels are copied into the kernel and
//! out of it.

use std::io::{Read, Write};
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::net::UnixStream;
use std::process::Stdio;
use std::time::Duration;

use anyhow::{Context, Result};
use lariat_sink::FinalCounts;
use lariat_wire::{Centerlines, Descriptors};

use super::encoding;
use super::steps::{CaptureStep, ExtractStep, FitStep, SinkStep, Task};
use crate::latency::chain;
use crate::latency::figures::Outcome;
use crate::latency::guard::{Guarded, Placement, end_all};
use crate::latency::workplace::Workplace;
use lariat_chain::stop::Stop;

/// Runs the four processes. Standard input is the socket to the previous process, and standard
/// output the socket to the next.
pub(in crate::latency) fn measure(
    workplace: &Workplace,
    size: [u32; 2],
    fps: f64,
    time: Duration,
) -> Result<Outcome> {
    let out = workplace.path("sockets");
    let pair = || UnixStream::pair().context("no sockets could be made");
    let [frames, centerlines, descriptors] = [pair()?, pair()?, pair()?];
    let to = |socket: UnixStream| Stdio::from(OwnedFd::from(socket));
    let ends = [
        (Stdio::null(), to(frames.0)),
        (to(frames.1), to(centerlines.0)),
        (to(centerlines.1), to(descriptors.0)),
        (to(descriptors.1), Stdio::null()),
    ];
    let mut programs = Vec::new();
    for (place, (input, output)) in ends.into_iter().enumerate() {
        let mut command = workplace.part(Placement::default(), "socket-stage");
        command.arg("--place").arg(place.to_string());
        command.args(Task::words(size, fps, time.as_secs_f64(), &out));
        programs.push(Guarded::start(command.stdin(input).stdout(output))?);
    }
    let ids: Vec<u32> = programs.iter().map(Guarded::id).collect();
    let percent = chain::cpu_percent(workplace, &ids, time)?;
    let what = "the chain over sockets";
    if let Some(last) = programs.pop() {
        workplace.finish(last, time + Duration::from_secs(30), what)?;
    }
    end_all(programs);
    let mut outcome = chain::read(&out, time, what)?;
    let _ = std::fs::remove_dir_all(out);
    outcome.figures.push(("cpu_percent", percent));
    Ok(outcome)
}

/// Arguments of `latency-part socket-stage`.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct StageArgs {
    /// Position of the stage among the four, from 0
    #[arg(long)]
    place: usize,
    #[command(flatten)]
    task: Task,
}

/// Runs one of the four stages until the previous one has ended.
pub(in crate::latency) fn run(args: &StageArgs) -> Result<()> {
    let socket = |end: &dyn Fn() -> std::io::Result<OwnedFd>| {
        end().map(UnixStream::from).context("a socket is missing")
    };
    let input = || socket(&|| std::io::stdin().as_fd().try_clone_to_owned());
    let output = || socket(&|| std::io::stdout().as_fd().try_clone_to_owned());
    match args.place {
        0 => capture(args, output()?),
        1 => look(args, input()?, output()?),
        2 => fit(args, input()?, output()?),
        _ => count(args, input()?),
    }
}

fn capture(args: &StageArgs, mut to: UnixStream) -> Result<()> {
    let stop = Stop::on_signals()?;
    let mut capture = CaptureStep::new(&args.task.settings())?;
    let mut pixels = vec![0; capture.frame_bytes()];
    // Its time starts when the other stages are ready.
    await_next(&mut to)?;
    while let Some(header) = capture.next(&mut pixels, &stop)? {
        encoding::write_frame(&mut to, &header, &pixels)?;
        std::thread::yield_now();
    }
    Ok(())
}

fn look(args: &StageArgs, mut from: UnixStream, mut to: UnixStream) -> Result<()> {
    let settings = args.task.settings();
    let mut extract = ExtractStep::new(&settings)?;
    let mut pixels = vec![0; CaptureStep::new(&settings)?.frame_bytes()];
    let mut message = Box::new(Centerlines::EMPTY);
    let mut bytes = Vec::new();
    await_next(&mut to)?;
    tell_ready(&mut from)?;
    while let Some(header) = encoding::read_frame(&mut from, &mut pixels)? {
        extract.look(&header, &pixels, &mut message);
        encoding::write(&mut to, &mut bytes, |bytes| {
            encoding::put_centerlines(bytes, &message);
        })?;
    }
    Ok(())
}

fn fit(args: &StageArgs, mut from: UnixStream, mut to: UnixStream) -> Result<()> {
    let mut fit = FitStep::new(&args.task.settings())?;
    let mut seen = Box::new(Centerlines::EMPTY);
    let mut message = Box::new(Descriptors::EMPTY);
    let mut bytes = Vec::new();
    await_next(&mut to)?;
    tell_ready(&mut from)?;
    while encoding::read(&mut from, &mut bytes)? {
        encoding::take_centerlines(&bytes, &mut seen);
        fit.fit(&seen, &mut message);
        encoding::write(&mut to, &mut bytes, |bytes| {
            encoding::put_descriptors(bytes, &message);
        })?;
    }
    Ok(())
}

fn count(args: &StageArgs, mut from: UnixStream) -> Result<()> {
    let settings = args.task.settings();
    let mut sink = SinkStep::new(&settings);
    let mut message = Box::new(Descriptors::EMPTY);
    let mut bytes = Vec::new();
    tell_ready(&mut from)?;
    while encoding::read(&mut from, &mut bytes)? {
        encoding::take_descriptors(&bytes, &mut message);
        sink.count(&message);
    }
    sink.report(&settings, FinalCounts::default())
}

/// Waits until the next stage and all later ones are ready.
fn await_next(next: &mut UnixStream) -> Result<()> {
    next.read_exact(&mut [0]).context("the next stage ended")
}

fn tell_ready(before: &mut UnixStream) -> Result<()> {
    before.write_all(&[0]).context("the stage before ended")
}
