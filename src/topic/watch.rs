//! Follows a channel across restarts of the chain, until the requested end or the end of the pipe.

use std::io;
use std::os::fd::AsFd;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use anyhow::Result;
use lariat_wire::Rig;
use rustix::event::{PollFd, PollFlags, Timespec, poll};

use super::probe::{Any, Probe, sleep_for};
use super::{CommonArgs, Place};
use lariat_chain::output::print;
use lariat_chain::stop::Stop;

/// Interval between checks that the writer still exists and that somebody still reads the output.
const CHECK: Duration = Duration::from_millis(500);
/// Interval between searches for a missing writer.
const SEARCH: Duration = Duration::from_millis(100);

/// Evaluates the messages of a channel.
pub(super) trait Meter {
    /// Returns whether each message is to be received at once, although its writer then has to wake
    /// this process.
    fn is_woken(&self) -> bool;
    /// Period of [`report`](Self::report); `None` for one report at the end.
    fn period(&self) -> Option<Duration>;
    /// Takes a message that was received at this time of `CLOCK_MONOTONIC`. The returned text is
    /// printed.
    fn see(&mut self, message: Any, now_ns: u64) -> Result<String>;
    /// Returns whether enough messages have been read.
    fn is_done(&self) -> bool {
        false
    }
    /// Returns the text to print when a report is due, and at the end.
    fn report(&mut self, rig: &Rig, json: bool) -> Result<String>;
}

/// Passes messages to the meter until a signal, its duration or the end of the pipe.
pub(super) fn run(place: &Place, args: &CommonArgs, mut meter: impl Meter) -> Result<ExitCode> {
    let stop = Stop::on_signals()?;
    let end = args.duration.map(|time| Instant::now() + time);
    let period = meter.period().filter(|_| args.duration.is_none());
    let mut due = period.map(|period| Instant::now() + period);
    let mut link = Link::new(place);
    while !stop.asked() && !meter.is_done() && end.is_none_or(|end| Instant::now() < end) {
        if let Some(probe) = link.probe(&meter)? {
            let mut text = String::new();
            // Messages are read in batches, so that reports and signals get their turn however fast
            // messages come.
            for _ in 0..64 {
                match probe.next(|message, now_ns| meter.see(message, now_ns))? {
                    Some(seen) => text += &seen?,
                    None => break,
                }
                if meter.is_done() {
                    break;
                }
            }
            print(&text)?;
        }
        if let (Some(at), Some(period)) = (due, period)
            && Instant::now() >= at
        {
            due = Some((at + period).max(Instant::now()));
            print(&meter.report(&place.rig, args.json)?)?;
        }
        if link.is_check_due() && !is_read() {
            return Ok(ExitCode::SUCCESS);
        }
        if meter.is_done() {
            break;
        }
        let until = [end, due].into_iter().flatten().min();
        link.sleep(until, &stop)?;
    }
    print(&meter.report(&place.rig, args.json)?)?;
    Ok(ExitCode::SUCCESS)
}

/// A reader that exists as long as there is a writer.
///
/// A reader that stays after the writer has gone would keep the channel as it was. A chain
/// restarted with another delivery, or from another release, would be refused. The reader therefore
/// leaves with the writer and returns with the next one.
struct Link<'p> {
    place: &'p Place,
    probe: Option<Probe>,
    checked: Option<Instant>,
    said: bool,
}

impl<'p> Link<'p> {
    fn new(place: &'p Place) -> Self {
        Self {
            place,
            probe: None,
            checked: None,
            said: false,
        }
    }

    fn is_check_due(&self) -> bool {
        self.probe.is_none() || self.checked.is_none_or(|at| at.elapsed() >= CHECK)
    }

    /// Returns the reader, if there is a writer.
    fn probe(&mut self, meter: &impl Meter) -> Result<Option<&mut Probe>> {
        if !self.is_check_due() {
            return Ok(self.probe.as_mut());
        }
        self.checked = Some(Instant::now());
        let state = self.place.state();
        let is_written = state.as_ref().is_some_and(|state| {
            // The channel has another version; opening it reports that.
            state.ends.as_ref().is_none_or(|ends| ends.writer.is_some())
        });
        match state {
            Some(state) if is_written => {
                if self.probe.is_none() {
                    if state.lossless {
                        eprintln!(
                            "lariat: rig {} is --lossless: it waits for this reader too",
                            self.place.rig
                        );
                    }
                    let woken = meter.is_woken() || state.lossless;
                    self.probe = Some(Probe::open(self.place, woken, state.buffer)?);
                    self.said = false;
                }
            }
            _ => {
                self.probe = None;
                if !self.said {
                    self.said = true;
                    eprintln!(
                        "lariat: nothing writes {} on rig {}; waiting for it",
                        self.place.channel.as_str(),
                        self.place.rig
                    );
                }
            }
        }
        Ok(self.probe.as_mut())
    }

    fn sleep(&mut self, until: Option<Instant>, stop: &Stop) -> Result<()> {
        let now = Instant::now();
        match &mut self.probe {
            Some(probe) => {
                let check = self.checked.unwrap_or(now) + CHECK;
                probe.sleep(until.map_or(check, |until| until.min(check)), stop)?;
            }
            None => {
                let left = until.map_or(SEARCH, |until| until.saturating_duration_since(now));
                sleep_for(left.min(SEARCH), stop);
            }
        }
        Ok(())
    }
}

/// Returns whether standard output still has a reader.
fn is_read() -> bool {
    let out = io::stdout();
    let mut polled = [PollFd::from_borrowed_fd(out.as_fd(), PollFlags::empty())];
    let at_once = Timespec::default();
    match poll(&mut polled, Some(&at_once)) {
        Ok(_) => !polled[0].revents().contains(PollFlags::ERR),
        Err(_) => true,
    }
}
