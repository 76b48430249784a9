//! `summary.json`: the complete measurement as one object with stable keys.

use crate::{FinalCounts, Machine};
use serde::Serialize;

/// The contents of `summary.json`. A figure without a single sample is `null`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary {
    /// The version of these keys: 2. Version 2 added `finished`, `frames.lost.sink`,
    /// `frames.lost.bridge` and `frames.at_restart`.
    pub schema: u32,
    /// True if the run has ended. A summary that is written during a run, every 10 s, shows the
    /// state at that time.
    pub finished: bool,
    /// Number of frames, and the losses.
    pub frames: Frames,
    /// Missing depth images, if the chain uses depth. They are known at the end of the chain.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth: Option<Depth>,
    /// Latencies in microseconds.
    pub latency_us: Latencies,
    /// Distances from the truth in pixels.
    pub error_px: Errors,
    /// Number of late frames.
    pub deadline: Deadline,
    /// The machine on which the figures were measured.
    pub machine: Machine,
}

/// Counts of frames. Always, `published` = `received` + `lost.capture` + `lost.mask` +
/// `lost.extract` + `lost.bridge` + `lost.fit` + `lost.sink`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Frames {
    /// Frames that capture sent, as far as known.
    pub published: u64,
    /// Descriptor messages received, each counted once.
    pub received: u64,
    /// Received messages with a visible curve: status `Ok` or `Partial`.
    pub with_curve: u64,
    /// Frames lost on each link.
    pub lost: Lost,
    /// Losses during a restart of a stage, which `lost` includes.
    pub at_restart: AtRestart,
}

/// Frames and depth images, or second views, that were not paired. An unknown figure is `null`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Depth {
    /// Frames without a depth image or second view when they were fitted. Their ropes are described
    /// in the image only.
    pub frames_without: Option<u64>,
    /// Images that the chain's own depth camera delivered.
    pub images: Option<u64>,
    /// Images that the camera numbered but did not deliver.
    pub lost: Option<u64>,
    /// Delivered images that belonged to no frame.
    pub unpaired: Option<u64>,
}

impl Depth {
    /// Returns the counts that the stages reported, or `None` without depth.
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

/// Frames lost after a stage while that stage or another was restarted.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct AtRestart {
    /// Frames sent by capture but never by extract.
    pub capture: u64,
    /// Frames sent by extract but never by fit.
    pub extract: u64,
    /// Frames sent by fit but never received here.
    pub fit: u64,
}

/// Frames lost, by link.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Lost {
    /// Frames numbered by the source but never sent by capture.
    pub source: u64,
    /// Frames sent by capture but never by extract, except those in `mask`.
    pub capture: u64,
    /// Frames that extract skipped because their external masks were late. The number is known at
    /// the end of the chain; until then these frames are in `capture`.
    pub mask: u64,
    /// Frames sent by extract but never by fit.
    pub extract: u64,
    /// Frames sent by fit but never written by the bridge on this machine, if the chain runs on
    /// another machine.
    pub bridge: u64,
    /// Frames sent by fit but never received here, although a sink was running. If the chain runs
    /// on another machine, frames count as sent here once the bridge on this machine has written
    /// them.
    pub fit: u64,
    /// Frames sent by fit while no sink was running, until another one continued. Includes messages
    /// that the last sink received but could not save.
    pub sink: u64,
}

impl Lost {
    /// Returns the sum of all losses.
    pub fn total(&self) -> u64 {
        self.source + self.capture + self.mask + self.extract + self.bridge + self.fit + self.sink
    }
}

/// Latencies of frames: the total, the work of each stage, and the waits between stages.
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
    /// Time that 90 % of the times do not exceed.
    pub p90: Option<f64>,
    /// Time that 99 % of the times do not exceed.
    pub p99: Option<f64>,
    /// Time that 99.9 % of the times do not exceed.
    pub p999: Option<f64>,
    /// The longest time.
    pub max: Option<f64>,
    /// The mean.
    pub mean: Option<f64>,
}

/// Distances from the truth.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Errors {
    /// Distances of the points of centerlines.
    pub centerline: Distances,
    /// Distances of points on the fitted curves.
    pub curve: Distances,
}

/// Distances of points from the true centerline, over all points of all frames, in pixels.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Distances {
    /// The mean.
    pub mean: Option<f64>,
    /// Distance that 95 % of the distances do not exceed.
    pub p95: Option<f64>,
    /// Distance that 99.9 % of the distances do not exceed. A single frame cannot change this
    /// figure.
    pub p999: Option<f64>,
    /// The largest distance.
    pub max: Option<f64>,
}

/// The deadline, and the frames that missed it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Deadline {
    /// Time from exposure to reception, in microseconds.
    pub us: Option<f64>,
    /// Received frames that took longer; `None` without a deadline.
    pub missed: Option<u64>,
}
