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
//! A stage that ends when it should not (by itself, by a signal that was not the chain's, by a crash) is *fallen*. As `restart` says
//! (`restarts`), it is started anew in its place while the others and all readers go on; or the others are stopped in order, the
//! report is printed, and the exit code is 1 with a sentence that names stage and cause. So that nothing is counted twice or forgotten, the
//! chain holds for each stage what it leaves to its successor (`stages/heirloom.rs`): counts go on, extract's ropes keep their numbers, sink's
//! figures theirs. By what stands in there the chain also sees which stage stands still while work waits for it, and kills it.
//!
//! **Settings that change** come by the socket that `lariat set` writes to (`control.rs`) or with the settings file (`--watch`), are checked as a
//! whole, and told to all parts (`stages/orders.rs`): what concerns extract or fit they take between two frames, what concerns another starts it
//! anew. The chain itself has no other state: when *it* dies, its children end. A next chain that took them over would have their pipes, settings and
//! words to find again; started whole, by systemd or a shell's loop, it is there in a quarter of a second.
//!
//! Children ask the kernel for SIGTERM at their parent's death (`PR_SET_PDEATHSIG`, and a look whether it has died
//! already), so that `kill -9` of the chain takes them along. A second Ctrl-C ends at once.

mod child;
mod herald;
mod restarts;
mod watch;

use std::ffi::OsString;
use std::os::fd::AsFd;
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::{Duration, Instant};

use lariat_sink::FinalCounts;
use lariat_wire::Domain;
use rustix::event::{PollFd, PollFlags, Timespec, poll};

use crate::control::{Asked, Control};
use crate::pipeline::{CurveFitter, FrameExtractor};
use crate::run_files::RunFiles;
use crate::settings::{FILE_NAME, Flags, Settings, Stage};
use crate::stages;
use crate::stages::arrangement::{self, Lacks};
use crate::stages::estate;
use crate::stages::heirloom::{Heirloom, Progress};
use crate::stages::status::{LastWord, Sent};
use crate::stop::Stop;
use child::{Child, Ending, Run};
use herald::{Herald, Signs};
use restarts::{Restarts, Verdict};
use watch::Watch;

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

    /// The stage before it, if it is a stage.
    fn before(self) -> Option<Self> {
        match self {
            Self::Capture | Self::Recorder => None,
            Self::Extract => Some(Self::Capture),
            Self::Fit => Some(Self::Extract),
            Self::Sink => Some(Self::Fit),
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
/// How long a stage may do nothing once it was told to end: what waits for it is worked off first.
const STOP_PATIENCE: Duration = Duration::from_secs(3);
/// A lossless one waits so long itself for a reader that stands still.
const LOSSLESS_PATIENCE: Duration = Duration::from_secs(6);
/// How long it may take in all.
const STOP_TIMEOUT: Duration = Duration::from_secs(20);
/// How long the recorder may take: as long as the disk needs for all that waits, which may be slow.
const RECORDER_STOP_TIMEOUT: Duration = Duration::from_secs(60);
/// How long one may take to be gone that was killed: what the kernel still waits for, a disk or a camera, is not waited for longer.
const KILL_TIMEOUT: Duration = Duration::from_secs(2);
/// How often the chain looks whether a stage stands still.
const LOOK_EVERY: Duration = Duration::from_secs(1);

/// Runs the chain until its source ends, a signal comes, or a stage falls for good.
///
/// `flags` are those of `lariat run`, which with `words` go to every stage, which takes what concerns it; `settings` are theirs.
///
/// With `fuse`, the stages up to fit are threads of this process: the same code over the same channels.
pub fn run(flags: &Flags, words: &[OsString], settings: Settings) -> anyhow::Result<ExitCode> {
    arrangement::check(&settings.run.arrangement)?;
    // Before anything is started: what cannot be written at the end is said now.
    let _files = RunFiles::open_all(&settings)?;
    let stop = Stop::on_signals()?;
    let mut chain = Chain::new(flags, words, settings)?;
    for part in chain.parts() {
        chain.start(part)?;
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
    chain.begin();
    chain.watch(&stop)?;
    chain.stop_in_order(false);
    Ok(chain.verdict())
}

/// What is known of a stage that is watched.
#[derive(Clone, Copy)]
struct Watched {
    progress: Progress,
    /// Since when.
    since: Instant,
}

struct Chain {
    flags: Flags,
    arguments: Vec<OsString>,
    settings: Arc<Settings>,
    children: [Option<Child>; Part::ALL.len()],
    heirlooms: [Heirloom; Part::ALL.len()],
    restarts: Restarts,
    /// When a part that fell is started anew.
    due: [Option<Instant>; Part::ALL.len()],
    /// Those that were told to end, to be started anew.
    renewed: [bool; Part::ALL.len()],
    watched: [Watched; Part::ALL.len()],
    /// When the chain was up.
    began: Option<Instant>,
    control: Option<Control>,
    file: Option<Watch>,
    herald: Herald,
    /// The first that ended when it should not have, for good.
    fallen: Option<Part>,
    /// Nothing is started anew any more.
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
        let mut heirlooms: [Heirloom; Part::ALL.len()] = Default::default();
        for part in Part::ALL {
            heirlooms[part as usize] = Heirloom::make(part.name())?;
        }
        Ok(Self {
            flags: flags.clone(),
            arguments: [&flags.words(), words].concat(),
            settings: Arc::new(settings),
            children: Default::default(),
            heirlooms,
            restarts: Restarts::default(),
            due: Default::default(),
            renewed: Default::default(),
            watched: [watched; Part::ALL.len()],
            began: None,
            control: None,
            file: None,
            herald: Herald::new(),
            fallen: None,
            is_stopping: false,
            recording_lost: false,
        })
    }

    /// What is started, in this order.
    fn parts(&self) -> impl Iterator<Item = Part> + use<> {
        let has_recorder = self.settings.run.record.is_some();
        let is_external = self.settings.capture.is_external();
        Part::START_ORDER
            .into_iter()
            .filter(move |part| match part {
                Part::Recorder => has_recorder,
                // Frames are written by a process of the user's.
                Part::Capture => !is_external,
                Part::Extract | Part::Fit | Part::Sink => true,
            })
    }

    /// Starts a part, for the first time or anew.
    fn start(&mut self, part: Part) -> anyhow::Result<()> {
        let settings = &self.settings;
        let heirloom = &self.heirlooms[part as usize];
        let restarts = heirloom.progress().restarts;
        let child = match part.fused() {
            Some(run) if settings.run.fuse => Child::start_here(part, run, settings, heirloom)?,
            _ => {
                let reads = part == Part::Capture && settings.capture.is_piped();
                let is_changed = restarts > 0 || settings.version > 0;
                let changed = is_changed.then(|| self.settings_of(part, restarts).text());
                Child::start(part, &self.arguments, reads, heirloom, changed.as_deref())?
            }
        };
        self.children[part as usize] = Some(child);
        self.watched[part as usize] = Watched {
            progress: heirloom.read(),
            since: Instant::now(),
        };
        Ok(())
    }

    /// The settings of a part that is started anew.
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
        self.herald.ready();
        if self.settings.run.watch {
            match Watch::of(self.settings.file.as_deref()) {
                Ok(watch) => self.file = Some(watch),
                Err(cause) => {
                    tracing::warn!("changes of the settings file are not seen: {cause:#}")
                }
            }
        }
    }

    /// Makes the socket, also where it was removed: all that was in the domain died at once, and what was left is removed by the
    /// next that joins.
    fn listen_to_others(&mut self) {
        if self.control.as_ref().is_some_and(Control::is_there) {
            return;
        }
        match Control::open(&self.settings.run.rig) {
            Ok(control) => self.control = Some(control),
            Err(cause) => {
                tracing::warn!("the chain cannot be told anything while it runs: {cause:#}")
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
            let look = self.settings.run.starts_anew().then_some(LOOK_EVERY);
            let look = look.into_iter().chain(self.herald.wait()).min();
            let look = look.map(|look| Instant::now() + look);
            let due = self.due.into_iter().flatten().chain(look).min();
            self.listen(due, Some(stop))?;
            self.start_anew()?;
            self.strike_the_hanging();
            self.answer_others();
            self.read_the_file();
            self.say_how_it_is();
        }
        Ok(())
    }

    /// Sleeps until a stage says something or ends, and takes note of it.
    fn listen(&mut self, deadline: Option<Instant>, stop: Option<&Stop>) -> anyhow::Result<()> {
        let left = deadline.map(|deadline| deadline.saturating_duration_since(Instant::now()));
        let left = left.and_then(|left| Timespec::try_from(left).ok());
        let others = [
            stop.map(AsFd::as_fd),
            self.control
                .as_ref()
                .filter(|_| stop.is_some())
                .map(AsFd::as_fd),
            self.file
                .as_ref()
                .filter(|_| stop.is_some())
                .map(AsFd::as_fd),
        ];
        let mut descriptors: Vec<PollFd> = self
            .stages()
            .filter_map(Child::line)
            .chain(others.into_iter().flatten())
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
        if ending.is_none() && self.settings.run.starts_anew() {
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
        let (run, now) = (&self.settings.run, Instant::now());
        match self.restarts.judge(run, ending, is_done, now) {
            Verdict::Anew(due) => {
                self.due[at] = Some(due);
                let how = ending.map_or_else(String::new, |ending| ending.to_string());
                eprintln!("lariat: {} {how}; it is started anew", part.name());
            }
            Verdict::End if is_wished => {}
            Verdict::End => self.give_up(part, ending),
            Verdict::TooMany(count) => {
                let window_s = run.restart_window.as_secs_f64();
                eprintln!(
                    "lariat: {count} parts were started anew within {window_s} s (max_restarts): no more"
                );
                self.give_up(part, ending);
            }
        }
    }

    /// A part has fallen for good.
    fn give_up(&mut self, part: Part, ending: Option<Ending>) {
        match ending {
            // A chain is there for its robot: without a recording it goes on.
            Some(ending) if part == Part::Recorder && self.began.is_some() => {
                if !std::mem::replace(&mut self.recording_lost, true) {
                    eprintln!("lariat: the recorder {ending}; the chain goes on without it");
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
    fn start_anew(&mut self) -> anyhow::Result<()> {
        for part in Part::ALL {
            let at = part as usize;
            if self.due[at].is_some_and(|due| due <= Instant::now()) {
                self.due[at] = None;
                self.heirlooms[at].begin_anew();
                self.start(part)?;
                self.listen_to_others();
            }
        }
        Ok(())
    }

    /// Kills the stages that stand still while work waits for them, if they are started anew then.
    fn strike_the_hanging(&mut self) {
        let run = &self.settings.run;
        if !run.starts_anew() || run.lossless {
            return;
        }
        let now = Instant::now();
        let progress = Part::ALL.map(|part| self.heirlooms[part as usize].read());
        for part in [Part::Capture, Part::Extract, Part::Fit, Part::Sink] {
            let at = part as usize;
            let Some(child) = &self.children[at] else {
                continue;
            };
            let works = match part.before() {
                _ if !child.is_ready() => true,
                Some(before) if self.child(before).is_some() => {
                    progress[before as usize].sent.count > progress[at].taken
                }
                // Nobody knows what a writer of the user's sent.
                Some(_) => false,
                None => true,
            };
            let patience = match child.is_ready() {
                true => run.hang,
                false => START_TIMEOUT,
            };
            let watched = &mut self.watched[at];
            if !works || progress[at] != watched.progress {
                *watched = Watched {
                    progress: progress[at],
                    since: now,
                };
            } else if child.ending().is_none() && now - watched.since > patience {
                eprintln!(
                    "lariat: {} has stood still for {} s while work waits for it, and is killed",
                    part.name(),
                    patience.as_secs_f64()
                );
                watched.since = now;
                child.strike();
            }
        }
    }

    /// Tells the service manager, if there is one.
    fn say_how_it_is(&mut self) {
        let [capture, extract, fit] =
            [Part::Capture, Part::Extract, Part::Fit].map(|part| part as usize);
        let mut signs = Signs {
            fitted: self.heirlooms[fit].read().sent.count,
            beats: self.heirlooms[capture].read().beats,
        };
        if self.children[capture].is_none() {
            // Frames of another program come when they come.
            signs.beats = self.began.map_or(0, |began| began.elapsed().as_secs());
        }
        let extract = &self.heirlooms[extract];
        self.herald
            .tell(signs, Instant::now(), || estate::ropes_seen(extract));
    }

    /// Does what others ask for.
    fn answer_others(&mut self) {
        while let Some(mut client) = self.control.as_ref().and_then(Control::next) {
            let answer = match client.asked() {
                Ok(Asked::Settings) => Ok(self.settings.text()),
                Ok(Asked::File) => self.file_path(),
                Ok(Asked::Set(changes)) => self.set(&changes),
                Ok(Asked::Restart(name)) => self.renew_by_name(&name),
                Err(cause) => Err(cause),
            };
            client.answer(answer);
        }
    }

    /// Where its settings file is, or would be.
    fn file_path(&self) -> anyhow::Result<String> {
        let file = self.settings.file.as_deref();
        let path = std::path::absolute(file.unwrap_or(Path::new(FILE_NAME)))?;
        Ok(format!("{}\n", path.display()))
    }

    /// Has settings hold from now on that are written as `section.name=value`.
    fn set(&mut self, changes: &[String]) -> anyhow::Result<String> {
        let (mut flags, mut alone) = (self.flags.clone(), Flags::default());
        for change in changes {
            (flags, alone) = (flags.with_change(change)?, alone.with_change(change)?);
        }
        let answer = self.change(self.settings.changed_by(&alone)?)?;
        self.flags = flags;
        Ok(answer)
    }

    /// Takes the settings file as it is now, if it has changed.
    fn read_the_file(&mut self) {
        if !self.file.as_mut().is_some_and(Watch::has_changed) {
            return;
        }
        match Settings::resolve(&self.flags).and_then(|settings| self.change(settings)) {
            Ok(answer) => eprintln!("lariat: {}", answer.trim_end()),
            Err(cause) => tracing::warn!("the settings stay as they are: {cause:#}"),
        }
    }

    /// Has other settings hold from now on: what changed, and when it holds, as lines.
    ///
    /// # Errors
    /// A sentence why they cannot; nothing has changed then.
    fn change(&mut self, mut settings: Settings) -> anyhow::Result<String> {
        let differences: Vec<_> = settings.differences(&self.settings).collect();
        if differences.is_empty() {
            return Ok("nothing has changed\n".to_owned());
        }
        let concerned = settings.concerned(&self.settings)?;
        let parts = [Part::Capture, Part::Extract, Part::Fit, Part::Sink];
        let named = |of: [bool; 4]| {
            let names: Vec<_> = parts
                .iter()
                .filter(|part| of[**part as usize])
                .map(|part| part.name())
                .collect();
            names.join(", ")
        };
        if concerned.anew.contains(&true) && settings.run.fuse {
            anyhow::bail!(
                "{} would have to be started anew, which a fused chain cannot do: stop it, and start it with the new value",
                named(concerned.anew)
            );
        }
        // What a stage could not make is said to who asks.
        if concerned.live[Part::Extract as usize] {
            FrameExtractor::new(&settings.extract)?;
        }
        if concerned.live[Part::Fit as usize] {
            CurveFitter::new(&settings)?;
        }
        settings.version = self.settings.version + 1;
        let mut answer = format!("settings {}:", settings.version);
        for (name, value) in differences {
            answer += &format!(" {name} = {value}");
        }
        if concerned.live.contains(&true) {
            answer += &format!("; {} between two frames", named(concerned.live));
        }
        if concerned.anew.contains(&true) {
            answer += &format!("; started anew: {}", named(concerned.anew));
        }
        answer.push('\n');
        let text = settings.text();
        self.settings = Arc::new(settings);
        for child in self.children.iter_mut().flatten() {
            if child.ending().is_none() && !child.order(&text) {
                tracing::warn!(
                    "{} does not listen, and keeps the settings it has",
                    child.part.name()
                );
            }
        }
        for part in parts
            .into_iter()
            .filter(|part| concerned.anew[*part as usize])
        {
            self.renew(part);
        }
        Ok(answer)
    }

    fn renew_by_name(&mut self, name: &str) -> anyhow::Result<String> {
        let part = Part::ALL.into_iter().find(|part| part.name() == name);
        let Some(part) = part.filter(|part| self.child(*part).is_some()) else {
            anyhow::bail!("this chain has no {name}: name capture, extract, fit or sink");
        };
        if self.settings.run.fuse && part.fused().is_some() {
            anyhow::bail!("{name} is no process of its own, as the chain is fused");
        }
        self.renew(part);
        Ok(format!("{name} is started anew\n"))
    }

    /// Has a part end, to be started anew.
    fn renew(&mut self, part: Part) {
        let Some(child) = self.children[part as usize].as_mut() else {
            return;
        };
        if child.ending().is_some() {
            // It is about to be.
            return;
        }
        self.renewed[part as usize] = true;
        match part.is_told_the_last_word() {
            // It would report at its end.
            true => child.strike(),
            false => child.tell_to_stop(),
        }
    }

    /// Ends the stages from the beginning to the end, each when all before it have ended: so everything that was sent is
    /// worked off. `never`: the chain never came up, and there is nothing to report.
    fn stop_in_order(&mut self, never: bool) {
        self.is_stopping = true;
        self.herald.stopping();
        self.due = Default::default();
        self.control = None;
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

    /// Waits for the end of a part that was told to end; one that does nothing for it, or takes too long, is killed.
    fn await_end(&mut self, part: Part) {
        let (patience, most) = match part {
            Part::Recorder => (RECORDER_STOP_TIMEOUT, RECORDER_STOP_TIMEOUT),
            _ if self.settings.run.lossless => (LOSSLESS_PATIENCE, STOP_TIMEOUT),
            Part::Capture | Part::Extract | Part::Fit | Part::Sink => (STOP_PATIENCE, STOP_TIMEOUT),
        };
        let begin = Instant::now();
        if self.ends_within(part, patience, most) {
            return;
        }
        eprintln!(
            "lariat: {} did not end within {} s of being told to, and was killed",
            part.name(),
            begin.elapsed().as_secs()
        );
        self.fallen.get_or_insert(part);
        if let Some(child) = &mut self.children[part as usize] {
            child.kill();
        }
        if !self.ends_within(part, KILL_TIMEOUT, KILL_TIMEOUT) {
            eprintln!("lariat: {} could not be killed", part.name());
        }
    }

    /// Whether a part ends, or is not there, within `most`, and without doing nothing for so long as `patience`.
    fn ends_within(&mut self, part: Part, patience: Duration, most: Duration) -> bool {
        let begin = Instant::now();
        let (mut ticks, mut busy) = (None, begin);
        loop {
            let Some(child) = self.child(part).filter(|child| child.ending().is_none()) else {
                return true;
            };
            let now = Instant::now();
            let used = child.ticks();
            if used != ticks {
                (ticks, busy) = (used, now);
            }
            let end = (begin + most).min(busy + patience);
            if now >= end {
                return false;
            }
            let look = now + patience / 8;
            if self.listen(Some(look.min(end)), None).is_err() {
                return false;
            }
        }
    }

    /// What each stage said it sent in all. Of frames from elsewhere, extract knows what capture would.
    fn counts(&self) -> FinalCounts {
        let sent = |part| -> Option<Sent> {
            let child = self.child(part)?;
            // One that was killed had noted what it was about to send.
            let noted = || self.heirlooms[part as usize].read().sent;
            Some(child.sent().unwrap_or_else(noted))
        };
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

/// The name of the file that a recorder writes which was started anew: `run.mcap`, `run-2.mcap`, `run-3.mcap`.
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
