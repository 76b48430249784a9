//! Sink as a process: reads what the chain made, counts it, and says how it went.
//!
//! It may be killed: of what it knows its files have what was 10 s before, whole (`keeper`), and a chain that keeps a file
//! for it (`handover`) can start another, which goes on where it stopped.

pub(crate) mod handover;
mod keeper;

use std::fmt;
use std::io::{self, ErrorKind, IsTerminal, Write};
use std::os::fd::AsFd;
use std::time::{Duration, Instant};

use anyhow::Context;
use lariat_sink::{FinalCounts, Machine, Receipt, Report, Sink};
use lariat_wire::{CENTERLINES, Centerlines, DESCRIPTORS, Receiver, TRUTH, now_ns, sleep_for_any};

use super::handover::Handover;
use super::status::{LastWord, Sent, Word};
use super::{Station, Supervision};
use crate::layout;
use crate::messages;
use crate::run_files::RunFiles;
use crate::settings::{Settings, Stage};
use handover::HandoverWriter;
use keeper::Keeper;

/// How often the live line is renewed in place on a terminal.
const ON_TERMINAL: Duration = Duration::from_millis(100);
/// How often it is written elsewhere.
const ELSEWHERE: Duration = Duration::from_secs(1);

/// Counts until a signal comes, then reports.
pub fn run(settings: &Settings, supervision: Supervision) -> anyhow::Result<()> {
    // Before this process is kept to some of the cores.
    let machine = Machine::this();
    let is_successor = handover::is_inherited(&supervision.handover);
    let files = match is_successor {
        false => RunFiles::open(settings)?,
        true => RunFiles::reopen(settings)?,
    };
    let mut station = Station::open(settings, Stage::Sink, supervision)?;
    // A change for sink restarts it.
    let changes = station.listen(settings, |_, _| Ok(None::<()>))?;
    let supervised = station.status.is_supervised();
    // Frames from elsewhere may have begun long before the chain.
    let from_start = supervised && !settings.capture.is_external();
    let options = settings.sink_options(from_start);
    let mut sink = Sink::of(handover::tally(&station.handover, options));
    let mut line = LiveLine::new(settings.sink.live, files.take_stdout());
    let mut checkpoints = Checkpoints::new(&sink, files, &station.handover, machine.clone())?;
    let channels = Channels::open(&station)?;
    station.ready()?;
    let mut rest = station.rest();
    // A chain ends its sink itself, when all before it has ended.
    let run = Some(&settings.run).filter(|_| !supervised);
    let end = run.and_then(|run| Some(Instant::now() + run.duration?));
    let most = run.and_then(|run| run.frames).unwrap_or(u64::MAX);
    let (mut frames, mut taken) = (0, 0);
    loop {
        // That nobody reads it any more is the wish that it end: the chain ends in order.
        let last_look = station.stop.asked()
            || (line.unread && !supervised)
            || end.is_some_and(|end| Instant::now() >= end);
        station.change(&changes);
        let came = channels.drain(&mut sink, most - frames, |receipt| {
            taken = receipt.fitted();
            checkpoints.take(receipt);
        })?;
        if came > 0 {
            line.has_news();
            station.handover.note(Sent::default(), taken);
            checkpoints.save_counts(&sink);
        }
        checkpoints.hand_over_if_due(&sink);
        frames += came;
        if last_look || frames >= most {
            break;
        }
        let was_read = !line.unread;
        line.show_if_due(&mut sink);
        if was_read && line.unread {
            station.status.say(Word::Unread);
        }
        rest.if_due(now_ns());
        let due = [line.due(), checkpoints.due(), end]
            .into_iter()
            .flatten()
            .min();
        rest.while_waiting(|| channels.sleep(due, &station))?;
    }
    if line.wanted && line.in_place {
        line.say(format_args!("\n"));
    }
    // If the signal was not the chain's, the chain learns of it here, and gives its word all the same.
    station.status.say(Word::Ending);
    let files = checkpoints.end()?;
    let counts = match supervised.then(LastWord::of_the_chain) {
        None => FinalCounts::default(),
        Some(LastWord::Counts(counts)) => counts,
        // There is nothing to report.
        Some(LastWord::Never) => return Ok(()),
    };
    sink.finish(counts);
    let report = sink.report_on(machine);
    let said = line.end(&report);
    files.write(&report)?;
    said
}

/// How many bytes there may be of what was counted.
const MOST_COUNTS: usize = 4 << 10;

/// What is kept of what the sink knows, in case that it is killed.
struct Checkpoints {
    files: Option<RunFiles>,
    keeper: Option<Keeper>,
    /// Where a successor finds what was counted.
    counts: Option<HandoverWriter>,
}

impl Checkpoints {
    /// # Errors
    /// There is no thread to be had.
    fn new(
        sink: &Sink,
        files: RunFiles,
        handover: &Handover,
        machine: Machine,
    ) -> anyhow::Result<Self> {
        let counts = handover.state();
        let tally = handover.tally().map(|turns| HandoverWriter::new(turns, 0));
        let mut checkpoints = Self {
            files: None,
            keeper: None,
            counts: counts.map(|turns| HandoverWriter::new(turns, MOST_COUNTS)),
        };
        if tally.is_some() || files.can_be_renewed() {
            checkpoints.keeper = Some(Keeper::start(sink, files, tally, machine)?);
        } else {
            checkpoints.files = Some(files);
        }
        checkpoints.save_counts(sink);
        Ok(checkpoints)
    }

    fn take(&mut self, receipt: Receipt) {
        if let Some(keeper) = &mut self.keeper {
            keeper.take(receipt);
        }
    }

    /// Writes what was counted. Messages of which it is not written are lost with the sink.
    fn save_counts(&mut self, sink: &Sink) {
        if let Some(counts) = &mut self.counts
            && let Err(cause) = counts.write(|into| sink.tally().save_counts(into))
        {
            self.counts = None;
            tracing::warn!("what sink counts would not survive it, as it cannot be kept: {cause}");
        }
    }

    fn hand_over_if_due(&mut self, sink: &Sink) {
        if let Some(keeper) = &mut self.keeper {
            keeper.hand_over_if_due(sink);
        }
    }

    fn due(&self) -> Option<Instant> {
        self.keeper.as_ref().and_then(Keeper::due)
    }

    /// Keeps no more. Returns the files, for the last word.
    ///
    /// # Errors
    /// The report's thread panicked.
    fn end(self) -> anyhow::Result<RunFiles> {
        match (self.keeper, self.files) {
            (Some(keeper), _) => keeper.end(),
            (None, files) => Ok(files.expect("files that no thread has are here")),
        }
    }
}

/// The three channels that a sink reads.
struct Channels {
    descriptors: Receiver<lariat_wire::Descriptors>,
    centerlines: Receiver<Centerlines>,
    truth: Receiver<Centerlines>,
    lossless: bool,
}

impl Channels {
    fn open(station: &Station) -> anyhow::Result<Self> {
        let Station {
            domain,
            rig,
            delivery,
            ..
        } = station;
        let lossless = matches!(delivery, lariat_wire::Delivery::Lossless { .. });
        // Every frame ends in a descriptor, and one wake a frame is enough. But a lossless writer waits for each of
        // its readers, so there the sink listens to all.
        let open = |channel| {
            if lossless {
                Receiver::create(domain, rig, channel, Some(delivery))
            } else {
                Receiver::create_unwoken(domain, rig, channel, Some(delivery))
            }
        };
        Ok(Self {
            descriptors: station.reader(&DESCRIPTORS)?,
            centerlines: open(&CENTERLINES)?,
            truth: open(&TRUTH)?,
            lossless,
        })
    }

    /// Takes in all that waits, of descriptors at most so many, and hands on what was counted of each; returns how many of them
    /// there were.
    fn drain(
        &self,
        sink: &mut Sink,
        most: u64,
        mut counted: impl FnMut(Receipt),
    ) -> anyhow::Result<u64> {
        let mut came = 0;
        while came < most
            && let Some(message) = self.descriptors.next()?
        {
            counted(sink.descriptors(&message, now_ns()));
            came += 1;
        }
        while let Some(message) = self.centerlines.next()? {
            sink.centerlines(&message);
        }
        while let Some(message) = self.truth.next()? {
            sink.truth(&message);
        }
        Ok(came)
    }

    fn sleep(&self, deadline: Option<Instant>, station: &Station) -> anyhow::Result<()> {
        let stop = Some(station.stop.as_fd());
        if self.lossless {
            sleep_for_any(
                [&self.descriptors, &self.centerlines, &self.truth],
                deadline,
                stop,
            )?;
        } else {
            self.descriptors.sleep(deadline, stop)?;
        }
        Ok(())
    }
}

/// What is said while it runs and at its end: a line of figures, in place on a terminal, a line a second elsewhere; the report.
struct LiveLine {
    wanted: bool,
    in_place: bool,
    /// Standard output is one of the files.
    on_stderr: bool,
    due: Instant,
    /// How often it was shown since a message came.
    stale: u32,
    /// Nobody reads it any more.
    unread: bool,
    /// Why something could not be written. A full disk under its log does not stop a robot's chain.
    fault: Option<io::Error>,
}

impl LiveLine {
    fn new(wanted: bool, on_stderr: bool) -> Self {
        let in_place = if on_stderr {
            messages::is_terminal()
        } else {
            io::stdout().is_terminal()
        };
        if wanted && in_place {
            messages::expect_live_line();
        }
        Self {
            wanted,
            in_place,
            on_stderr,
            due: Instant::now() + ELSEWHERE,
            stale: 0,
            unread: false,
            fault: None,
        }
    }

    /// Something to show has come.
    fn has_news(&mut self) {
        self.stale = 0;
    }

    /// When it is to be renewed. Without frames it soon says so, and then there is nothing to say until one comes.
    fn due(&self) -> Option<Instant> {
        // Its figures are of the last second: two seconds on, they are of no frame.
        let is_stale = self.interval() * self.stale > 2 * ELSEWHERE;
        (self.wanted && !is_stale && !self.unread).then_some(self.due)
    }

    fn interval(&self) -> Duration {
        if self.in_place {
            ON_TERMINAL
        } else {
            ELSEWHERE
        }
    }

    fn show_if_due(&mut self, sink: &mut Sink) {
        let now = Instant::now();
        if self.due().is_none_or(|due| now < due) {
            return;
        }
        self.stale = self.stale.saturating_add(1);
        self.due = now + self.interval();
        let line = sink.live_line(now_ns());
        if self.in_place {
            // A line that is wider than the terminal could not be written over.
            let columns = layout::width().saturating_sub(1);
            let shown: String = line.chars().take(columns).collect();
            self.say(format_args!("\r{shown}\x1b[K"));
        } else {
            self.say(format_args!("{line}\n"));
        }
    }

    fn say(&mut self, text: fmt::Arguments) {
        // In one piece, so that no message of another process comes between.
        let text = text.to_string();
        if self.on_stderr {
            messages::show(&text);
            return;
        }
        let mut out = io::stdout().lock();
        match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
            Ok(()) => {}
            Err(cause) => {
                self.unread |= cause.kind() == ErrorKind::BrokenPipe;
                self.fault.get_or_insert(cause);
            }
        }
    }

    /// Says the last word.
    ///
    /// # Errors
    /// Something could not be written, now or before.
    fn end(mut self, report: &Report) -> anyhow::Result<()> {
        self.say(format_args!("{report}\n"));
        match self.fault {
            Some(cause) => Err(cause).context("cannot write the report to standard output"),
            None => Ok(()),
        }
    }
}
