//! `[run]`: the chain as a whole.

use crate::settings::Arrangement;
use std::path::PathBuf;
use std::time::Duration;

/// When to restart a stage while the others continue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Restart {
    /// Never: the chain ends with the stage.
    Never,
    /// If the stage died, hangs, or was ended by another process than its chain.
    OnFailure,
    /// As with [`OnFailure`](Self::OnFailure), and also if the source has ended.
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
    /// Name of the camera chain: 1 to 32 of a–z, 0–9, `_` and `-`.
    pub rig: String,
    /// True if capture waits for slow readers, so that no frame is lost.
    pub lossless: bool,
    /// Running time. Without it, the chain runs until its source ends or it is stopped.
    pub duration: Option<Duration>,
    /// Maximum number of frames to capture.
    pub frames: Option<u64>,
    /// Folder for the report. Without it, no report is written.
    pub out: Option<PathBuf>,
    /// File for the timeline of the last frames. Without it, no timeline is written.
    pub trace: Option<PathBuf>,
    /// Latency above which a frame is late. Without it, the frame period.
    pub deadline: Option<Duration>,
    /// File for the recording. Without it, no recording is made.
    pub record: Option<PathBuf>,
    /// True if capture, extract and fit are threads of one process.
    pub fuse: bool,
    /// True to run unattended: no live line, and stages restart unless `restart` says otherwise.
    pub daemon: bool,
    /// When to restart a stage.
    pub restart: Restart,
    /// Maximum number of restarts within the window before the chain gives up.
    pub max_restarts: u32,
    /// Length of the window for `max_restarts`.
    pub restart_window: Duration,
    /// Time without progress, while work waits, after which a stage counts as hanging.
    pub hang: Duration,
    /// Time limit for a stage to become ready.
    pub start_limit: Duration,
    /// True if changes of the settings file are applied while the chain runs.
    pub watch: bool,
    /// Arrangement of the stages on the machine.
    pub arrangement: Arrangement,
}

impl Run {
    /// Returns true if stages are restarted. Threads of one process are not.
    pub fn restarts_stages(&self) -> bool {
        self.restart != Restart::Never && !self.fuse
    }

    /// Returns the running time in nanoseconds.
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
