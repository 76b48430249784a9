//! The sink process: reads the output of the chain, counts it, and reports.
//!
//! The sink may be killed. Its files then contain a complete state that is at most 10 s old
//! (`keeper`). A chain that holds its handover state (`handover`) can start another sink, which
//! continues where it stopped.

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

/// Interval at which the live line is updated in place on a terminal.
const ON_TERMINAL: Duration = Duration::from_millis(100);
/// Interval at which the live line is written elsewhere.
const ELSEWHERE: Duration = Duration::from_secs(1);

/// Counts until a signal arrives, then reports.
pub fn run(settings: &Settings, supervision: Supervision) -> anyhow::Result<()> {
    // Read this before the process is restricted to some of the cores.
    let machine = Machine::this();
    let is_successor = handover::is_inherited(&supervision.handover);
    let files = match is_successor {
        false => RunFiles::open(settings)?,
        true => RunFiles::reopen(settings)?,
    };
    let mut station = Station::open(settings, Stage::Sink, supervision)?;
    // A change of the sink's settings restarts it.
    let changes = station.listen(settings, |_, _| Ok(None::<()>))?;
    let supervised = station.status.is_supervised();
    // An external writer may have started long before the chain.
    let from_start = supervised && !settings.capture.is_external();
    let options = settings.sink_options(from_start);
    let mut sink = Sink::of(handover::tally(&station.handover, options));
    let mut line = LiveLine::new(settings.sink.live, files.take_stdout());
    let mut checkpoints = Checkpoints::new(&sink, files, &station.handover, machine.clone())?;
    let channels = Channels::open(&station)?;
    station.ready()?;
    let mut rest = station.rest();
    // A chain ends its sink when all stages before it have ended.
    let run = Some(&settings.run).filter(|_| !supervised);
    let end = run.and_then(|run| Some(Instant::now() + run.duration?));
    let most = run.and_then(|run| run.frames).unwrap_or(u64::MAX);
    let (mut frames, mut taken) = (0, 0);
    loop {
        // If nobody reads the live line any more, the sink ends, or its chain ends in order.
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
    // If the chain did not send the signal, it learns of the end here and still sends its last
    // word.
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

/// Capacity for the counts, in bytes.
const MOST_COUNTS: usize = 4 << 10;

/// Saves the sink's state in case it is killed.
struct Checkpoints {
    files: Option<RunFiles>,
    keeper: Option<Keeper>,
    /// Memory for the counts, which a successor continues.
    counts: Option<HandoverWriter>,
}

impl Checkpoints {
    /// Starts to save the state of a sink.
    ///
    /// # Errors
    /// Returns an error if the thread cannot be started.
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

    /// Saves the counts. Messages that are not saved are lost if the sink is killed.
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

    /// Stops saving, and returns the files for the final report.
    ///
    /// # Errors
    /// Returns an error if the report's thread panicked.
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
        // Every frame ends in a descriptor, so one wake per frame is enough. A lossless writer,
        // however, waits for each of its readers, so the sink then listens to all channels.
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

    /// Processes all waiting messages, but at most `most` descriptors. Passes the receipt of each
    /// descriptor to `counted` and returns their number.
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

/// The output of the sink: the live line and the final report. The live line is updated in place on
/// a terminal; elsewhere a line is written every second.
struct LiveLine {
    wanted: bool,
    in_place: bool,
    /// True if one of the files goes to standard output.
    on_stderr: bool,
    due: Instant,
    /// Number of times that the line was shown since the last message.
    stale: u32,
    /// True if nobody reads the output any more.
    unread: bool,
    /// The first write error. A full disk for the log must not stop a robot's chain.
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

    /// Notes that a message has arrived.
    fn has_news(&mut self) {
        self.stale = 0;
    }

    /// Returns when to update the line. After frames stop, the line is updated until its figures
    /// are empty. The next frame starts the updates again.
    fn due(&self) -> Option<Instant> {
        // The line's figures cover the last second, so two seconds without a frame leave them
        // empty.
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
            // A line wider than the terminal could not be overwritten.
            let columns = layout::width().saturating_sub(1);
            let shown: String = line.chars().take(columns).collect();
            self.say(format_args!("\r{shown}\x1b[K"));
        } else {
            self.say(format_args!("{line}\n"));
        }
    }

    fn say(&mut self, text: fmt::Arguments) {
        // Write the text as a whole, so that no message of another process comes in between.
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

    /// Prints the report.
    ///
    /// # Errors Returns an error if anything could not be written, now or earlier.
    fn end(mut self, report: &Report) -> anyhow::Result<()> {
        self.say(format_args!("{report}\n"));
        match self.fault {
            Some(cause) => Err(cause).context("cannot write the report to standard output"),
            None => Ok(()),
        }
    }
}
