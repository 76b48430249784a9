//! The whole chain: starts the four stages as processes, watches them, and stops them in order.
//!
//! **`lariat run --fuse`** runs capture, extract and fit as threads of the chain's own process, and sink as ever. A stage is
//! given its *supervision* (what ends it, and its status line) instead of taking it from the process: the same shells, channels,
//! status lines and order of stopping, so that nothing else differs, and whoever reads the channels sees no difference. Threads
//! rather than one loop: a frame can be made while the last is worked off, a slow stage loses frames exactly as in a process of its
//! own, and cores and priorities are a thread's anyway. What
//! separate processes cost against it, interleaved in one run: the three waits together 109 : 92 µs at 30 frames/s, 73 : 62 at
//! 120, 53 : 44 at 1000; with `--realtime` 84 : 70, 42 : 35, 33 : 24 (medians of three; 27 : 25 MB). What it gives up is that
//! a crash of one stage leaves the others to report.
//!
//! A stage that ends when it should not (by itself, by a signal that was not the chain's, by a crash) is *fallen*: the
//! others are stopped in order, the report is printed, and the exit code is 1 with a sentence that names stage and cause.
//! Children ask the kernel for SIGTERM at their parent's death (`PR_SET_PDEATHSIG`, and a look whether it has died
//! already), so that `kill -9` of the chain takes them along. A second Ctrl-C ends at once.

mod child;

use std::ffi::OsString;
use std::os::fd::AsFd;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::{Duration, Instant};

use lariat_sink::FinalCounts;
use lariat_wire::Domain;
use rustix::event::{PollFd, PollFlags, Timespec, poll};

use crate::run_files::RunFiles;
use crate::settings::{Settings, Stage};
use crate::stages;
use crate::stages::arrangement::{self, Lacks};
use crate::stages::status::LastWord;
use crate::stop::Stop;
use child::{Child, Ending, Run};

/// What the chain starts, in the order of the data. Beside the stages, if there is a recording, the recorder: it starts before
/// those that send and ends after them, so that all is in it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// Sends frames.
    Capture,
    /// Finds centerlines in them.
    Extract,
    /// Makes descriptors of those.
    Fit,
    /// Counts and times what arrives.
    Sink,
    /// Writes what the others say to a file.
    Recorder,
}

impl Part {
    const ALL: [Self; 5] = {
        use Part::{Capture, Extract, Fit, Recorder, Sink};
        [Capture, Extract, Fit, Sink, Recorder]
    };
    /// From the end to the beginning, so that every message finds its reader there. Readers of a channel are woken in the order
    /// in which they came: the sink is not to wait for the recorder.
    const START_ORDER: [Self; Self::ALL.len()] = {
        use Part::{Capture, Extract, Fit, Recorder, Sink};
        [Sink, Recorder, Fit, Extract, Capture]
    };

    /// As the command line names it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Capture => Stage::Capture.name(),
            Self::Extract => Stage::Extract.name(),
            Self::Fit => Stage::Fit.name(),
            Self::Sink => Stage::Sink.name(),
            Self::Recorder => "recorder",
        }
    }

    /// What it does as a thread of the chain's own process, if it can be one: all can but those that report on the others.
    fn fused(self) -> Option<Run> {
        match self {
            Self::Capture => Some(stages::capture::run),
            Self::Extract => Some(stages::extract::run),
            Self::Fit => Some(stages::fit::run),
            Self::Sink | Self::Recorder => None,
        }
    }

    /// Whether it is told at its end what the others sent.
    pub fn is_told_the_last_word(self) -> bool {
        match self {
            Self::Capture | Self::Extract | Self::Fit => false,
            Self::Sink | Self::Recorder => true,
        }
    }
}

/// How long a stage may take to get ready.
const START_TIMEOUT: Duration = Duration::from_secs(20);
/// How long a stage may take to end once it was told to: what waits for it is worked off first, and a picture of 48 megapixels takes
/// seconds.
const STOP_TIMEOUT: Duration = Duration::from_secs(20);
/// How long the recorder may take: as long as the disk needs for all that waits, which may be slow.
const RECORDER_STOP_TIMEOUT: Duration = Duration::from_secs(60);
/// How long one may take to be gone that was killed: what the kernel still waits for, a disk or a camera, is not waited for longer.
const KILL_TIMEOUT: Duration = Duration::from_secs(2);

/// Runs the chain until its source ends, a signal comes, or a stage dies.
///
/// `arguments` are flags of `lariat run`, for every stage, which take what concerns them.
///
/// With `fuse`, the stages up to fit are threads of this process: the same code over the same channels.
pub fn run(arguments: &[OsString], settings: Settings) -> anyhow::Result<ExitCode> {
    arrangement::check(&settings.run.arrangement)?;
    // Before anything is started: what cannot be written at the end is said now.
    let _files = RunFiles::open_all(&settings)?;
    let settings = Arc::new(settings);
    let stop = Stop::on_signals()?;
    let mut chain = Chain::default();
    let parts = Part::START_ORDER.into_iter().filter(|part| match part {
        Part::Recorder => settings.run.record.is_some(),
        // Frames are written by a process of the user's.
        Part::Capture => !settings.capture.is_external(),
        Part::Extract | Part::Fit | Part::Sink => true,
    });
    for part in parts {
        let child = match part.fused() {
            Some(run) if settings.run.fuse => Child::start_here(part, run, &settings)?,
            _ => {
                let reads = part == Part::Capture && settings.capture.is_piped();
                Child::start(part, arguments, reads)?
            }
        };
        chain.children[part as usize] = Some(child);
        if !chain.wait_until_ready(part, &stop)? {
            chain.stop_in_order(true);
            return Ok(chain.verdict());
        }
    }
    let lacks = chain
        .stages()
        .map(Child::lacks)
        .fold(Lacks::default(), Lacks::and);
    if lacks.any() {
        tracing::warn!("{lacks}");
    }
    if tracing::enabled!(tracing::Level::INFO) {
        eprintln!("{}", chain.introduce());
    }
    chain.began = true;
    chain.watch(&stop)?;
    chain.stop_in_order(false);
    Ok(chain.verdict())
}

#[derive(Default)]
struct Chain {
    children: [Option<Child>; Part::ALL.len()],
    /// The first that ended when it should not have.
    fallen: Option<Part>,
    /// All stages are up.
    began: bool,
    /// The recorder ended when it should not have, and the chain went on.
    recording_lost: bool,
}

impl Chain {
    fn stages(&self) -> impl Iterator<Item = &Child> {
        self.children.iter().flatten()
    }

    fn child(&self, part: Part) -> Option<&Child> {
        self.children[part as usize].as_ref()
    }

    fn introduce(&self) -> String {
        let name = |child: &Child| format!("{} {}", child.part.name(), child.id());
        let (stages, beside) = self.children.split_at(Part::Recorder as usize);
        let mut stages: Vec<String> = stages.iter().flatten().map(name).collect();
        if self.child(Part::Capture).is_none() {
            stages.insert(0, "external".to_owned());
        }
        let beside = beside.iter().flatten().map(name);
        let beside: String = beside.map(|name| format!(" + {name}")).collect();
        format!("lariat: {}{beside}", stages.join(" → "))
    }

    /// `false` if the chain is to end before it began.
    fn wait_until_ready(&mut self, part: Part, stop: &Stop) -> anyhow::Result<bool> {
        let begin = Instant::now();
        let deadline = begin + START_TIMEOUT;
        loop {
            self.listen(Some(deadline), Some(stop))?;
            if stop.asked() || self.fallen.is_some() {
                return Ok(false);
            }
            if self.child(part).is_some_and(Child::is_ready) {
                tracing::debug!("{} was ready after {:?}", part.name(), begin.elapsed());
                return Ok(true);
            }
            if Instant::now() >= deadline {
                eprintln!(
                    "lariat: {} was not ready after {} s",
                    part.name(),
                    START_TIMEOUT.as_secs()
                );
                self.fallen = Some(part);
                return Ok(false);
            }
        }
    }

    /// Watches until the source ends, a stage falls, or a signal comes.
    fn watch(&mut self, stop: &Stop) -> anyhow::Result<()> {
        // Without a capture of its own, the chain ends when extract has taken what was asked for.
        let source_ended = |chain: &Self| {
            let first = chain.stages().next();
            first.is_some_and(|child| child.ending().is_some())
        };
        // As after `| head`.
        let is_unread = |chain: &Self| chain.stages().any(Child::is_unread);
        while !stop.asked() && self.fallen.is_none() && !source_ended(self) && !is_unread(self) {
            self.listen(None, Some(stop))?;
        }
        Ok(())
    }

    /// Sleeps until a stage says something or ends, and takes note of it.
    fn listen(&mut self, deadline: Option<Instant>, stop: Option<&Stop>) -> anyhow::Result<()> {
        let left = deadline.map(|deadline| deadline.saturating_duration_since(Instant::now()));
        let left = left.and_then(|left| Timespec::try_from(left).ok());
        let mut descriptors: Vec<PollFd> = self
            .stages()
            .filter_map(Child::line)
            .map(|line| PollFd::from_borrowed_fd(line, PollFlags::IN))
            .collect();
        if let Some(stop) = stop {
            descriptors.push(PollFd::from_borrowed_fd(stop.as_fd(), PollFlags::IN));
        }
        match poll(&mut descriptors, left.as_ref()) {
            Ok(_) | Err(rustix::io::Errno::INTR) => {}
            Err(cause) => return Err(cause.into()),
        }
        for (part, child) in Part::ALL.into_iter().zip(&mut self.children) {
            let Some(child) = child else { continue };
            child.listen();
            match child.ending() {
                Some(Ending::Well) if child.is_done() || child.was_told_to_stop() => {}
                None if !child.was_told_by_another() => {}
                // A chain is there for its robot: without a recording it goes on.
                Some(ending) if part == Part::Recorder && self.began => {
                    if !std::mem::replace(&mut self.recording_lost, true) {
                        eprintln!("lariat: the recorder {ending}; the chain goes on without it");
                    }
                }
                // It wants no more than the word that it would be given at the end.
                None if part == Part::Recorder => child.tell(""),
                _ => {
                    self.fallen.get_or_insert(part);
                }
            }
        }
        Ok(())
    }

    /// Ends the stages from the beginning to the end, each when all before it have ended: so everything that was sent is
    /// worked off. `never`: the chain never came up, and there is nothing to report.
    fn stop_in_order(&mut self, never: bool) {
        for part in Part::ALL {
            let word = match part.is_told_the_last_word() {
                true if never => LastWord::Never.to_string(),
                true => LastWord::Counts(self.counts()).to_string(),
                false => String::new(),
            };
            if let Some(child) = &mut self.children[part as usize] {
                child.tell(&word);
                child.tell_to_stop();
            }
            self.await_end(part);
        }
    }

    /// Waits for the end of a part that was told to end; one that does not is killed.
    fn await_end(&mut self, part: Part) {
        let timeout = match part {
            Part::Recorder => RECORDER_STOP_TIMEOUT,
            Part::Capture | Part::Extract | Part::Fit | Part::Sink => STOP_TIMEOUT,
        };
        if self.ends_within(part, timeout) {
            return;
        }
        eprintln!(
            "lariat: {} did not end within {} s of being told to, and was killed",
            part.name(),
            timeout.as_secs()
        );
        self.fallen.get_or_insert(part);
        if let Some(child) = &mut self.children[part as usize] {
            child.kill();
        }
        if !self.ends_within(part, KILL_TIMEOUT) {
            eprintln!("lariat: {} could not be killed", part.name());
        }
    }

    /// Whether a part ends within a time, or is not there.
    fn ends_within(&mut self, part: Part, timeout: Duration) -> bool {
        let deadline = Instant::now() + timeout;
        let runs = |chain: &Self| {
            let child = chain.child(part);
            child.is_some_and(|child| child.ending().is_none())
        };
        while runs(self) {
            if Instant::now() >= deadline || self.listen(Some(deadline), None).is_err() {
                return false;
            }
        }
        true
    }

    /// What each stage said it sent in all. Of frames from elsewhere, extract knows what capture would.
    fn counts(&self) -> FinalCounts {
        let sent = |part| self.child(part).and_then(Child::sent);
        let extract = self.child(Part::Extract);
        let taken = extract.and_then(Child::taken);
        let of_source = taken.map(|taken| taken.last).or(sent(Part::Capture));
        FinalCounts {
            before_first: taken.map(|taken| taken.before_first),
            last_sequence: of_source.map(|sent| sent.last_sequence),
            captured: of_source.map(|sent| sent.count),
            extracted: sent(Part::Extract).map(|sent| sent.count),
            fitted: sent(Part::Fit).map(|sent| sent.count),
            masks_late: extract.and_then(Child::masks_late),
        }
    }

    /// How it went. Sweeps up after a stage that was killed.
    fn verdict(&self) -> ExitCode {
        if self.fallen.is_none() && !self.recording_lost {
            return ExitCode::SUCCESS;
        }
        if let Ok(domain) = Domain::open() {
            domain.sweep();
        }
        let fallen = self.fallen.and_then(|part| self.child(part));
        if let Some(fallen) = fallen
            && let Some(ending) = fallen.ending()
            // What fails in its turn at the end has stopped nothing, and what did not end has been said.
            && !(fallen.was_told_to_stop() && matches!(ending, Ending::Failed(_)))
            && !fallen.was_given_up()
        {
            eprintln!(
                "lariat: {} {ending}; the chain was stopped",
                fallen.part.name()
            );
        }
        ExitCode::FAILURE
    }
}
