//! `lariat-top`, the program that `lariat top` runs: a running chain, live on a terminal.
//!
//! [`Gatherer`] of `lariat_view` collects the data into a plain [`View`](lariat_view::View). The
//! drawing code ([`draw`]) is independent of the terminal, and [`screen`] handles the terminal. Ten
//! times a second, the program reads the waiting descriptors without being woken, so that it costs
//! the chain nothing. Time stamps and counters give rates, losses and latencies even if only some
//! of the messages are read.

mod draw;
mod screen;

use std::io::IsTerminal;
use std::os::fd::AsFd;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use anyhow::{Result, bail};
use clap::Parser;
use lariat_chain::stop::Stop;
use lariat_view::Gatherer;
use lariat_wire::{Domain, Rig, now_ns};
use screen::{Key, Screen};

/// Show a running chain live on the terminal: stages, latency, losses, the ropes
#[derive(Debug, Parser)]
#[command(name = "lariat top", bin_name = "lariat top", version)]
struct Args {
    /// Camera chain to begin with (default: `default`, or the first one found); r or Tab goes to the next
    #[arg(long, value_name = "NAME")]
    rig: Option<Rig>,
}

/// Interval between two pictures.
const TICK: Duration = Duration::from_millis(100);

fn main() -> ExitCode {
    match run(&Args::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("lariat top: {error:#}");
            lariat_chain::exit::code(&error)
        }
    }
}

/// Runs until q, Ctrl-C or SIGTERM.
fn run(args: &Args) -> Result<()> {
    if !std::io::stdout().is_terminal() {
        bail!(
            "lariat top draws on a terminal, and standard output is not a terminal: for scripts and logs there are `lariat topic hz`, \
             `delay` and `echo` with --json"
        );
    }
    let stop = Stop::on_signals()?;
    let domain = Domain::open()?;
    let mut gatherer = Gatherer::new(&domain, args.rig.clone());
    let mut screen = Screen::enter()?;
    let mut is_paused = false;
    let mut view = gatherer.view(now_ns());
    let mut due = Instant::now();
    while !stop.asked() {
        gatherer.look(now_ns());
        if !is_paused {
            view = gatherer.view(now_ns());
        }
        view.is_paused = is_paused;
        screen.draw(|frame| draw::draw(frame, &view))?;
        due = (due + TICK).max(Instant::now());
        while let Some(key) = wait(&mut screen, &mut gatherer, due, &stop)? {
            match key {
                Key::Quit => return Ok(()),
                Key::Pause => is_paused = !is_paused,
                Key::NextRig => {
                    gatherer.next_rig();
                    is_paused = false;
                }
                Key::Longer => gatherer.longer(),
                Key::Shorter => gatherer.shorter(),
                Key::Redraw => {}
            }
            // Show the effect of a key at once.
            due = Instant::now();
        }
    }
    Ok(())
}

/// Waits for the next key until a deadline, and returns `None` when it has passed. Meanwhile, a
/// lossless chain is read.
fn wait(
    screen: &mut Screen,
    gatherer: &mut Gatherer,
    until: Instant,
    stop: &Stop,
) -> Result<Option<Key>> {
    if gatherer.must_keep_up() {
        while gatherer.must_keep_up() && Instant::now() < until && !stop.asked() {
            gatherer.keep_up(until, Some(stop.as_fd()));
        }
        return screen.key(Instant::now(), stop);
    }
    screen.key(until, stop)
}
