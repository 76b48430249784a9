//! The whole chain: starts the four stages as processes, watches them, and stops them in order.
//!
//! **`lariat run --fuse`** runs capture, extract and fit as threads of the chain's own process, and sink as ever. A stage is
//! given its *supervision* (what ends it, and its status line) instead of taking it from the process: the same shells, channels,
//! status lines and order of stopping, so that nothing else differs, and whoever reads the channels sees no difference. Threads
//! rather than one loop: a frame can be made while the last is worked off, a slow stage loses frames exactly as in a process of its
//! own, and cores and priorities are a thread's anyway. The three
//! waits of separate processes and of threads, interleaved in one run, sum up to 109 : 92 µs at 30 frames/s, 73 : 62 at
//! 120, 53 : 44 at 1000; with `--realtime` 84 : 70, 42 : 35, 33 : 24 (medians of three; 27 : 25 MB). Its price: a
//! crash of one stage ends the others before they can report.
//!
//! A stage is *fallen* if it ends unexpectedly: by itself, by a signal from elsewhere, or by a crash. The setting `restart` decides
//! (`restarts`): the stage restarts while the other stages and all readers keep running, or the chain stops in order, prints its
//! report, and exits with 1 and a sentence that names stage and cause. The chain keeps a handover state for each stage
//! (`stages/handover/`), so that counts, track numbers and figures survive a restart. From this state the chain also detects a stage that
//! makes no progress while work waits for it, and kills it.
//!
//! **Changes of settings** arrive through the socket of `lariat set` (`changes`, `control.rs`) or from the settings file (`--watch`). They are
//! checked as a whole and sent to all parts (`stages/orders.rs`). Extract and fit apply theirs between two frames; other changes restart a
//! stage. If that stage does not become ready, the previous settings apply again.
//!
//! The chain keeps all other state in its children, which end with it. A new chain is ready after a quarter of a second, which is faster than
//! it could take over running stages.
//!
//! Children ask the kernel for SIGTERM at their parent's death (`PR_SET_PDEATHSIG`, and a look whether it has died
//! already), so that `kill -9` of the chain takes them along. A second Ctrl-C, 0.1 s later or more, ends at once.

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

/// How often the chain looks whether a stage stands still.
const LOOK_EVERY: Duration = Duration::from_secs(1);

/// Runs the chain until its source ends, a signal comes, or a stage falls for good.
///
/// `flags` are those of `lariat run`, which with `words` go to every stage, which takes what concerns it; `settings` are theirs.
///
/// With `fuse`, the stages up to fit are threads of this process: the same code over the same channels.
///
/// `stop` listens to signals since the process began, so that one that comes before the chain is up ends it in order, too.
pub fn run(
    flags: &Flags,
    words: &[OsString],
    settings: Settings,
    stop: &Stop,
) -> anyhow::Result<ExitCode> {
    arrangement::check(&settings.run.arrangement)?;
    let _relay = Relay::start().context("the messages of the stages cannot be relayed")?;
    occupied::check(&settings, parts(&settings))?;
    // Before anything is started: what cannot be written at the end is said now.
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

/// The parts that a chain starts, in this order.
fn parts(settings: &Settings) -> impl Iterator<Item = Part> + use<> {
    let has_recorder = settings.run.record.is_some();
    let is_external = settings.capture.is_external();
    Part::START_ORDER
        .into_iter()
        .filter(move |part| match part {
            Part::Recorder => has_recorder,
            // Frames are written by a process of the user's.
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
    /// When a part that fell is restarted.
    due: [Option<Instant>; Part::ALL.len()],
    /// Those that were told to end, to be restarted.
    renewed: [bool; Part::ALL.len()],
    watched: [Watched; Part::ALL.len()],
    /// When the chain was up.
    began: Option<Instant>,
    control: Option<Control>,
    file: Option<Watch>,
    /// Settings that are being tried.
    trial: Option<Trial>,
    /// Set once the user was warned that the executable was replaced.
    is_outdated: bool,
    status_notifier: StatusNotifier,
    /// The first that ended when it should not have, for good.
    fallen: Option<Part>,
    /// Nothing is restarted any more.
    is_stopping: bool,
    /// The recorder ended when it should not have, and the chain went on.
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

    /// The settings of a part that is restarted.
    fn settings_of(&self, part: Part, restarts: u64) -> Settings {
        let mut settings = Settings::clone(&self.settings);
        let run = &mut settings.run;
        match part {
            // What its predecessor wrote stays.
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

    /// All parts are up: from now on the chain can be told what to do.
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

    /// `false` if the chain is to end before it began.
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

    /// Watches until the source ends, a stage falls for good, or a signal comes.
    fn watch(&mut self, stop: &Stop) -> anyhow::Result<()> {
        // Without a capture of its own, the chain ends when extract has taken what was asked for.
        let source_ended = |chain: &Self| {
            let first = chain.stages().next();
            first.is_some_and(|child| {
                child.ending().is_some() && chain.due[child.part as usize].is_none()
            })
        };
        // As after `| head`.
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

    /// Sleeps until a stage says something or ends, and takes note of it.
    fn listen(&mut self, deadline: Option<Instant>, stop: Option<&Stop>) -> anyhow::Result<()> {
        // Others wait until a change has been tried.
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

    /// Hears what a part says, and sees whether it fell.
    fn take_note(&mut self, part: Part) {
        let at = part as usize;
        let Some(child) = &mut self.children[at] else {
            return;
        };
        child.listen();
        let (ending, is_done) = (child.ending(), child.is_done());
        let is_wished = match ending {
            Some(Ending::Well) => is_done || child.was_told_to_stop(),
            // The signal reached it before its handler was registered.
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
            // Told to end by another: it waits for the word that it would be given at the end.
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

    /// Decides whether a part that fell restarts, and reports it: on standard error how it fell, to the service manager the reason.
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

    /// A part has fallen for good.
    fn give_up(&mut self, part: Part, ending: Option<Ending>) {
        match ending {
            // A chain is there for its robot: without a recording it goes on.
            Some(ending) if part == Part::Recorder && self.began.is_some() => {
                if !std::mem::replace(&mut self.recording_lost, true) {
                    eprintln!("lariat: the recorder {ending}; the chain continues without it");
                }
            }
            // It wants no more than the word that it would be given at the end.
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

    /// Treats a process that could not be started as a fault like any other.
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

    /// Tells the service manager, if there is one.
    fn say_how_it_is(&mut self) {
        let [capture, extract, fit] =
            [Part::Capture, Part::Extract, Part::Fit].map(|part| part as usize);
        let mut signs = Signs {
            fitted: self.handovers[fit].read().sent.count,
            beats: self.handovers[capture].read().beats,
        };
        if self.children[capture].is_none() {
            // Frames of another program come when they come.
            signs.beats = self.began.map_or(0, |began| began.elapsed().as_secs());
        }
        let extract = &self.handovers[extract];
        self.status_notifier.tell(signs, Instant::now(), || {
            extract_handover::ropes_seen(extract)
        });
    }
}

/// The name of the file that a recorder writes which was restarted: `run.mcap`, `run-2.mcap`, `run-3.mcap`.
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
