//! `summary.json`: the whole measurement in one object whose keys are stable.

use crate::{FinalCounts, Machine};
use serde::Serialize;

/// The measurement, as `summary.json` has it. A figure without a single sample is `null`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary {
    /// The version of these keys: 2. With 2 came `finished`, `frames.lost.sink`, `frames.lost.bridge` and `frames.at_restart`.
    pub schema: u32,
    /// Whether the run has ended. A summary that was written while it went on, as every 10 s, says how it stood then.
    pub finished: bool,
    /// How many frames, and where they went.
    pub frames: Frames,
    /// What depth images were missing, where there are any. FrameTruth at the chain's end.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth: Option<Depth>,
    /// Where the time went, in microseconds.
    pub latency_us: Latencies,
    /// How far from the truth, in pixels.
    pub error_px: Errors,
    /// How many were late.
    pub deadline: Deadline,
    /// What it was measured on.
    pub machine: Machine,
}

/// `published` = `received` + `lost.capture` + `lost.mask` + `lost.extract` + `lost.bridge` + `lost.fit` +
/// `lost.sink`, always.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Frames {
    /// What capture sent, as far as known.
    pub published: u64,
    /// Descriptor messages that came, each counted once.
    pub received: u64,
    /// Of these, the ones with a curve that was seen: status `Ok` or `Partial`.
    pub with_curve: u64,
    /// What was lost on each link.
    pub lost: Lost,
    /// The part of these that was lost while a stage was restarted.
    pub at_restart: AtRestart,
}

/// Frames and depth images, or second views, that did not find each other. A figure that nobody knows is `null`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Depth {
    /// Frames that had no depth image or second view when they were fitted: their ropes are described in the image only.
    pub frames_without: Option<u64>,
    /// Images that the chain's own depth camera gave.
    pub images: Option<u64>,
    /// Images that it numbered and did not give.
    pub lost: Option<u64>,
    /// Images that it gave and that were no frame's.
    pub unpaired: Option<u64>,
}

impl Depth {
    /// By what the stages said; `None` if there is no depth.
    pub(crate) fn of(sent: &FinalCounts) -> Option<Self> {
        let (frames_without, depths) = (sent.depthless, sent.depths);
        (frames_without.is_some() || depths.is_some()).then_some(Self {
            frames_without,
            images: depths.map(|depths| depths.images),
            lost: depths.map(|depths| depths.lost),
            unpaired: depths.map(|depths| depths.unpaired),
        })
    }
}

/// Frames lost after a stage while it or another was restarted in its place.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct AtRestart {
    /// Sent by capture, never by extract.
    pub capture: u64,
    /// Sent by extract, never by fit.
    pub extract: u64,
    /// Sent by fit, never received here.
    pub fit: u64,
}

/// Frames lost, by the link they were lost on.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Lost {
    /// Numbered by the source, never sent by capture.
    pub source: u64,
    /// Sent by capture, never by extract, for another reason than the next.
    pub capture: u64,
    /// Skipped by extract, as the frame's mask, made by another process, came too late. FrameTruth at the chain's end; until
    /// then these are in `capture`.
    pub mask: u64,
    /// Sent by extract, never by fit.
    pub extract: u64,
    /// On another machine: sent by fit, never written by the bridge there.
    pub bridge: u64,
    /// Sent by fit (on another machine: written by the bridge there), never received here, though there was a sink.
    pub fit: u64,
    /// Sent by fit while the sink was dead, until another one went on where it had stopped; with what it had received and could
    /// not write down any more.
    pub sink: u64,
}

impl Lost {
    /// All of them.
    pub fn total(&self) -> u64 {
        self.source + self.capture + self.mask + self.extract + self.bridge + self.fit + self.sink
    }
}

/// Work and waits of a frame on its way.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Latencies {
    /// Exposed → received.
    pub total: Spread,
    /// Exposed → captured.
    pub capture: Spread,
    /// Extract's own work.
    pub extract: Spread,
    /// Fit's own work.
    pub fit: Spread,
    /// Captured → extract begins.
    pub wait_extract: Spread,
    /// Extracted → fit begins.
    pub wait_fit: Spread,
    /// Fitted → received.
    pub wait_sink: Spread,
}

/// A distribution of times, in microseconds.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Spread {
    /// The median.
    pub p50: Option<f64>,
    /// 90 % are no longer.
    pub p90: Option<f64>,
    /// 99 % are no longer.
    pub p99: Option<f64>,
    /// 99.9 % are no longer.
    pub p999: Option<f64>,
    /// The longest.
    pub max: Option<f64>,
    /// The mean.
    pub mean: Option<f64>,
}

/// Distances from the truth.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Errors {
    /// The centerlines' points.
    pub centerline: Distances,
    /// Points of the fitted curves.
    pub curve: Distances,
}

/// Distances of points from the true centerline, over all points of all frames, in pixels.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Distances {
    /// The mean.
    pub mean: Option<f64>,
    /// 95 % are no farther.
    pub p95: Option<f64>,
    /// 99.9 % are no farther: what a single frame cannot move.
    pub p999: Option<f64>,
    /// The farthest.
    pub max: Option<f64>,
}

/// The deadline and what missed it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Deadline {
    /// From exposure to reception, in microseconds.
    pub us: Option<f64>,
    /// Received frames that took longer; `None` without a deadline.
    pub missed: Option<u64>,
}
