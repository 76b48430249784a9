//! The state of a rig as plain figures, complete for whoever draws it.

use lariat_sink::Step;
use lariat_wire::{Place, Status};

/// Everything that a screen shows.
#[derive(Debug, Clone, Default)]
pub struct View {
    /// Rig that is shown; `None` if there is none.
    pub rig: Option<String>,
    /// Number of the rig among all, from 1, and the number of rigs.
    pub place: (usize, usize),
    /// True if the view is paused.
    pub is_paused: bool,
    /// Why nothing of the rig can be shown, as a sentence.
    pub obstacle: Option<String>,
    /// True if the rig's writers wait for slow readers.
    pub is_lossless: bool,
    /// Shared memory of the rig's channels, in 10⁶ bytes.
    pub shared_mb: Option<f64>,
    /// Maximum error of the rig's timestamps in µs, if a bridge brings it from a machine with its
    /// own clock.
    pub clock_bound_us: Option<f64>,
    /// Processes of the rig, in the order of the pipeline.
    pub stages: Vec<StageRow>,
    /// Number of most recent seconds that `steps` covers.
    pub window_s: u64,
    /// Duration of each step in the frames of these seconds.
    pub steps: Vec<StepRow>,
    /// Frames that were lost.
    pub lost: Losses,
    /// Newest ropes.
    pub shape: Option<Shape>,
}

/// A process of the rig.
#[derive(Debug, Clone, Default)]
pub struct StageRow {
    /// Name of the stage.
    pub stage: String,
    /// Process ID.
    pub pid: u32,
    /// CPU use, in percent of one core.
    pub cpu_percent: Option<f64>,
    /// Memory without shared memory, in 10⁶ bytes.
    pub own_mb: Option<f64>,
    /// Frames sent per second.
    pub frames_per_s: Option<f64>,
}

/// Duration of a step, in µs.
#[derive(Debug, Clone, Copy)]
pub struct StepRow {
    /// The step.
    pub step: Step,
    /// Median.
    pub p50: f64,
    /// 90th percentile.
    pub p90: f64,
    /// 99th percentile.
    pub p99: f64,
    /// Maximum.
    pub max: f64,
}

/// Frames lost since the program began to watch the rig.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Losses {
    /// Frames that the source numbered but never sent.
    pub source: u64,
    /// Frames lost between capture and extract.
    pub capture: u64,
    /// Frames lost between extract and fit.
    pub extract: u64,
    /// Frames that fit sent but the bridge did not write, for a rig on another machine.
    pub bridge: u64,
}

/// The newest descriptors.
#[derive(Debug, Clone, Default)]
pub struct Shape {
    /// Number of the frame.
    pub frame: u64,
    /// Width of the image; 0 if the source provides none.
    pub width: u32,
    /// Height of the image; 0 if the source provides none.
    pub height: u32,
    /// Unit in which the ropes are measured.
    pub unit: &'static str,
    /// True if the ropes are in pixels of the image.
    pub is_of_image: bool,
    /// Time since the exposure, in seconds.
    pub age_s: f64,
    /// Ropes of the frame.
    pub ropes: Vec<Rope>,
    /// Minimum x, minimum y, maximum x and maximum y of all ropes until now, for drawing without an
    /// image.
    pub reach: [f64; 4],
}

/// A rope to be drawn and described.
#[derive(Debug, Clone, Default)]
pub struct Rope {
    /// Number of the rope, which stays the same in all frames.
    pub track: u32,
    /// Status of the rope; `None` if this release does not know it.
    pub status: Option<Status>,
    /// True if its ends meet.
    pub is_closed: bool,
    /// Kind of the curve.
    pub basis: &'static str,
    /// Number of the curve's control points, or of its coefficients.
    pub control_point_count: u32,
    /// Arc length, in the unit of the ropes.
    pub length: f64,
    /// Root mean square distance of the curve from its points.
    pub rms: f64,
    /// Confidence that it is a rope, 0 to 1.
    pub confidence: f32,
    /// True if the curve does not fit its points.
    pub is_coarse: bool,
    /// Seconds since the rope was last seen, at the time of the image.
    pub age_s: f64,
    /// Positions of the control points, if it has any.
    pub control_points: Vec<[f64; 2]>,
    /// Points along the curve; empty if the descriptor describes no curve.
    pub points: Vec<[f64; 2]>,
    /// The rope in 3-D; `None` if the chain has no depth camera, or nothing has come yet.
    pub in_space: Option<InSpace>,
}

/// A rope in 3-D.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InSpace {
    /// State of its position; `None` if this release does not know the code.
    pub place: Option<Place>,
    /// Arc length, mm.
    pub length_mm: f64,
}
