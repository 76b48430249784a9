//! Programs that are started for a measurement and end with it in every case.
//!
//! Each is started through `lariat-bench latency-part guard`. The guard asks the kernel to end it
//! when the bench dies. It moves to its core and scheduling class, and then becomes the program
//! (`exec`).

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

/// Time limit for a program to end after it is asked to.
const PATIENCE: Duration = Duration::from_secs(5);
/// Priority of a program under FIFO scheduling: above normal programs, below the kernel's own
/// threads.
const PRIORITY: u8 = 50;

/// A program that ends when this value is dropped.
pub(crate) struct Guarded {
    child: Child,
    gone: OwnedFd,
    ended: Option<ExitStatus>,
}

impl Guarded {
    /// Starts a program in a process group of its own, so that only the bench handles Ctrl-C.
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

    /// Returns the process of the program, to read its output.
    pub(super) fn child(&mut self) -> &mut Child {
        &mut self.child
    }

    /// Waits for the end of the program. Returns `None` at the deadline.
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

    /// Asks the program to end.
    pub(super) fn ask_to_end(&self) {
        if self.ended.is_none() {
            // The process was not reaped yet, so the PID is still its own.
            let _ = kill_process(Pid::from_child(&self.child), Signal::TERM);
        }
    }

    /// Waits for an event. Returns `false` at the deadline.
    fn wait_for_an_event(&mut self, deadline: Instant, stop: Option<&Stop>) -> bool {
        let left = deadline.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return false;
        }
        let mut polled = vec![PollFd::new(&self.gone, PollFlags::IN)];
        if let Some(stop) = stop {
            polled.push(PollFd::from_borrowed_fd(stop.as_fd(), PollFlags::IN));
        }
        // The event is checked below and by the caller.
        let _ = poll(&mut polled, Timespec::try_from(left).ok().as_ref());
        self.ended();
        true
    }

    /// Returns the exit status if the program has ended.
    pub(crate) fn ended(&mut self) -> Option<ExitStatus> {
        if let Ok(Some(status)) = self.child.try_wait() {
            self.ended = Some(status);
        }
        self.ended
    }

    /// Asks the program to end, and kills it after `patience`.
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

/// Ends programs together. All are asked first, so that they do not wait for each other.
pub(super) fn end_all(programs: Vec<Guarded>) {
    programs.iter().for_each(Guarded::ask_to_end);
}

/// Core and scheduling of a program.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Placement {
    /// The only core that it may use.
    pub(super) core: Option<usize>,
    /// True for FIFO scheduling.
    pub(super) fifo: bool,
}

/// Arguments of `latency-part guard`.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct GuardArgs {
    /// Process ID of the bench that started it
    parent: i32,
    /// Core to run on
    #[arg(long)]
    core: Option<usize>,
    /// Run under FIFO scheduling
    #[arg(long)]
    fifo: bool,
    /// Program and its arguments
    #[arg(last = true, required = true)]
    program: Vec<std::ffi::OsString>,
}

/// Returns a command that executes a program under guard, with the given placement.
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

/// Replaces this process with the program.
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
    // This is the last change before the program starts. The program inherits it.
    ensure!(
        !args.fifo || arrangement::run_before_others(PRIORITY),
        "FIFO scheduling is not allowed"
    );
    let mut words = args.program.iter();
    let program = words.next().context("no program was named")?;
    let cause = Command::new(program).args(words).exec();
    Err(cause).with_context(|| format!("{} cannot be run", program.display()))
}

/// Checks whether FIFO scheduling is allowed. The error says why it is not.
pub(super) fn fifo_allowed() -> Result<(), String> {
    // In a separate thread, so that the bench itself does not change.
    let tried = std::thread::spawn(|| arrangement::run_before_others(PRIORITY)).join();
    match tried {
        Ok(true) => Ok(()),
        _ => Err(format!(
            "FIFO scheduling is not allowed: `ulimit -r {PRIORITY}`, or see `lariat doctor`"
        )),
    }
}
