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
    /// Exit code 0.
    Well,
    /// Another exit code. The stage reported the reason.
    Failed(i32),
    /// Killed by a signal.
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

/// A stage's main function, which returns when a stop is requested.
pub(super) type Run = fn(&Settings, Supervision) -> anyhow::Result<()>;

/// How a stage is hosted.
enum Host {
    Process {
        process: std::process::Child,
        /// `None` once all its messages have been read.
        messages: Option<Intake>,
    },
    /// A thread of this process. The outcome is `None` once it has been collected.
    Thread {
        outcome: Option<JoinHandle<anyhow::Result<()>>>,
        stopper: Stopper,
    },
}

/// A stage that was started.
pub(super) struct Child {
    pub(super) part: Part,
    host: Host,
    /// The stage's status line. `None` once the stage has ended.
    line: Option<File>,
    /// Pipe on which the stage receives changes of settings.
    orders: File,
    /// The start of a line that is still incomplete.
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
    /// The last message that the process printed.
    last_words: String,
    told_to_stop: bool,
    given_up: bool,
}

impl Child {
    /// Starts a stage in a process group of its own, so that only the chain receives Ctrl-C. With
    /// `reads`, the stage inherits the chain's standard input; only one stage may.
    ///
    /// `handover` is the predecessor's handover state; it is empty at the first start. `changed`
    /// holds the settings if they differ from the arguments.
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
        // Only the chain talks to the service manager.
        for name in ["NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"] {
            command.env_remove(name);
        }
        // Only this child inherits the descriptors, because nothing else in this process starts a
        // child at the same time.
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

    /// Starts a stage as a thread of this process. It reports on a status line of its own, like a
    /// process, and is stopped individually.
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
            // A thread is never restarted, but the chain reads its progress here.
            handover: handover.share(),
        };
        let outcome = std::thread::Builder::new()
            .name(part.name().to_owned())
            // The supervision drops its end of the line when the thread ends, also after a panic.
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

    /// Returns the id of the stage's process.
    pub(super) fn id(&self) -> u32 {
        match &self.host {
            Host::Process { process, .. } => process.id(),
            Host::Thread { .. } => std::process::id(),
        }
    }

    /// Returns true if the stage can receive.
    pub(super) fn is_ready(&self) -> bool {
        self.ready
    }

    /// Returns the requested resources that the stage lacks.
    pub(super) fn lacks(&self) -> Lacks {
        self.lacks
    }

    /// Returns true if the stage finished its work rather than abandoning it.
    pub(super) fn is_done(&self) -> bool {
        self.done
    }

    /// Returns true if a signal that the chain did not send is ending the stage.
    pub(super) fn was_told_by_another(&self) -> bool {
        self.told_by_another
    }

    /// Returns true if nobody reads the stage's output any more.
    pub(super) fn is_unread(&self) -> bool {
        self.unread_output
    }

    /// Returns the totals of sent messages, if the stage lived to report them.
    pub(super) fn sent(&self) -> Option<Sent> {
        self.sent
    }

    /// Returns how many frames the stage skipped because their masks were late, if it waits for
    /// masks.
    pub(super) fn masks_late(&self) -> Option<u64> {
        self.masks_late
    }

    /// Returns how many frames lacked a depth image, if the stage waits for depth images.
    pub(super) fn depthless(&self) -> Option<u64> {
        self.depthless
    }

    /// Returns the counts of the stage's depth camera, if it has one.
    pub(super) fn depths(&self) -> Option<DepthCounts> {
        self.depths
    }

    /// Returns what the stage reported about frames from an external source, if it has one.
    pub(super) fn taken(&self) -> Option<Taken> {
        self.taken
    }

    /// Returns how the stage ended, if it has.
    pub(super) fn ending(&self) -> Option<Ending> {
        self.ending
    }

    /// Returns why the stage failed, in its own words if it printed any.
    pub(super) fn reason(&self) -> String {
        match self.ending {
            Some(Ending::Failed(_)) if !self.last_words.is_empty() => self.last_words.clone(),
            Some(ending) => ending.to_string(),
            None => "it did not get ready within start_limit_s".to_owned(),
        }
    }

    /// Returns true if the chain told the stage to stop.
    pub(super) fn was_told_to_stop(&self) -> bool {
        self.told_to_stop
    }

    /// Returns true if the stage had to be killed.
    pub(super) fn was_given_up(&self) -> bool {
        self.given_up
    }

    /// Returns a descriptor that is readable when the stage reports something or ends. `None` once
    /// it has ended.
    pub(super) fn line(&self) -> Option<BorrowedFd<'_>> {
        self.line.as_ref().map(AsFd::as_fd)
    }

    /// Reads what the stage reported, without blocking.
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
        // The stage's end of the line is closed: the process has ended or is about to.
        self.take_note();
        self.line = None;
        self.ending = Some(match &mut self.host {
            Host::Process { process, messages } => {
                let ended = process.wait().map_or(Ending::Failed(-1), ending);
                // The stage's own messages are printed before the message about its end.
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

    /// Tells the stage that settings have changed. Returns `false` if it does not listen.
    pub(super) fn order(&mut self, settings: &str) -> bool {
        self.orders
            .write_all(orders::order(settings).as_bytes())
            .is_ok()
    }

    /// Returns the CPU time that the process has used, in clock ticks. `None` for a thread, or if
    /// the kernel does not report it.
    pub(super) fn ticks(&self) -> Option<u64> {
        let Host::Process { process, .. } = &self.host else {
            return None;
        };
        let stat = std::fs::read_to_string(format!("/proc/{}/stat", process.id())).ok()?;
        // The name is in parentheses and may contain any character.
        let (_, rest) = stat.rsplit_once(')')?;
        let mut numbers = rest.split_ascii_whitespace().skip(11);
        let mut next = || numbers.next()?.parse::<u64>().ok();
        Some(next()? + next()?)
    }

    /// Writes to the stage's standard input and closes it.
    pub(super) fn tell(&mut self, word: &str) {
        let Host::Process { process, .. } = &mut self.host else {
            return;
        };
        if let Some(mut stdin) = process.stdin.take() {
            // If the stage is gone, its ending is reported anyway.
            let _ = stdin.write_all(word.as_bytes());
        }
    }

    /// Asks the stage to process what is waiting and then end. A process that was paused with
    /// SIGSTOP is continued, so that it can do so. systemd does the same.
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

    /// Kills the stage at once so that it can be restarted.
    pub(super) fn strike(&self) {
        self.signal(Signal::KILL);
    }

    /// Kills the stage at once. A thread cannot be killed: it is abandoned and ends with this
    /// process.
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
        // The process has not been waited for yet, so the id is still valid.
        let pid = i32::try_from(process.id()).ok().and_then(Pid::from_raw);
        if let (None, Some(pid)) = (self.ending, pid) {
            let _ = kill_process(pid, signal);
        }
    }
}

/// Writes a text to a file in memory.
fn in_memory(text: &str) -> std::io::Result<File> {
    let file: File = memfd_create("lariat-settings", MemfdFlags::CLOEXEC)?.into();
    file.write_all_at(text.as_bytes(), 0)?;
    Ok(file)
}

/// Describes the end of a thread as if it were a process.
fn ending_of_thread(outcome: JoinHandle<anyhow::Result<()>>) -> Ending {
    match outcome.join() {
        Ok(Ok(())) => Ending::Well,
        Ok(Err(cause)) => {
            eprintln!("lariat: {cause:#}");
            Ending::Failed(1)
        }
        // The panic message has given the reason.
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
