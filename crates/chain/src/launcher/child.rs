//! One stage as a child process.

use std::ffi::OsString;
use std::fmt;
use std::fs::File;
use std::io::{ErrorKind, Read, Write};
use std::os::fd::{AsFd, AsRawFd, BorrowedFd, OwnedFd};
use std::os::unix::fs::FileExt;
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::process::{ExitStatus, Stdio};
use std::sync::Arc;
use std::thread::JoinHandle;

use anyhow::Context;
use lariat_sink::DepthCounts;
use rustix::fs::{MemfdFlags, memfd_create};
use rustix::io::{FdFlags, fcntl_setfd};
use rustix::pipe::{PipeFlags, pipe_with};
use rustix::process::{Pid, Signal, kill_process};

use super::Part;
use crate::itself;
use crate::messages::Intake;
use crate::settings::{SETTINGS_FD, Settings};
use crate::stages::Supervision;
use crate::stages::arrangement::Lacks;
use crate::stages::handover::{HANDOVER_FD, Handover};
use crate::stages::orders::{self, ORDERS_FD, Orders};
use crate::stages::status::{CHAIN_PID, STATUS_FD, Sent, Status, Taken, Word};
use crate::stop::{Stop, Stopper};

/// How a stage ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ending {
    /// With exit code 0.
    Well,
    /// With another exit code; it has said why.
    Failed(i32),
    /// By a signal.
    Killed(i32),
}

impl fmt::Display for Ending {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Well => write!(f, "ended before its time"),
            Self::Failed(code) => write!(
                f,
                "failed with exit code {code}, for the reason it gave above"
            ),
            Self::Killed(signal) => {
                let name = match *signal {
                    6 => " (SIGABRT)",
                    7 => " (SIGBUS: is /dev/shm full?)",
                    9 => " (SIGKILL)",
                    11 => " (SIGSEGV)",
                    15 => " (SIGTERM)",
                    24 => " (SIGXCPU: with realtime priority it ran for seconds without sleeping)",
                    _ => "",
                };
                write!(f, "was killed by signal {signal}{name}")
            }
        }
    }
}

/// What a stage does until it is told to stop.
pub(super) type Run = fn(&Settings, Supervision) -> anyhow::Result<()>;

/// What a stage runs in.
enum Host {
    Process {
        process: std::process::Child,
        /// `None` once all that it said was taken in.
        messages: Option<Intake>,
    },
    /// A thread of this process. Its outcome is `None` once it was asked for.
    Thread {
        outcome: Option<JoinHandle<anyhow::Result<()>>>,
        stopper: Stopper,
    },
}

/// A stage that was started.
pub(super) struct Child {
    pub(super) part: Part,
    host: Host,
    /// What it says; `None` once it has ended.
    line: Option<File>,
    /// What it is told.
    orders: File,
    /// The part of a line that has not ended yet.
    unread: Vec<u8>,
    ready: bool,
    lacks: Lacks,
    done: bool,
    told_by_another: bool,
    unread_output: bool,
    sent: Option<Sent>,
    masks_late: Option<u64>,
    depthless: Option<u64>,
    depths: Option<DepthCounts>,
    taken: Option<Taken>,
    ending: Option<Ending>,
    /// The last sentence that its process said.
    last_words: String,
    told_to_stop: bool,
    given_up: bool,
}

impl Child {
    /// Starts a stage in a process group of its own, so that a Ctrl-C is the chain's to deal with. One alone may read
    /// the chain's standard input.
    ///
    /// `handover`: what its predecessor left, or none yet. `changed`: its settings, if they are others than the arguments say.
    pub(super) fn start(
        part: Part,
        arguments: &[OsString],
        reads: bool,
        handover: &Handover,
        changed: Option<&str>,
    ) -> anyhow::Result<Self> {
        let starting = || format!("{} could not be started", part.name());
        let (line, its_end) = pipe_with(PipeFlags::CLOEXEC).with_context(starting)?;
        let (its_orders, orders) = pipe_with(PipeFlags::CLOEXEC).with_context(starting)?;
        for nonblocking in [&line, &orders] {
            rustix::io::ioctl_fionbio(nonblocking, true).with_context(starting)?;
        }
        let settings = changed.map(in_memory).transpose().with_context(starting)?;
        let mut command = itself::command();
        command.arg(part.name()).args(arguments);
        // The service manager hears of the chain from the chain.
        for name in ["NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"] {
            command.env_remove(name);
        }
        // Inherited by the child alone; nothing else starts a process here meanwhile.
        let inherited = [
            (STATUS_FD, Some(its_end.as_fd())),
            (ORDERS_FD, Some(its_orders.as_fd())),
            (HANDOVER_FD, handover.file().map(AsFd::as_fd)),
            (SETTINGS_FD, settings.as_ref().map(AsFd::as_fd)),
        ];
        let inherited = || {
            inherited
                .iter()
                .filter_map(|(name, fd)| Some((name, (*fd)?)))
        };
        for (name, fd) in inherited() {
            fcntl_setfd(fd, FdFlags::empty()).with_context(starting)?;
            command.env(name, fd.as_raw_fd().to_string());
        }
        let process = Intake::prepare(&mut command)
            .env(CHAIN_PID, std::process::id().to_string())
            .stdin(match part.is_told_the_last_word() {
                true => Stdio::piped(),
                false if reads => Stdio::inherit(),
                false => Stdio::null(),
            })
            .process_group(0)
            .spawn();
        for (_, fd) in inherited() {
            fcntl_setfd(fd, FdFlags::CLOEXEC).with_context(starting)?;
        }
        let mut process = process.with_context(starting)?;
        let messages = process.stderr.take().map(Intake::of);
        let messages = messages.transpose().with_context(starting)?;
        let host = Host::Process { process, messages };
        Ok(Self::new(part, host, line, orders))
    }

    /// Starts a stage as a thread of this process. It says what a process would, on a line of its own, and is told to stop
    /// by itself, in its turn.
    pub(super) fn start_here(
        part: Part,
        run: Run,
        settings: &Arc<Settings>,
        handover: &Handover,
    ) -> anyhow::Result<Self> {
        let starting = || format!("{} could not be started", part.name());
        let (line, its_end) = pipe_with(PipeFlags::CLOEXEC).with_context(starting)?;
        let (its_orders, orders) = pipe_with(PipeFlags::CLOEXEC).with_context(starting)?;
        for nonblocking in [&line, &orders] {
            rustix::io::ioctl_fionbio(nonblocking, true).with_context(starting)?;
        }
        let (stop, stopper) = Stop::by_another()?;
        let settings = settings.clone();
        let supervision = Supervision {
            stop,
            status: Status::on(its_end),
            orders: Orders::on(its_orders),
            // It has no successor, but the chain sees how far it is.
            handover: handover.share(),
        };
        let outcome = std::thread::Builder::new()
            .name(part.name().to_owned())
            // The end of the line is dropped with the supervision, also by a panic.
            .spawn(move || run(&settings, supervision))
            .with_context(starting)?;
        let outcome = Some(outcome);
        Ok(Self::new(
            part,
            Host::Thread { outcome, stopper },
            line,
            orders,
        ))
    }

    fn new(part: Part, host: Host, line: OwnedFd, orders: OwnedFd) -> Self {
        Self {
            part,
            host,
            line: Some(line.into()),
            orders: orders.into(),
            unread: Vec::new(),
            ready: false,
            lacks: Lacks::default(),
            done: false,
            told_by_another: false,
            unread_output: false,
            sent: None,
            masks_late: None,
            depthless: None,
            depths: None,
            taken: None,
            ending: None,
            last_words: String::new(),
            told_to_stop: false,
            given_up: false,
        }
    }

    /// The id of its process.
    pub(super) fn id(&self) -> u32 {
        match &self.host {
            Host::Process { process, .. } => process.id(),
            Host::Thread { .. } => std::process::id(),
        }
    }

    /// Whether it can receive.
    pub(super) fn is_ready(&self) -> bool {
        self.ready
    }

    /// What it does without.
    pub(super) fn lacks(&self) -> Lacks {
        self.lacks
    }

    /// Whether its work is done, rather than broken off.
    pub(super) fn is_done(&self) -> bool {
        self.done
    }

    /// Whether a signal that was not the chain's is ending it.
    pub(super) fn was_told_by_another(&self) -> bool {
        self.told_by_another
    }

    /// Whether nobody reads any more what it prints.
    pub(super) fn is_unread(&self) -> bool {
        self.unread_output
    }

    /// What it said it sent in all, if it lived to say so.
    pub(super) fn sent(&self) -> Option<Sent> {
        self.sent
    }

    /// How many frames it said it skipped for want of a mask, if it waited for masks.
    pub(super) fn masks_late(&self) -> Option<u64> {
        self.masks_late
    }

    /// How many frames it said had no depth image, if it waited for those.
    pub(super) fn depthless(&self) -> Option<u64> {
        self.depthless
    }

    /// What it said of its depth camera, if it has one.
    pub(super) fn depths(&self) -> Option<DepthCounts> {
        self.depths
    }

    /// What it said of the frames that came to it from elsewhere, if they did.
    pub(super) fn taken(&self) -> Option<Taken> {
        self.taken
    }

    /// How it ended, if it has.
    pub(super) fn ending(&self) -> Option<Ending> {
        self.ending
    }

    /// Why it ended, if it has: in its own words, if it said any.
    pub(super) fn reason(&self) -> String {
        match self.ending {
            Some(Ending::Failed(_)) if !self.last_words.is_empty() => self.last_words.clone(),
            Some(ending) => ending.to_string(),
            None => "it did not get ready within start_limit_s".to_owned(),
        }
    }

    /// Whether its end was wished.
    pub(super) fn was_told_to_stop(&self) -> bool {
        self.told_to_stop
    }

    /// Whether it had to be killed.
    pub(super) fn was_given_up(&self) -> bool {
        self.given_up
    }

    /// Readable when it said something, or ended; `None` once it has.
    pub(super) fn line(&self) -> Option<BorrowedFd<'_>> {
        self.line.as_ref().map(AsFd::as_fd)
    }

    /// Takes note of what it said, without waiting.
    pub(super) fn listen(&mut self) {
        let Some(line) = &mut self.line else { return };
        let mut buffer = [0; 256];
        loop {
            match line.read(&mut buffer) {
                Ok(0) => break,
                Ok(count) => self.unread.extend(&buffer[..count]),
                Err(cause) if cause.kind() == ErrorKind::Interrupted => {}
                Err(cause) if cause.kind() == ErrorKind::WouldBlock => return self.take_note(),
                Err(_) => break,
            }
        }
        // Its end of the line is closed: the process is gone, or will be in a moment.
        self.take_note();
        self.line = None;
        self.ending = Some(match &mut self.host {
            Host::Process { process, messages } => {
                let ended = process.wait().map_or(Ending::Failed(-1), ending);
                // Its own messages come before the message about its end.
                if let Some(messages) = messages.take() {
                    self.last_words = messages.finish();
                }
                ended
            }
            Host::Thread { outcome, .. } => outcome.take().map_or(Ending::Well, ending_of_thread),
        });
    }

    fn take_note(&mut self) {
        while let Some(end) = self.unread.iter().position(|&byte| byte == b'\n') {
            let line: Vec<u8> = self.unread.drain(..=end).collect();
            match String::from_utf8_lossy(&line[..end]).parse() {
                Ok(Word::Lacks(lacks)) => self.lacks = lacks,
                Ok(Word::Ready) => self.ready = true,
                Ok(Word::Done) => self.done = true,
                Ok(Word::Ending) => self.told_by_another |= !self.told_to_stop,
                Ok(Word::Unread) => self.unread_output = true,
                Ok(Word::Late(count)) => self.masks_late = Some(count),
                Ok(Word::Depthless(count)) => self.depthless = Some(count),
                Ok(Word::Depths(counts)) => self.depths = Some(counts),
                Ok(Word::Taken(taken)) => self.taken = Some(taken),
                Ok(Word::Sent(sent)) => self.sent = Some(sent),
                Err(why) => tracing::warn!("{}: {why}", self.part.name()),
            }
        }
    }

    /// Tells it that settings have changed; `false` if it does not listen.
    pub(super) fn order(&mut self, settings: &str) -> bool {
        self.orders
            .write_all(orders::order(settings).as_bytes())
            .is_ok()
    }

    /// How much of a core's time its process has used, in the kernel's ticks; `None` of a thread, and if the kernel does not say.
    pub(super) fn ticks(&self) -> Option<u64> {
        let Host::Process { process, .. } = &self.host else {
            return None;
        };
        let stat = std::fs::read_to_string(format!("/proc/{}/stat", process.id())).ok()?;
        // The name, in parentheses, may hold anything.
        let (_, rest) = stat.rsplit_once(')')?;
        let mut numbers = rest.split_ascii_whitespace().skip(11);
        let mut next = || numbers.next()?.parse::<u64>().ok();
        Some(next()? + next()?)
    }

    /// Writes to its standard input and closes it.
    pub(super) fn tell(&mut self, word: &str) {
        let Host::Process { process, .. } = &mut self.host else {
            return;
        };
        if let Some(mut stdin) = process.stdin.take() {
            // If it is gone, its ending says so.
            let _ = stdin.write_all(word.as_bytes());
        }
    }

    /// Asks it to work off what waits, and end. A process that somebody stopped (SIGSTOP) is continued for that, as systemd
    /// does.
    pub(super) fn tell_to_stop(&mut self) {
        self.told_to_stop |= self.ending.is_none();
        match &mut self.host {
            Host::Process { .. } => {
                self.signal(Signal::TERM);
                self.signal(Signal::CONT);
            }
            Host::Thread { stopper, .. } => stopper.stop(),
        }
    }

    /// Ends it at once, to be restarted.
    pub(super) fn strike(&self) {
        self.signal(Signal::KILL);
    }

    /// Ends it at once. A thread cannot be: it is given up, and ends with this process.
    pub(super) fn kill(&mut self) {
        self.given_up = true;
        match &self.host {
            Host::Process { .. } => self.signal(Signal::KILL),
            Host::Thread { .. } => self.ending = Some(Ending::Killed(9)),
        }
    }

    fn signal(&self, signal: Signal) {
        let Host::Process { process, .. } = &self.host else {
            return;
        };
        // Not waited for yet, so the number is still this process's.
        let pid = i32::try_from(process.id()).ok().and_then(Pid::from_raw);
        if let (None, Some(pid)) = (self.ending, pid) {
            let _ = kill_process(pid, signal);
        }
    }
}

/// A text as a file in memory.
fn in_memory(text: &str) -> std::io::Result<File> {
    let file: File = memfd_create("lariat-settings", MemfdFlags::CLOEXEC)?.into();
    file.write_all_at(text.as_bytes(), 0)?;
    Ok(file)
}

/// How a thread ended, said as its process would have.
fn ending_of_thread(outcome: JoinHandle<anyhow::Result<()>>) -> Ending {
    match outcome.join() {
        Ok(Ok(())) => Ending::Well,
        Ok(Err(cause)) => {
            eprintln!("lariat: {cause:#}");
            Ending::Failed(1)
        }
        // The panic has said itself why.
        Err(_) => Ending::Failed(101),
    }
}

fn ending(status: ExitStatus) -> Ending {
    match (status.code(), status.signal()) {
        (Some(0), _) => Ending::Well,
        (Some(code), _) => Ending::Failed(code),
        (None, signal) => Ending::Killed(signal.unwrap_or(0)),
    }
}
