//! The floor of the chain: four processes that only forward 64 bytes through bare iceoryx2.

use std::fs;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use crate::bare::{RelayReceiver, RelaySender};
use anyhow::{Context, Result};
use lariat_capture::{Pace, Pacer};
use lariat_sink::Times;
use lariat_wire::{Domain, now_ns};

use super::figures::Outcome;
use super::guard::{Guarded, Placement, end_all};
use super::workplace::Workplace;
use lariat_chain::stages::arrangement::precise_timer;
use lariat_chain::stop::Stop;

/// Number of processes in the row.
const PROCESSES: usize = 4;
/// Messages that are not counted, while connections are made and caches fill.
const WARM_UP: u64 = 20;
/// Interval at which a sleeping receiver checks whether it must end.
const LOOK_UP: Duration = Duration::from_millis(100);

/// Cores and scheduling of the processes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Arrangement {
    /// Placed by the kernel.
    Free,
    /// All on one core.
    OneCore { fifo: bool },
    /// Each on the next core, round-robin.
    Spread { fifo: bool },
}

impl Arrangement {
    pub(super) const ALL: [Self; 5] = [
        Self::Free,
        Self::OneCore { fifo: false },
        Self::Spread { fifo: false },
        Self::OneCore { fifo: true },
        Self::Spread { fifo: true },
    ];

    pub(super) fn id(self) -> &'static str {
        match self {
            Self::Free => "free",
            Self::OneCore { fifo: false } => "one_core",
            Self::OneCore { fifo: true } => "one_core_fifo",
            Self::Spread { fifo: false } => "spread",
            Self::Spread { fifo: true } => "spread_fifo",
        }
    }

    pub(super) fn title(self) -> &'static str {
        match self {
            Self::Free => "free",
            Self::OneCore { fifo: false } => "one core",
            Self::OneCore { fifo: true } => "one core, FIFO",
            Self::Spread { fifo: false } => "spread",
            Self::Spread { fifo: true } => "spread, FIFO",
        }
    }

    pub(super) fn is_fifo(self) -> bool {
        matches!(
            self,
            Self::OneCore { fifo: true } | Self::Spread { fifo: true }
        )
    }

    fn placement(self, place: usize, cores: &[usize]) -> Placement {
        let core = match self {
            Self::Free => None,
            Self::OneCore { .. } => cores.last().copied(),
            Self::Spread { .. } => cores.get(place % cores.len().max(1)).copied(),
        };
        Placement {
            core,
            fifo: self.is_fifo(),
        }
    }
}

/// Forwards messages at this rate for this long.
pub(super) fn measure(
    workplace: &Workplace,
    arrangement: Arrangement,
    fps: f64,
    time: Duration,
) -> Result<Outcome> {
    let count = (time.as_secs_f64() * fps).ceil().max(10.0) as u64;
    let out = workplace.path("relay");
    let mut programs = Vec::new();
    for place in (0..PROCESSES).rev() {
        let mut command = workplace.part(arrangement.placement(place, &workplace.cores), "relay");
        command.arg("--place").arg(place.to_string());
        command.arg("--fps").arg(fps.to_string());
        command.arg("--count").arg(count.to_string());
        command.arg("--out").arg(&out);
        programs.push(Guarded::start(&mut command)?);
    }
    let last = programs.remove(0);
    let within = time * 2 + Duration::from_secs(10);
    let finished = workplace.finish(last, within, "four processes of 64 bytes");
    end_all(programs);
    finished?;
    let read = |name: &str| {
        let path = workplace.path(name);
        let text = fs::read_to_string(&path).unwrap_or_default();
        let _ = fs::remove_file(path);
        Times::from_hgrm(&text).context("the processes of 64 bytes left no figures")
    };
    let mut outcome = Outcome::of_times(read("relay.due")?);
    let sent = read("relay.sent")?;
    outcome.add_percentiles([("sent_p50_us", 0.5), ("sent_p99_us", 0.99)], &sent);
    Ok(outcome)
}

/// Arguments of `latency-part relay`.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct RelayArgs {
    /// Position of the process among the four, from 0
    #[arg(long)]
    place: usize,
    /// Messages per second
    #[arg(long)]
    fps: f64,
    /// Number of messages that are timed
    #[arg(long)]
    count: u64,
    /// Files that the times are written to: FILE.due and FILE.sent
    #[arg(long)]
    out: PathBuf,
}

/// Runs one of the four processes.
pub(super) fn run(args: &RelayArgs) -> Result<()> {
    let stop = Stop::on_signals()?;
    let domain = Domain::open()?;
    match args.place {
        0 => send(args, &domain, &stop),
        place if place + 1 < PROCESSES => pass_on(place, &domain, &stop),
        place => receive(args, place, &domain, &stop),
    }
}

/// Sends on schedule until it is asked to stop, without waiting for the other processes to start.
fn send(args: &RelayArgs, domain: &Domain, stop: &Stop) -> Result<()> {
    let sender = RelaySender::create(domain, 0)?;
    let mut pacer = Pacer::new(Pace::Fps(args.fps))?;
    precise_timer();
    loop {
        let due_ns = pacer.next_due_ns(now_ns());
        if !stop.sleep_until(due_ns) {
            return Ok(());
        }
        sender.send([due_ns, now_ns(), 0, 0, 0, 0, 0, 0])?;
    }
}

fn pass_on(place: usize, domain: &Domain, stop: &Stop) -> Result<()> {
    let receiver = RelayReceiver::create(domain, place - 1)?;
    let sender = RelaySender::create(domain, place)?;
    while !stop.asked() {
        if let Some(message) = receiver.next(LOOK_UP)? {
            sender.send(message)?;
        }
    }
    Ok(())
}

fn receive(args: &RelayArgs, place: usize, domain: &Domain, stop: &Stop) -> Result<()> {
    let receiver = RelayReceiver::create(domain, place - 1)?;
    let (mut due, mut sent) = (Times::default(), Times::default());
    let mut received = 0;
    let give_up = Instant::now() + Duration::from_secs_f64(args.count as f64 / args.fps + 30.0);
    while received < WARM_UP + args.count && !stop.asked() {
        anyhow::ensure!(Instant::now() < give_up, "nothing arrives any more");
        let Some([due_ns, sent_ns, ..]) = receiver.next(LOOK_UP)? else {
            continue;
        };
        let now_ns = now_ns();
        received += 1;
        if received > WARM_UP {
            due.add(now_ns.saturating_sub(due_ns));
            sent.add(now_ns.saturating_sub(sent_ns));
        }
    }
    for (times, what) in [(due, "due"), (sent, "sent")] {
        let path = args.out.with_extension(what);
        let mut text = Vec::new();
        times.write_hgrm(&mut text)?;
        fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))?;
    }
    Ok(())
}
