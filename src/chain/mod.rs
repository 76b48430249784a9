//! The whole chain: starts the four stages as processes, watches them, and stops them in order.

mod child;

use std::ffi::OsString;
use std::os::fd::AsFd;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::{Duration, Instant};

use lariat_wire::Domain;
use rustix::event::{PollFd, PollFlags, Timespec, poll};

use crate::run_files::RunFiles;
use crate::settings::{STAGES, Settings};
use crate::stages;
use crate::stages::arrangement::{self, Lacks};
use crate::stop::Stop;
use child::{Child, Ending, Stage};

/// Those that can be threads of the chain's own process: all but the one that reports on them.
const FUSED: [Stage; 3] = [stages::capture::run, stages::extract::run, stages::fit::run];
const CAPTURE: usize = 0;
const EXTRACT: usize = 1;
const FIT: usize = 2;
const SINK: usize = 3;
/// Beside the stages, if there is a recording: it starts before those that send and ends after them, so that all is in it.
const RECORDER: usize = 4;
const CHILDREN: [&str; 5] = [STAGES[0], STAGES[1], STAGES[2], STAGES[3], "recorder"];
/// From the end to the beginning, so that every message finds its reader there. Readers of a channel are woken in the order
/// in which they came: the sink is not to wait for the recorder.
const START_ORDER: [usize; CHILDREN.len()] = [SINK, RECORDER, FIT, EXTRACT, CAPTURE];

/// How long a stage may take to get ready.
const START_TIMEOUT: Duration = Duration::from_secs(20);
/// How long a stage may take to end once it was told to: what waits for it is worked off first.
const STOP_TIMEOUT: Duration = Duration::from_secs(20);

/// How long the recorder may take: as long as the disk needs for all that waits, which may be slow.
const RECORDER_STOP_TIMEOUT: Duration = Duration::from_secs(60);

/// Runs the chain until its source ends, a signal comes, or a stage dies.
///
/// `arguments` are flags of `lariat run`, for every stage, which take what concerns them.
///
/// With `fuse`, the stages up to fit are threads of this process: the same code over the same channels.
pub(crate) fn run(arguments: &[OsString], settings: Settings) -> anyhow::Result<ExitCode> {
    arrangement::check(&settings.run.arrangement)?;
    // Before anything is started: what cannot be written at the end is said now.
    let _files = RunFiles::open_all(&settings)?;
    let settings = Arc::new(settings);
    let stop = Stop::on_signals()?;
    let mut chain = Chain::default();
    let places = START_ORDER.iter().filter(|&&place| match place {
        RECORDER => settings.run.record.is_some(),
        // Frames are written by a process of the user's.
        CAPTURE => !settings.capture.is_external(),
        _ => true,
    });
    for &place in places {
        let stage = CHILDREN[place];
        let child = match FUSED.get(place) {
            Some(run) if settings.run.fuse => Child::start_here(stage, *run, &settings)?,
            _ => {
                let reads = place == CAPTURE && settings.capture.is_piped();
                Child::start(stage, arguments, reads)?
            }
        };
        chain.children[place] = Some(child);
        if !chain.wait_until_ready(place, &stop)? {
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
    children: [Option<Child>; CHILDREN.len()],
    /// The first that ended when it should not have.
    fallen: Option<usize>,
    /// All stages are up.
    began: bool,
    /// The recorder ended when it should not have, and the chain went on.
    recording_lost: bool,
}

impl Chain {
    fn stages(&self) -> impl Iterator<Item = &Child> {
        self.children.iter().flatten()
    }

    fn introduce(&self) -> String {
        let name = |child: &Child| format!("{} {}", child.stage, child.id());
        let (stages, beside) = self.children.split_at(RECORDER);
        let mut stages: Vec<String> = stages.iter().flatten().map(name).collect();
        if self.children[CAPTURE].is_none() {
            stages.insert(0, "external".to_owned());
        }
        let beside = beside.iter().flatten().map(name);
        let beside: String = beside.map(|name| format!(" + {name}")).collect();
        format!("lariat: {}{beside}", stages.join(" → "))
    }

    /// `false` if the chain is to end before it began.
    fn wait_until_ready(&mut self, place: usize, stop: &Stop) -> anyhow::Result<bool> {
        let begin = Instant::now();
        let deadline = begin + START_TIMEOUT;
        loop {
            self.listen(Some(deadline), Some(stop))?;
            if stop.asked() || self.fallen.is_some() {
                return Ok(false);
            }
            if self.children[place].as_ref().is_some_and(Child::is_ready) {
                tracing::debug!("{} was ready after {:?}", CHILDREN[place], begin.elapsed());
                return Ok(true);
            }
            if Instant::now() >= deadline {
                eprintln!(
                    "lariat: {} was not ready after {} s",
                    CHILDREN[place],
                    START_TIMEOUT.as_secs()
                );
                self.fallen = Some(place);
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
        for (place, child) in self.children.iter_mut().enumerate() {
            let Some(child) = child else { continue };
            child.listen();
            match child.ending() {
                Some(Ending::Well) if child.is_done() || child.was_told_to_stop() => {}
                None if !child.was_told_by_another() => {}
                // A chain is there for its robot: without a recording it goes on.
                Some(ending) if place == RECORDER && self.began => {
                    if !std::mem::replace(&mut self.recording_lost, true) {
                        eprintln!("lariat: the recorder {ending}; the chain goes on without it");
                    }
                }
                // It wants no more than the word that it would be given at the end.
                None if place == RECORDER => child.tell(""),
                _ => {
                    self.fallen.get_or_insert(place);
                }
            }
        }
        Ok(())
    }

    /// Ends the stages from the beginning to the end, each when all before it have ended: so everything that was sent is
    /// worked off. `never`: the chain never came up, and there is nothing to report.
    fn stop_in_order(&mut self, never: bool) {
        for place in 0..CHILDREN.len() {
            let word = match place {
                SINK | RECORDER if never => "never\n".into(),
                SINK | RECORDER => self.counts(),
                _ => String::new(),
            };
            if let Some(child) = &mut self.children[place] {
                child.tell(&word);
                child.tell_to_stop();
            }
            let timeout = if place == RECORDER {
                RECORDER_STOP_TIMEOUT
            } else {
                STOP_TIMEOUT
            };
            let deadline = Instant::now() + timeout;
            while self.children[place]
                .as_ref()
                .is_some_and(|child| child.ending().is_none())
            {
                if Instant::now() >= deadline || self.listen(Some(deadline), None).is_err() {
                    let Some(child) = &mut self.children[place] else {
                        break;
                    };
                    eprintln!("lariat: {} did not end and was killed", child.stage);
                    child.kill();
                    self.fallen.get_or_insert(place);
                }
            }
        }
    }

    /// What each stage said it sent in all.
    fn counts(&self) -> String {
        let mut word = String::new();
        for (name, child) in ["captured", "extracted", "fitted"]
            .iter()
            .zip(&self.children)
        {
            if let Some(sent) = child.as_ref().and_then(Child::sent) {
                word += &format!("{name} {}\n", sent.count);
            }
        }
        if let Some(late) = self.children[EXTRACT].as_ref().and_then(Child::masks_late) {
            word += &format!("late {late}\n");
        }
        if let Some(sent) = self.children[CAPTURE].as_ref().and_then(Child::sent) {
            word += &format!("sequence {}\n", sent.last_sequence);
        }
        if let Some(taken) = self.children[EXTRACT].as_ref().and_then(Child::taken) {
            let ([sequence, captured], last) = (taken.before_first, taken.last);
            word += &format!("before {sequence} {captured}\ncaptured {}\n", last.count);
            word += &format!("sequence {}\n", last.last_sequence);
        }
        word
    }

    /// How it went. Sweeps up after a stage that was killed.
    fn verdict(&self) -> ExitCode {
        if self.fallen.is_none() && !self.recording_lost {
            return ExitCode::SUCCESS;
        }
        if let Ok(domain) = Domain::open() {
            domain.sweep();
        }
        let fallen = self
            .fallen
            .and_then(|fallen| self.children[fallen].as_ref());
        if let Some(fallen) = fallen
            && let Some(ending) = fallen.ending()
            // What fails in its turn at the end has stopped nothing.
            && !(fallen.was_told_to_stop() && matches!(ending, Ending::Failed(_)))
        {
            eprintln!("lariat: {} {ending}; the chain was stopped", fallen.stage);
        }
        ExitCode::FAILURE
    }
}
