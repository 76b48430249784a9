//! The whole chain: starts the stages as processes, supervises them, and stops them in order.
//!
//! **`lariat run --fuse`** runs capture, extract and fit as threads of the chain's own process; the
//! sink remains a process. A stage receives its *supervision* (stop flag and status line) as an
//! argument instead of taking it from the process. Stages, channels, status lines and the order of
//! stopping are the same, so readers of the channels notice no difference. Separate threads keep
//! the behavior of processes: the next frame is made while the last one is processed, and a slow
//! stage loses the same frames. Cores and priorities belong to threads in any case. Waits between
//! stages are shorter than between processes. The price: a crash of one stage ends the others
//! before they can report.
//!
//! A stage is *fallen* if it ends unexpectedly: by itself, by a signal from elsewhere, or by a
//! crash. The setting `restart` decides what follows (`restarts`). Either the stage restarts while
//! the other stages and all readers keep running, or the chain stops in order. It then prints its
//! report and exits with 1 and a sentence that names stage and cause. The chain keeps a handover
//! state for each stage (`stages/handover/`), so that counts, track numbers and figures survive a
//! restart. From this state the chain also detects a stage that makes no progress while work waits
//! for it, and kills it.
//!
//! **Changes of settings** arrive through the socket of `lariat set` (`changes`, `control.rs`) or
//! from the settings file (`--watch`). They are checked as a whole and sent to all parts
//! (`stages/orders.rs`). Extract and fit apply their changes between two frames; other changes
//! restart a stage. If that stage does not become ready, the previous settings apply again.
//!
//! The chain keeps all other state in its children, which end with it. Starting a new chain is
//! faster than taking over running stages would be.
//!
//! Children ask the kernel to send them SIGTERM when their parent dies (`PR_SET_PDEATHSIG`), and
//! check whether it has died already. Therefore `kill -9` of the chain ends them, too. A second
//! Ctrl-C, at least 0.1 s after the first, ends the chain at once.

mod changes;
mod child;
mod hanging;
mod occupied;
mod part;
mod restarts;
mod status_notifier;
mod stopping;
mod watch;

use std::ffi::OsString;
use std::os::fd::AsFd;
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::Context;
use rustix::event::{PollFd, PollFlags, Timespec, poll};

use crate::control::Control;
use crate::itself;
use crate::messages::Relay;
use crate::run_files::RunFiles;
use crate::settings::{Flags, Settings};
use crate::stages::arrangement::{self, Lacks};
use crate::stages::extract_handover;
use crate::stages::handover::{Handover, Progress};
use crate::stages::status::LastWord;
use crate::stop::Stop;
use changes::Trial;
use child::{Child, Ending};
use hanging::Watched;
pub use part::Part;
use restarts::{Restarts, Verdict};
use status_notifier::{Signs, StatusNotifier};
use watch::Watch;

/// Interval at which the chain checks whether a stage makes progress.
const LOOK_EVERY: Duration = Duration::from_secs(1);

/// Runs the chain until its source ends, a signal arrives, or a stage falls and is not restarted.
///
/// `flags` are those of `lariat run`. They go to every stage together with `words`, and each stage
/// uses what concerns it. `settings` are the settings that result from them.
///
/// With `fuse`, the stages up to fit are threads of this process. They run the same code over the
/// same channels.
///
/// `stop` has recorded signals since the process began, so a signal that arrives during the start
/// also stops the chain in order.
pub fn run(
    flags: &Flags,
    words: &[OsString],
    settings: Settings,
    stop: &Stop,
) -> anyhow::Result<ExitCode> {
    arrangement::check(&settings.run.arrangement)?;
    let _relay = Relay::start().context("the messages of the stages cannot be relayed")?;
    occupied::check(&settings, parts(&settings))?;
    // Open the files before anything starts, so that a file that cannot be written is reported now.
    let _files = RunFiles::open_all(&settings)?;
    let mut chain = Chain::new(flags, words, settings)?;
    for part in parts(&chain.settings) {
        if stop.asked() {
            chain.stop_in_order(true);
            return Ok(chain.verdict());
        }
        chain.start(part)?;
        if !chain.wait_until_ready(part, stop)? {
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
    chain.begin();
    chain.watch(stop)?;
    chain.stop_in_order(false);
    Ok(chain.verdict())
}

/// Returns the parts that a chain starts, in the order of starting.
fn parts(settings: &Settings) -> impl Iterator<Item = Part> + use<> {
    let has_recorder = settings.run.record.is_some();
    let is_external = settings.capture.is_external();
    Part::START_ORDER
        .into_iter()
        .filter(move |part| match part {
            Part::Recorder => has_recorder,
            // An external process writes the frames.
            Part::Capture => !is_external,
            Part::Extract | Part::Fit | Part::Sink => true,
        })
}

struct Chain {
    flags: Flags,
    arguments: Vec<OsString>,
    settings: Arc<Settings>,
    children: [Option<Child>; Part::ALL.len()],
    handovers: [Handover; Part::ALL.len()],
    restarts: Restarts,
    /// When a fallen part is restarted.
    due: [Option<Instant>; Part::ALL.len()],
    /// Parts that were told to end so that they restart.
    renewed: [bool; Part::ALL.len()],
    watched: [Watched; Part::ALL.len()],
    /// Time at which the chain was complete.
    began: Option<Instant>,
    control: Option<Control>,
    file: Option<Watch>,
    /// The change of settings that is being tried.
    trial: Option<Trial>,
    /// Set once the user was warned that the executable was replaced.
    is_outdated: bool,
    status_notifier: StatusNotifier,
    /// The first part that fell and was not restarted.
    fallen: Option<Part>,
    /// True if nothing is restarted any more.
    is_stopping: bool,
    /// True if the recorder fell and the chain continues without it.
    recording_lost: bool,
}

impl Chain {
    fn new(flags: &Flags, words: &[OsString], settings: Settings) -> anyhow::Result<Self> {
        let watched = Watched {
            progress: Progress::default(),
            since: Instant::now(),
        };
        let mut handovers: [Handover; Part::ALL.len()] = Default::default();
        for part in Part::ALL {
            handovers[part as usize] = Handover::make(part.name())?;
        }
        Ok(Self {
            flags: flags.clone(),
            arguments: [&flags.words(), words].concat(),
            settings: Arc::new(settings),
            children: Default::default(),
            handovers,
            restarts: Restarts::default(),
            due: Default::default(),
            renewed: Default::default(),
            watched: [watched; Part::ALL.len()],
            began: None,
            control: None,
            file: None,
            trial: None,
            is_outdated: false,
            status_notifier: StatusNotifier::new(),
            fallen: None,
            is_stopping: false,
            recording_lost: false,
        })
    }

    /// Starts a part, for the first time or again.
    fn start(&mut self, part: Part) -> anyhow::Result<()> {
        let settings = &self.settings;
        let handover = &self.handovers[part as usize];
        let restarts = handover.progress().restarts;
        let child = match part.fused() {
            Some(run) if settings.run.fuse => Child::start_here(part, run, settings, handover)?,
            _ => {
                let reads = part == Part::Capture && settings.capture.is_piped();
                let is_changed = restarts > 0 || settings.version > 0;
                let changed = is_changed.then(|| self.settings_of(part, restarts).text());
                Child::start(part, &self.arguments, reads, handover, changed.as_deref())?
            }
        };
        self.children[part as usize] = Some(child);
        self.watched[part as usize] = Watched {
            progress: handover.read(),
            since: Instant::now(),
        };
        Ok(())
    }

    /// Returns the settings for a part that is restarted.
    fn settings_of(&self, part: Part, restarts: u64) -> Settings {
        let mut settings = Settings::clone(&self.settings);
        let run = &mut settings.run;
        match part {
            // Keep the predecessor's file; continue in a new one.
            Part::Recorder => {
                run.record = run
                    .record
                    .as_deref()
                    .map(|file| numbered(file, restarts + 1));
            }
            Part::Capture => {
                let ran = self.began.map_or(Duration::ZERO, |began| began.elapsed());
                run.duration = run.duration.map(|lasts| lasts.saturating_sub(ran));
            }
            Part::Extract | Part::Fit | Part::Sink => {}
        }
        settings
    }

    /// Accepts requests from now on, because all parts are running.
    fn begin(&mut self) {
        self.began = Some(Instant::now());
        self.listen_to_others();
        self.status_notifier.ready();
        if self.settings.run.watch {
            match Watch::of(self.settings.file.as_deref()) {
                Ok(watch) => self.file = Some(watch),
                Err(cause) => {
                    tracing::warn!("changes of the settings file are not seen: {cause:#}")
                }
            }
        }
    }

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

    /// Waits until a part is ready. Returns `false` if the chain is to end before that.
    fn wait_until_ready(&mut self, part: Part, stop: &Stop) -> anyhow::Result<bool> {
        let begin = Instant::now();
        let limit = self.settings.run.start_limit;
        let deadline = begin + limit;
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
                    "lariat: {} was not ready after {} s (start_limit_s)",
                    part.name(),
                    limit.as_secs_f64()
                );
                self.fallen = Some(part);
                return Ok(false);
            }
        }
    }

    /// Supervises the chain until the source ends, a stage falls and is not restarted, or a signal
    /// arrives.
    fn watch(&mut self, stop: &Stop) -> anyhow::Result<()> {
        // Without a capture stage, the chain ends when extract has received all frames that were
        // requested.
        let source_ended = |chain: &Self| {
            let first = chain.stages().next();
            first.is_some_and(|child| {
                child.ending().is_some() && chain.due[child.part as usize].is_none()
            })
        };
        // Nobody reads the output any more, for example after `| head`.
        let is_unread = |chain: &Self| chain.stages().any(Child::is_unread);
        while !stop.asked() && self.fallen.is_none() && !source_ended(self) && !is_unread(self) {
            let look = self.settings.run.restarts_stages().then_some(LOOK_EVERY);
            let look = look.into_iter().chain(self.status_notifier.wait()).min();
            let look = look.map(|look| Instant::now() + look);
            let trial = self.trial.as_ref().map(|trial| trial.until);
            let due = self
                .due
                .into_iter()
                .flatten()
                .chain(look)
                .chain(trial)
                .min();
            self.listen(due, Some(stop))?;
            self.start_those_due();
            self.strike_the_hanging();
            self.judge_trial();
            self.answer_others();
            self.read_the_file();
            self.say_how_it_is();
        }
        Ok(())
    }

    /// Sleeps until a stage reports something or ends, and handles it.
    fn listen(&mut self, deadline: Option<Instant>, stop: Option<&Stop>) -> anyhow::Result<()> {
        // Other requests wait until the current change has been tried.
        let control = self.control.as_ref();
        let control = control.filter(|_| stop.is_some() && self.trial.is_none());
        let deadline = deadline
            .into_iter()
            .chain(control.and_then(Control::deadline))
            .min();
        let left = deadline.map(|deadline| deadline.saturating_duration_since(Instant::now()));
        let left = left.and_then(|left| Timespec::try_from(left).ok());
        let others = [
            stop.map(AsFd::as_fd),
            self.file
                .as_ref()
                .filter(|_| stop.is_some() && self.trial.is_none())
                .map(AsFd::as_fd),
        ];
        let mut descriptors: Vec<PollFd> = self
            .stages()
            .filter_map(Child::line)
            .chain(others.into_iter().flatten())
            .chain(control.into_iter().flat_map(Control::descriptors))
            .map(|line| PollFd::from_borrowed_fd(line, PollFlags::IN))
            .collect();
        match poll(&mut descriptors, left.as_ref()) {
            Ok(_) | Err(rustix::io::Errno::INTR) => {}
            Err(cause) => return Err(cause.into()),
        }
        for part in Part::ALL {
            self.take_note(part);
        }
        Ok(())
    }

    /// Reads what a part reports, and checks whether it fell.
    fn take_note(&mut self, part: Part) {
        let at = part as usize;
        let Some(child) = &mut self.children[at] else {
            return;
        };
        child.listen();
        let (ending, is_done) = (child.ending(), child.is_done());
        let is_wished = match ending {
            Some(Ending::Well) => is_done || child.was_told_to_stop(),
            // The signal arrived before the handler was registered.
            Some(Ending::Killed(15)) => child.was_told_to_stop() && !child.is_ready(),
            Some(_) => false,
            None => !child.was_told_by_another(),
        };
        let is_over = part == Part::Recorder && self.recording_lost;
        if self.due[at].is_some() || is_over || ending.is_none() && is_wished {
            return;
        }
        if self.is_stopping || self.began.is_none() {
            if !is_wished {
                self.give_up(part, ending);
            }
            return;
        }
        if ending.is_none() && self.settings.run.restarts_stages() {
            // Another process told this part to end. It waits for the last word, which the chain
            // would otherwise send at its own end.
            if let Some(child) = &mut self.children[at] {
                child.tell(&LastWord::Never.to_string());
            }
            return;
        }
        if ending.is_some() && std::mem::take(&mut self.renewed[at]) {
            self.due[at] = Some(Instant::now());
            return;
        }
        if self.is_tried_in_vain(part) {
            self.take_back();
            return;
        }
        let how = ending.map_or_else(String::new, |ending| ending.to_string());
        let reason = self.child(part).map(Child::reason).unwrap_or_default();
        match self.judge(part, ending, is_done, &how, &reason) {
            Verdict::Restart(_) => {}
            Verdict::End if is_wished => {}
            Verdict::End | Verdict::TooMany(_) => self.give_up(part, ending),
        }
    }

    /// Decides whether a fallen part restarts. Reports how it fell on standard error, and the
    /// reason to the service manager.
    fn judge(
        &mut self,
        part: Part,
        ending: Option<Ending>,
        is_done: bool,
        how: &str,
        reason: &str,
    ) -> Verdict {
        let (run, now) = (&self.settings.run, Instant::now());
        let verdict = self.restarts.judge(run, ending, is_done, now);
        let name = part.name();
        match verdict {
            Verdict::Restart(due) => {
                self.due[part as usize] = Some(due);
                let when = match due.saturating_duration_since(now).as_secs_f64() {
                    0.0 => String::new(),
                    pause_s => format!(" in {pause_s} s"),
                };
                eprintln!("lariat: {name} {how}; it is restarted{when}");
                self.status_notifier
                    .trouble(&format!("{name} fell: {reason}"));
            }
            Verdict::TooMany(count) => {
                let window_s = run.restart_window.as_secs_f64();
                eprintln!(
                    "lariat: {count} parts were restarted within {window_s} s (max_restarts): no more"
                );
            }
            Verdict::End => {}
        }
        verdict
    }

    /// Handles a part that has fallen and is not restarted.
    fn give_up(&mut self, part: Part, ending: Option<Ending>) {
        match ending {
            // The robot needs the chain, so it continues without a recording.
            Some(ending) if part == Part::Recorder && self.began.is_some() => {
                if !std::mem::replace(&mut self.recording_lost, true) {
                    eprintln!("lariat: the recorder {ending}; the chain continues without it");
                }
            }
            // The recorder only waits for the last word that the chain sends at the end.
            None if part == Part::Recorder => {
                if let Some(recorder) = &mut self.children[part as usize] {
                    recorder.tell("");
                }
            }
            _ => {
                self.fallen.get_or_insert(part);
            }
        }
    }

    /// Starts the parts that are due.
    fn start_those_due(&mut self) {
        for part in Part::ALL {
            if self.due[part as usize].is_some_and(|due| due <= Instant::now()) {
                if itself::is_replaced() && !std::mem::replace(&mut self.is_outdated, true) {
                    eprintln!(
                        "lariat: the executable was replaced or removed: stages keep restarting from the running version until \
                         you restart the chain"
                    );
                }
                match self.restart(part) {
                    Ok(()) => self.listen_to_others(),
                    Err(cause) => self.judge_failed_start(part, &cause),
                }
            }
        }
    }

    /// Treats a process that could not be started like any other fault.
    fn judge_failed_start(&mut self, part: Part, cause: &anyhow::Error) {
        let ending = Some(Ending::Failed(1));
        let how = format!("could not be started: {}", cause.root_cause());
        if !matches!(
            self.judge(part, ending, false, &how, &how),
            Verdict::Restart(_)
        ) {
            eprintln!("lariat: {cause:#}");
            self.give_up(part, ending);
        }
    }

    fn restart(&mut self, part: Part) -> anyhow::Result<()> {
        self.due[part as usize] = None;
        self.handovers[part as usize].count_restart();
        self.start(part)
    }

    /// Reports the chain's state to the service manager, if there is one.
    fn say_how_it_is(&mut self) {
        let [capture, extract, fit] =
            [Part::Capture, Part::Extract, Part::Fit].map(|part| part as usize);
        let mut signs = Signs {
            fitted: self.handovers[fit].read().sent.count,
            beats: self.handovers[capture].read().beats,
        };
        if self.children[capture].is_none() {
            // Frames from an external program have no fixed rate.
            signs.beats = self.began.map_or(0, |began| began.elapsed().as_secs());
        }
        let extract = &self.handovers[extract];
        self.status_notifier.tell(signs, Instant::now(), || {
            extract_handover::ropes_seen(extract)
        });
    }
}

/// Returns the name of the file that a restarted recorder writes: `run.mcap`, `run-2.mcap`,
/// `run-3.mcap`.
fn numbered(file: &Path, number: u64) -> std::path::PathBuf {
    if file == Path::new("-") {
        return file.to_owned();
    }
    let mut name = file.file_stem().unwrap_or_default().to_owned();
    name.push(format!("-{number}"));
    if let Some(extension) = file.extension() {
        name.push(".");
        name.push(extension);
    }
    file.with_file_name(name)
}
