//! `[run]`: the chain as a whole.

use crate::settings::Arrangement;
use std::path::PathBuf;
use std::time::Duration;

/// When to restart a stage in its place while the others continue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Restart {
    /// Never: the chain ends with it.
    Never,
    /// When it died, hangs, or was told to end by another than its chain.
    OnFailure,
    /// Also when its source has ended.
    Always,
}

pub(super) const RESTARTS: [(&str, Restart); 3] = [
    ("never", Restart::Never),
    ("on-failure", Restart::OnFailure),
    ("always", Restart::Always),
];

/// The chain as a whole.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// The name of the camera chain: 1 to 32 of a–z, 0–9, `_` and `-`.
    pub rig: String,
    /// Whether capture waits for slow readers, so that no frame is lost.
    pub lossless: bool,
    /// How long to run; without it, until the source ends or the user says so.
    pub duration: Option<Duration>,
    /// How many frames to capture at most.
    pub frames: Option<u64>,
    /// The folder for the report; without it, none is written.
    pub out: Option<PathBuf>,
    /// The file for the timeline of the last frames; without it, none is written.
    pub trace: Option<PathBuf>,
    /// The latency that counts as a miss; without it, the frame period.
    pub deadline: Option<Duration>,
    /// The recording; without it, none is made.
    pub record: Option<PathBuf>,
    /// Whether capture, extract and fit are threads of one process.
    pub fuse: bool,
    /// Runs unattended: no live line, and stages are restarted unless `restart` says otherwise.
    pub daemon: bool,
    /// When to restart a stage.
    pub restart: Restart,
    /// How often at most within the window before the chain gives up.
    pub max_restarts: u32,
    /// The window.
    pub restart_window: Duration,
    /// How long a stage may stand still while work waits for it, before it is taken to hang.
    pub hang: Duration,
    /// Time limit for a stage to become ready.
    pub start_limit: Duration,
    /// Whether a change of the settings file is taken while the chain runs.
    pub watch: bool,
    /// How the stages are arranged on the machine.
    pub arrangement: Arrangement,
}

impl Run {
    /// True if stages are restarted. Threads of one process are not.
    pub fn restarts_stages(&self) -> bool {
        self.restart != Restart::Never && !self.fuse
    }

    /// How long to run, in nanoseconds.
    pub fn duration_ns(&self) -> Option<u64> {
        self.duration.map(nanoseconds)
    }
}

pub(crate) fn nanoseconds(time: Duration) -> u64 {
    u64::try_from(time.as_nanos()).unwrap_or(u64::MAX)
}

impl Default for Run {
    fn default() -> Self {
        Self {
            rig: "default".to_owned(),
            lossless: false,
            duration: None,
            frames: None,
            out: None,
            trace: None,
            record: None,
            deadline: None,
            fuse: false,
            daemon: false,
            restart: Restart::Never,
            max_restarts: 10,
            restart_window: Duration::from_secs(60),
            hang: Duration::from_secs(5),
            start_limit: Duration::from_secs(20),
            watch: false,
            arrangement: Arrangement::default(),
        }
    }
}
