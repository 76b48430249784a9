//! The environment of a bench: a domain and a folder of its own, which keep it from disturbing
//! other rigs and are removed at the end.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use lariat_wire::Domain;
use rustix::thread::CpuSet;
use tempfile::TempDir;

use super::guard::{self, Guarded, Placement};
use lariat_chain::stop::Stop;

/// A domain, a folder, and everything else that each measurement needs.
pub(super) struct Workplace {
    pub(super) stop: Stop,
    /// Name of the domain.
    pub(super) domain: String,
    folder: TempDir,
    itself: PathBuf,
    lariat: PathBuf,
    /// The cores that this process may use.
    pub(super) cores: Vec<usize>,
    pub(super) python: PathBuf,
}

impl Workplace {
    pub(super) fn open(python: PathBuf) -> Result<Self> {
        let cores = rustix::thread::sched_getaffinity(None)
            .context("the kernel does not say which cores may be used")?;
        Ok(Self {
            stop: Stop::on_signals()?,
            domain: format!("b{}", std::process::id()),
            folder: TempDir::with_prefix("lariat-bench-")
                .context("no temporary folder could be made")?,
            itself: std::env::current_exe()
                .context("lariat-bench cannot find its own executable")?,
            lariat: crate::program::lariat()?,
            cores: (0..CpuSet::MAX_CPU)
                .filter(|&core| cores.is_set(core))
                .collect(),
            python,
        })
    }

    /// Returns a path in the folder.
    pub(super) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Returns the command of a guarded program.
    pub(super) fn program(&self, placement: Placement, program: &Path) -> Command {
        let mut command = guard::command(&self.itself, placement);
        command
            .arg(program)
            // The folder contains no settings that would be read.
            .current_dir(self.folder.path())
            .env("LARIAT_DOMAIN", &self.domain)
            .env_remove(lariat_chain::stages::status::STATUS_FD)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        command
    }

    /// Returns the command of a guarded `lariat`.
    pub(super) fn lariat(&self, placement: Placement) -> Command {
        self.program(placement, &self.lariat)
    }

    /// Returns the command of a guarded part of the measurement: this program again.
    pub(super) fn part(&self, placement: Placement, name: &str) -> Command {
        let mut command = self.program(placement, &self.itself);
        command.args(["latency-part", name]);
        command
    }

    /// Waits until a program has ended successfully. Otherwise the error is its last message.
    pub(super) fn finish(&self, mut program: Guarded, within: Duration, what: &str) -> Result<()> {
        let said = program.child().stderr.take().map(|mut stderr| {
            std::thread::spawn(move || {
                let mut text = Vec::new();
                let _ = stderr.read_to_end(&mut text);
                String::from_utf8_lossy(&text).into_owned()
            })
        });
        let status = program.wait(Instant::now() + within, &self.stop)?;
        drop(program);
        let said = said
            .and_then(|thread| thread.join().ok())
            .unwrap_or_default();
        let last = said.lines().rfind(|line| !line.trim().is_empty());
        match (status, last) {
            (Some(status), _) if status.success() => Ok(()),
            (None, _) => bail!("{what} did not end within {} s", within.as_secs()),
            (Some(_), Some(line)) => bail!("{what} failed: {line}"),
            (Some(status), None) => bail!("{what} failed ({status})"),
        }
    }

    /// Sleeps for `time`. Returns an error if a signal arrives first.
    pub(super) fn sleep(&self, time: Duration) -> Result<()> {
        let due_ns = lariat_wire::now_ns() + time.as_nanos() as u64;
        anyhow::ensure!(
            self.stop.sleep_until(due_ns),
            "a signal stopped the measurement"
        );
        Ok(())
    }
}

impl Drop for Workplace {
    fn drop(&mut self) {
        // Leftovers of killed programs are removed with the domain.
        drop(Domain::named(&self.domain));
        let _ = std::fs::remove_dir_all(format!("/tmp/lariat-{}", self.domain));
    }
}
