//! What a controller is told about its robot, its target and its ways: a file that the two processes share.

use std::path::Path;

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};

/// Points of a centerline that are steered by where no descriptor is.
pub(super) const RAW_POINTS: usize = 24;

/// What is steered by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Features {
    /// The control points of the descriptor.
    Descriptor,
    /// [`RAW_POINTS`] points of the centerline.
    Points,
}

/// How the Jacobian is kept up to date.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Learner {
    Kalman,
    Broyden,
}

/// What a controller is told.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Job {
    pub wanted: Wanted,
    pub features: Features,
    pub learner: Learner,
    /// λ of the law, 1/s.
    pub gain: f64,
    /// Steer by the shape as it should be now, not as it was seen.
    pub look_ahead: bool,
    /// How much later than it came a shape is acted on: a slower link, in ms.
    pub delay_ms: f64,
    /// The time between two images, s.
    pub period_s: f64,
}

/// The shape that is wanted: points along the part of the rope that is seen. And by which robot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) enum Wanted {
    /// In the picture, px.
    InPlane { target: Vec<[f64; 2]>, robot: Robot },
    /// In the robot's frame, mm.
    InSpace {
        target: Vec<[f64; 3]>,
        robot: SpaceRobot,
    },
}

/// What the robot knows of itself in space.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct SpaceRobot {
    /// Where each gripper is at the start, mm, and the direction in which the rope leaves it.
    pub start: Vec<[[f64; 3]; 2]>,
    /// mm/s along each axis, rad/s about each of its own that is across the rope.
    pub speeds: [f64; 2],
    /// Lowest and highest x, y and z, mm.
    pub workspace_mm: [[f64; 2]; 3],
    /// How far apart the grippers may be, mm.
    pub longest_apart_mm: f64,
}

/// What the robot knows of itself.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Robot {
    /// Where each gripper is at the start: x px, y px, θ rad.
    pub start: Vec<[f64; 3]>,
    /// px/s, px/s, rad/s.
    pub speeds: [f64; 3],
    /// Lowest and highest x, and y, px.
    pub workspace_px: [[f64; 2]; 2],
    /// How far apart the grippers may be, px.
    pub longest_apart_px: f64,
}

impl Job {
    pub(super) fn write(&self, path: &Path) -> Result<()> {
        let text = serde_json::to_string(self).context("a job that cannot be written")?;
        std::fs::write(path, text).with_context(|| format!("{} was not written", path.display()))
    }

    pub(super) fn read(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path)
            .with_context(|| format!("{} could not be read", path.display()))?;
        serde_json::from_str(&text).with_context(|| format!("{} is no job", path.display()))
    }
}
