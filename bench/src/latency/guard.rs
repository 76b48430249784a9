//! Programs that are started for a measurement, and end with it whatever happens.
//!
//! Each is started through `lariat-bench latency-part guard`, which asks the kernel to end it when the bench dies, puts it on
//! its core and under its scheduling class, and then becomes it.

use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::process::CommandExt;
use std::process::{Child, Command, ExitStatus};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{
    Pid, PidfdFlags, Signal, getppid, kill_process, pidfd_open, set_parent_process_death_signal,
};

use lariat_chain::stages::arrangement;
use lariat_chain::stop::Stop;

/// How long a program may take to end when it is asked to.
const PATIENCE: Duration = Duration::from_secs(5);
/// The priority of a program under FIFO scheduling: above what is not, below the kernel's own threads.
const PRIORITY: u8 = 50;

/// A program that ends with the value.
pub(crate) struct Guarded {
    child: Child,
    gone: OwnedFd,
    ended: Option<ExitStatus>,
}

impl Guarded {
    /// Starts a program in a process group of its own: a Ctrl-C is the bench's to deal with.
    pub(crate) fn start(command: &mut Command) -> Result<Self> {
        let mut child = command
            .process_group(0)
            .spawn()
            .context("a program could not be started for a measurement")?;
        let pid = Pid::from_child(&child);
        match pidfd_open(pid, PidfdFlags::empty()) {
            Ok(gone) => Ok(Self {
                child,
                gone,
                ended: None,
            }),
            Err(cause) => {
                let _ = child.kill();
                let _ = child.wait();
                Err(cause).context("the kernel does not tell when a process ends: it is too old")
            }
        }
    }

    pub(super) fn id(&self) -> u32 {
        self.child.id()
    }

    /// The program's process, to read what it prints.
    pub(super) fn child(&mut self) -> &mut Child {
        &mut self.child
    }

    /// Waits for its end; `None` if the deadline is over first.
    ///
    /// # Errors
    /// A signal asked the bench to stop.
    pub(super) fn wait(&mut self, deadline: Instant, stop: &Stop) -> Result<Option<ExitStatus>> {
        while self.ended.is_none() {
            ensure!(!stop.asked(), "a signal stopped the measurement");
            if !self.wait_for_an_event(deadline, Some(stop)) {
                return Ok(None);
            }
        }
        Ok(self.ended)
    }

    /// Asks it to end.
    pub(super) fn ask_to_end(&self) {
        if self.ended.is_none() {
            // Not waited for yet, so the number is still this process's.
            let _ = kill_process(Pid::from_child(&self.child), Signal::TERM);
        }
    }

    /// `false` if the deadline is over.
    fn wait_for_an_event(&mut self, deadline: Instant, stop: Option<&Stop>) -> bool {
        let left = deadline.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return false;
        }
        let mut polled = vec![PollFd::new(&self.gone, PollFlags::IN)];
        if let Some(stop) = stop {
            polled.push(PollFd::from_borrowed_fd(stop.as_fd(), PollFlags::IN));
        }
        // What happened is asked for below, and by the caller.
        let _ = poll(&mut polled, Timespec::try_from(left).ok().as_ref());
        self.ended();
        true
    }

    /// How it has ended, if it has.
    pub(crate) fn ended(&mut self) -> Option<ExitStatus> {
        if let Ok(Some(status)) = self.child.try_wait() {
            self.ended = Some(status);
        }
        self.ended
    }

    /// Asks it to end, and ends it if it has not within `patience`.
    pub(crate) fn end(&mut self, patience: Duration) {
        self.ask_to_end();
        let deadline = Instant::now() + patience;
        while self.ended.is_none() && self.wait_for_an_event(deadline, None) {}
        if self.ended.is_none() {
            let _ = self.child.kill();
            self.ended = self.child.wait().ok();
        }
    }
}

impl Drop for Guarded {
    fn drop(&mut self) {
        self.end(PATIENCE);
    }
}

/// Ends programs together: each asked first, so that they do not wait for each other.
pub(super) fn end_all(programs: Vec<Guarded>) {
    programs.iter().for_each(Guarded::ask_to_end);
}

/// Where a program runs.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Placement {
    /// On this core alone.
    pub(super) core: Option<usize>,
    /// Under FIFO scheduling.
    pub(super) fifo: bool,
}

/// What `latency-part guard` is told.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct GuardArgs {
    /// The bench that started it
    parent: i32,
    /// The core to run on
    #[arg(long)]
    core: Option<usize>,
    /// Run under FIFO scheduling
    #[arg(long)]
    fifo: bool,
    /// The program and what it is told
    #[arg(last = true, required = true)]
    program: Vec<std::ffi::OsString>,
}

/// A command that becomes this program, guarded, in a placement.
pub(super) fn command(itself: &std::path::Path, placement: Placement) -> Command {
    let mut command = Command::new(itself);
    command.args(["latency-part", "guard"]);
    command.arg(std::process::id().to_string());
    if let Some(core) = placement.core {
        command.arg("--core").arg(core.to_string());
    }
    if placement.fifo {
        command.arg("--fifo");
    }
    command.arg("--");
    command
}

/// Becomes the program.
pub(super) fn run(args: &GuardArgs) -> Result<std::process::ExitCode> {
    set_parent_process_death_signal(Some(Signal::TERM))
        .context("the kernel was asked to end this program with the bench, and refused")?;
    // The bench may have died before the kernel was asked.
    ensure!(
        getppid().map(Pid::as_raw_pid) == Some(args.parent),
        "the bench that started this program is gone"
    );
    if let Some(core) = args.core {
        arrangement::pin(core)?;
    }
    // Last, and kept by what it becomes.
    ensure!(
        !args.fifo || arrangement::run_before_others(PRIORITY),
        "FIFO scheduling is not allowed"
    );
    let mut words = args.program.iter();
    let program = words.next().context("no program was named")?;
    let cause = Command::new(program).args(words).exec();
    Err(cause).with_context(|| format!("{} cannot be run", program.display()))
}

/// Whether FIFO scheduling may be had, or why not.
pub(super) fn fifo_allowed() -> Result<(), String> {
    // In a thread of its own: the bench itself stays as it is.
    let tried = std::thread::spawn(|| arrangement::run_before_others(PRIORITY)).join();
    match tried {
        Ok(true) => Ok(()),
        _ => Err(format!(
            "FIFO scheduling is not allowed: `ulimit -r {PRIORITY}`, or see `lariat doctor`"
        )),
    }
}
