//! What is known of a rig, as plain figures: whoever draws it asks nobody.

use lariat_sink::Step;
use lariat_wire::{Place, Status};

/// A screenful.
#[derive(Debug, Clone, Default)]
pub struct View {
    /// The rig that is shown; `None` if there is none.
    pub rig: Option<String>,
    /// Its number among all, from 1, and how many there are.
    pub place: (usize, usize),
    /// Whether it is held still.
    pub is_paused: bool,
    /// Why nothing can be shown of it, as a sentence.
    pub obstacle: Option<String>,
    /// Whether its writers wait for slow readers.
    pub is_lossless: bool,
    /// Shared memory of the rig's channels, 10⁶ bytes.
    pub shared_mb: Option<f64>,
    /// By how much its stamps may be off, µs, if a bridge brings it here from a machine with a clock of its own.
    pub clock_bound_us: Option<f64>,
    /// Its processes, in the order of the way.
    pub stages: Vec<StageRow>,
    /// Of the frames of this many last seconds.
    pub window_s: u64,
    /// How long each step took in them.
    pub steps: Vec<StepRow>,
    /// What was lost.
    pub lost: Losses,
    /// The newest ropes.
    pub shape: Option<Shape>,
}

/// A process of the rig.
#[derive(Debug, Clone, Default)]
pub struct StageRow {
    /// What it is called.
    pub stage: String,
    /// Its process.
    pub pid: u32,
    /// Of one core.
    pub cpu_percent: Option<f64>,
    /// Its own memory, without what it shares: 10⁶ bytes.
    pub own_mb: Option<f64>,
    /// What it sends a second.
    pub frames_per_s: Option<f64>,
}

/// How long a step of the way takes, µs.
#[derive(Debug, Clone, Copy)]
pub struct StepRow {
    /// The step.
    pub step: Step,
    /// Median.
    pub p50: f64,
    /// What nine of ten do not exceed.
    pub p90: f64,
    /// What 99 of 100 do not exceed.
    pub p99: f64,
    /// The longest.
    pub max: f64,
}

/// Frames lost since the rig is looked at.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Losses {
    /// Numbered by the source, never sent.
    pub source: u64,
    /// Between capture and extract.
    pub capture: u64,
    /// Between extract and fit.
    pub extract: u64,
    /// On another machine: between fit and what the bridge wrote there.
    pub bridge: u64,
}

/// The newest descriptors.
#[derive(Debug, Clone, Default)]
pub struct Shape {
    /// The frame's number.
    pub frame: u64,
    /// Of the image; 0 if the source has none to give.
    pub width: u32,
    /// Likewise.
    pub height: u32,
    /// What the ropes are measured in.
    pub unit: &'static str,
    /// Whether the ropes are in pixels of the image.
    pub is_of_image: bool,
    /// How long ago it was taken.
    pub age_s: f64,
    /// The ropes.
    pub ropes: Vec<Rope>,
    /// Least x, least y, greatest x, greatest y that ropes had, where there is no image to hold them.
    pub reach: [f64; 4],
}

/// A rope as it is drawn and told.
#[derive(Debug, Clone, Default)]
pub struct Rope {
    /// Its number, which it keeps.
    pub track: u32,
    /// `None`: one that this release does not know.
    pub status: Option<Status>,
    /// Whether its ends meet.
    pub is_closed: bool,
    /// The kind of its curve.
    pub basis: &'static str,
    /// The number of the curve's control points, or of its coefficients.
    pub control_point_count: u32,
    /// Arc length.
    pub length: f64,
    /// How far the curve lies from its points.
    pub rms: f64,
    /// How sure it is that it is a rope, 0 to 1.
    pub confidence: f32,
    /// Its curve does not lie on its points.
    pub is_coarse: bool,
    /// How long before the image it was last seen.
    pub age_s: f64,
    /// Where its control points are, if it has such.
    pub control_points: Vec<[f64; 2]>,
    /// Along the curve; none, if the descriptor means no curve.
    pub points: Vec<[f64; 2]>,
    /// What is known of it in space; `None` where the chain has no depth camera, or what it says has not come.
    pub in_space: Option<InSpace>,
}

/// A rope in space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InSpace {
    /// Whether it is known where it is; `None`: a word that this release does not know.
    pub place: Option<Place>,
    /// Arc length, mm.
    pub length_mm: f64,
}
