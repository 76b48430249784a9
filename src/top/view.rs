//! What the screen shows, as plain figures: whoever draws it asks nobody.

use lariat_sink::Step;
use lariat_wire::Status;

/// A screenful.
#[derive(Debug, Clone, Default)]
pub(super) struct View {
    /// The rig that is shown; `None` if there is none.
    pub(super) rig: Option<String>,
    /// Its number among all, from 1, and how many there are.
    pub(super) place: (usize, usize),
    pub(super) is_paused: bool,
    /// Why nothing can be shown of it, as a sentence.
    pub(super) obstacle: Option<String>,
    pub(super) is_lossless: bool,
    /// Shared memory of the rig's channels, 10⁶ bytes.
    pub(super) shared_mb: Option<f64>,
    pub(super) stages: Vec<StageRow>,
    /// Of the frames of this many last seconds.
    pub(super) window_s: u64,
    pub(super) steps: Vec<StepRow>,
    pub(super) lost: Losses,
    pub(super) shape: Option<Shape>,
}

/// A process of the rig.
#[derive(Debug, Clone, Default)]
pub(super) struct StageRow {
    pub(super) stage: String,
    pub(super) pid: u32,
    /// Of one core.
    pub(super) cpu_percent: Option<f64>,
    /// Its own memory, without what it shares: 10⁶ bytes.
    pub(super) own_mb: Option<f64>,
    /// What it sends a second.
    pub(super) frames_per_s: Option<f64>,
}

/// How long a step of the way takes, µs.
#[derive(Debug, Clone, Copy)]
pub(super) struct StepRow {
    pub(super) step: Step,
    pub(super) p50: f64,
    pub(super) p90: f64,
    pub(super) p99: f64,
    pub(super) max: f64,
}

/// Frames lost since the rig is looked at.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Losses {
    pub(super) source: u64,
    pub(super) capture: u64,
    pub(super) extract: u64,
}

/// The newest descriptors.
#[derive(Debug, Clone, Default)]
pub(super) struct Shape {
    pub(super) frame: u64,
    /// Of the image; 0 if the source has none to give.
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) unit: &'static str,
    /// Whether the ropes are in pixels of the image.
    pub(super) is_of_image: bool,
    /// How long ago it was taken.
    pub(super) age_s: f64,
    pub(super) ropes: Vec<Rope>,
    /// Least x, least y, greatest x, greatest y that ropes had, where there is no image to hold them.
    pub(super) reach: [f64; 4],
}

/// A rope as it is drawn and told.
#[derive(Debug, Clone, Default)]
pub(super) struct Rope {
    pub(super) track: u32,
    /// `None`: one that this release does not know.
    pub(super) status: Option<Status>,
    pub(super) is_closed: bool,
    pub(super) basis: &'static str,
    pub(super) order: u32,
    pub(super) length: f64,
    pub(super) rms: f64,
    /// How sure it is that it is a rope, 0 to 1.
    pub(super) confidence: f32,
    /// Its curve does not lie on its points.
    pub(super) is_coarse: bool,
    /// How long before the image it was last seen.
    pub(super) age_s: f64,
    pub(super) control_points: Vec<[f64; 2]>,
    /// Along the curve; none, if the descriptor means no curve.
    pub(super) points: Vec<[f64; 2]>,
}
