//! `lariat topic`: inspects the channels of a rig from a terminal.
//!
//! An inspecting command is one more reader. A reader that is woken costs the writer a notification
//! of 5 to 20 µs for each message. Therefore only two commands are woken: `echo`, which prints each
//! message when it arrives, and `delay --in-hand`, which measures the time until a message arrives.
//! All others use the stamps and counters in the messages, which are the same whenever they are
//! read, and poll before a buffer can overflow ([`poll_interval`]). A `--lossless` chain is the
//! exception: it waits until each reader has opened its end, and from then on for the slowest one.
//! There, all readers are woken, and the commands say so.
//!
//! # How it works
//!
//! `lariat topic` and `lariat top` are readers like any other and take one of a channel's places.
//! The polling commands do not slow down the chain. (By `strace -c`, fit makes one `sendto` per
//! message with sink alone, with `hz` and with `top`, but two with `echo`.) Rates, intervals,
//! losses and the times of the steps come from stamps and counters alone, with the ledger and the
//! steps of `crates/sink`. `hz` and `bw` poll before a buffer is full, at a rate that follows the
//! channel's rate (`topic/poll_interval`). `top` takes the waiting messages ten times a second. At
//! a high rate it gets only part of them, which costs nothing but samples for percentiles. Messages
//! that were sent but not read by the command are counted separately (`here`).
//!
//! An open reader keeps its channel as it is. A reader that only inspects therefore leaves when the
//! writer leaves, and returns with the next one. Otherwise a chain that is restarted with
//! `--lossless`, or from another release, would be refused.
//!
//! The processes at the ends of a channel come from the transport's own tables (`Domain::channels`,
//! `crates/wire/src/survey.rs`). Each channel is opened only for the duration of the survey, by a
//! node without a port, and nothing new is created. A channel of another release is recognized by
//! its type names alone.
//!
//! A process that is killed while it creates a channel leaves it half made. The transport would
//! wait for its completion forever. Processes of lariat therefore create and open channels one at a
//! time, under a lock on the domain's folder that ends with its owner
//! (`crates/wire/src/making.rs`). The owner of the lock removes half-made channels.
//!
//! A domain's shared memory is left over (`lariat doctor`, `crates/wire/src/leftovers.rs`) under
//! four conditions. Its folder is on this machine, no lock in the folder is held, and no process
//! has the memory mapped. None of the memory was created in the last two seconds, because a process
//! creates its first file before its lock is visible. Each condition alone can be wrong: a
//! container that shares only `/dev/shm` has no locks, and another user's mappings cannot be read.
//! `--clean` also removes the folders of empty domains, because another user could not use a domain
//! of that name. It also removes what older releases left in `/tmp/iceoryx2`.

mod bandwidth;
mod delay;
mod echo;
mod list;
mod poll_interval;
mod probe;
mod rate;
mod watch;

use std::process::ExitCode;
use std::time::Duration;

use anyhow::{Context, Result, bail};
use clap::{Args, Subcommand, ValueEnum};
use lariat_wire::{ChannelState, Domain, Rig};

use lariat_chain::exit::wrong_use;
use lariat_chain::layout::{self, Column, Table};
use lariat_chain::settings::duration;

/// Inspect the channels of a running chain
#[derive(Debug, Args)]
pub(crate) struct TopicArgs {
    #[command(subcommand)]
    command: TopicCommand,
}

#[derive(Debug, Subcommand)]
enum TopicCommand {
    /// List rigs and their channels: writer, readers, messages, shared memory
    List(ListArgs),
    /// Measure rate, jitter and losses
    Hz(MeterArgs),
    /// Print messages, without pixels
    Echo(EchoArgs),
    /// Measure the latency of frames, step by step
    Delay(DelayArgs),
    /// Measure megabytes per second
    Bw(MeterArgs),
}

#[derive(Debug, Args)]
struct ListArgs {
    /// Only this camera chain
    #[arg(long, value_name = "NAME")]
    rig: Option<Rig>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// Arguments of the commands that measure a channel.
#[derive(Debug, Args)]
struct MeterArgs {
    /// The channel
    #[arg(value_enum, default_value_t = ChannelName::Descriptors)]
    channel: ChannelName,
    #[command(flatten)]
    common: CommonArgs,
}

#[derive(Debug, Args)]
struct CommonArgs {
    /// Camera chain (default: `default`, or the only one there is)
    #[arg(long, value_name = "NAME")]
    rig: Option<Rig>,
    /// Wait for the chain if it is not running yet
    #[arg(long)]
    wait: bool,
    /// Print JSON objects, one per line
    #[arg(long)]
    json: bool,
    /// Measure for this long (10s, 2m), print once, and end
    #[arg(long, value_name = "TIME", value_parser = duration::parse)]
    duration: Option<Duration>,
}

#[derive(Debug, Args)]
struct DelayArgs {
    /// Also measure until a reader has the message; costs the chain a wake-up per frame
    #[arg(long)]
    in_hand: bool,
    #[command(flatten)]
    common: CommonArgs,
}

#[derive(Debug, Args)]
struct EchoArgs {
    /// The channel
    #[arg(value_enum, default_value_t = ChannelName::Descriptors)]
    channel: ChannelName,
    /// Print one message and end
    #[arg(long, conflicts_with = "count")]
    once: bool,
    /// Print this many messages and end
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    count: Option<u64>,
    #[command(flatten)]
    common: CommonArgs,
}

/// A channel, by its name on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ChannelName {
    Frames,
    Masks,
    Depth,
    Centerlines,
    Descriptors,
    Descriptors3,
    Truth,
    Truth3,
}

impl ChannelName {
    fn as_str(self) -> &'static str {
        match self {
            Self::Frames => lariat_wire::FRAMES.name(),
            Self::Masks => lariat_wire::MASKS.name(),
            Self::Depth => lariat_wire::DEPTH.name(),
            Self::Centerlines => lariat_wire::CENTERLINES.name(),
            Self::Descriptors => lariat_wire::DESCRIPTORS.name(),
            Self::Descriptors3 => lariat_wire::DESCRIPTORS3.name(),
            Self::Truth => lariat_wire::TRUTH.name(),
            Self::Truth3 => lariat_wire::TRUTH3.name(),
        }
    }
}

/// Runs `lariat topic`.
///
/// # Errors
/// Returns an error if the requested rig or channel does not exist, or cannot be read.
pub(crate) fn run(args: TopicArgs) -> Result<ExitCode> {
    match args.command {
        TopicCommand::List(args) => list::run(&args),
        TopicCommand::Hz(args) => {
            let meter = rate::Rate::new(args.channel);
            watch::run(
                &Place::find(&args.common, args.channel)?,
                &args.common,
                meter,
            )
        }
        TopicCommand::Bw(args) => {
            let meter = bandwidth::Bandwidth::new(args.channel);
            watch::run(
                &Place::find(&args.common, args.channel)?,
                &args.common,
                meter,
            )
        }
        TopicCommand::Delay(args) => {
            let place = Place::find(&args.common, ChannelName::Descriptors)?;
            watch::run(&place, &args.common, delay::Delay::new(args.in_hand))
        }
        TopicCommand::Echo(args) => {
            let place = Place::find(&args.common, args.channel)?;
            let most = if args.once { Some(1) } else { args.count };
            watch::run(
                &place,
                &args.common,
                echo::Echo::new(args.channel, args.common.json, most),
            )
        }
    }
}

/// The inspected channel.
struct Place {
    domain: Domain,
    rig: Rig,
    channel: ChannelName,
}

impl Place {
    /// Finds the channel on the requested rig; fails if there is no such rig.
    fn find(args: &CommonArgs, channel: ChannelName) -> Result<Self> {
        let domain = Domain::open()?;
        if args.wait {
            let rig = args.rig.clone().unwrap_or_default();
            return Ok(Self {
                domain,
                rig,
                channel,
            });
        }
        let states = domain.channels()?;
        let rig = choose_rig(args.rig.clone(), &states)?;
        let on_rig = states.iter().filter(|state| state.rig == rig);
        let names: Vec<&str> = on_rig.map(|state| state.channel).collect();
        if !names.contains(&channel.as_str()) {
            bail!(
                "rig {rig} has no channel {}, only {}{}",
                channel.as_str(),
                names.join(", "),
                match channel {
                    ChannelName::Masks => " (masks are there with the setting mask = \"external\")",
                    ChannelName::Truth => " (only of a rendered rope the true shape is known)",
                    ChannelName::Truth3 => " (only of a lifted simulated rope it is known)",
                    _ => ": is the whole chain running (`lariat run`)?",
                }
            );
        }
        Ok(Self {
            domain,
            rig,
            channel,
        })
    }

    /// Current state of the channel; `None` if nobody has it open.
    fn state(&self) -> Option<ChannelState> {
        self.domain.channel(&self.rig, self.channel.as_str())
    }
}

/// Chooses the rig: the requested one, the default one, or the only one.
fn choose_rig(wanted: Option<Rig>, states: &[ChannelState]) -> Result<Rig> {
    let mut rigs: Vec<&Rig> = states.iter().map(|state| &state.rig).collect();
    rigs.dedup();
    let names = || -> String {
        let names: Vec<&str> = rigs.iter().map(|rig| rig.as_str()).collect();
        names.join(", ")
    };
    match wanted {
        _ if rigs.is_empty() => Err(nothing_runs(", or wait for it with --wait")),
        Some(rig) if rigs.contains(&&rig) => Ok(rig),
        Some(rig) => bail!("there is no rig {rig} here: there is {}", names()),
        None if rigs.contains(&&Rig::default()) => Ok(Rig::default()),
        None => match rigs.as_slice() {
            [only] => Ok((*only).clone()),
            _ => wrong_use!("say which rig with --rig NAME: there is {}", names()),
        },
    }
}

/// A table of figures that grows by one line a second.
struct Titled {
    table: Table,
    is_titled: bool,
}

impl Titled {
    fn new<const N: usize>(headings: [&str; N]) -> Self {
        // Width of a figure.
        let columns = headings.map(|heading| Column::figures(heading).wide(5));
        Self {
            table: Table::new(columns.into(), layout::width()),
            is_titled: false,
        }
    }

    /// Formats a line, preceded by the headings the first time.
    fn lines(&mut self, cells: impl IntoIterator<Item = String>) -> String {
        let row = self.table.row(cells);
        match std::mem::replace(&mut self.is_titled, true) {
            true => row,
            false => self.table.head() + &row,
        }
    }
}

/// Error for the case that no rig is visible.
fn nothing_runs(hint: &str) -> anyhow::Error {
    let domain = match std::env::var("LARIAT_DOMAIN") {
        Ok(name) => format!(" in the domain {name}, which LARIAT_DOMAIN names"),
        Err(_) => String::new(),
    };
    anyhow::anyhow!(
        "no chain is running{domain}: start one with `lariat run`{}{}",
        hint,
        if domain.is_empty() {
            " (one that another user started is seen by that user only, and one with LARIAT_DOMAIN with the same \
             LARIAT_DOMAIN)"
        } else {
            ""
        }
    )
}

/// Adds a hint to an error of the wire: where to find the readers that occupy the channel.
fn with_a_hint<T>(result: Result<T, lariat_wire::WireError>) -> Result<T> {
    match result {
        Err(full @ lariat_wire::WireError::TooManyReaders { .. }) => {
            Err(full).context("there is no room to look in (`lariat topic list` says who reads)")
        }
        other => Ok(other?),
    }
}

#[cfg(test)]
mod tests;
