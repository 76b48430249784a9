//! The controller's job: its robot, its target and its options, in a file that the two processes
//! share.

use std::path::Path;

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};

/// Number of centerline points used as features in place of a descriptor.
pub(super) const RAW_POINTS: usize = 24;

/// The features that the controller steers by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Features {
    /// The control points of the descriptor.
    Descriptor,
    /// [`RAW_POINTS`] points of the centerline.
    Points,
}

/// Method that updates the Jacobian.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Learner {
    Kalman,
    Broyden,
}

/// The job of a controller.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Job {
    pub wanted: Wanted,
    pub features: Features,
    pub learner: Learner,
    /// λ of the control law, 1/s.
    pub gain: f64,
    /// Steer by the predicted current shape instead of the shape as observed.
    pub look_ahead: bool,
    /// Delay of each observation, which simulates a slower link, in ms.
    pub delay_ms: f64,
    /// Time between two images, s.
    pub period_s: f64,
}

/// Target shape as points along the visible part of the rope, and the robot.
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

/// The robot's own data in 3-D.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct SpaceRobot {
    /// Initial position of each gripper, mm, and the direction in which the rope leaves it.
    pub start: Vec<[[f64; 3]; 2]>,
    /// Speed limits: mm/s along each axis, rad/s about each of the gripper's axes across the rope.
    pub speeds: [f64; 2],
    /// Lowest and highest x, y and z, mm.
    pub workspace_mm: [[f64; 2]; 3],
    /// Maximum distance between the grippers, mm.
    pub longest_apart_mm: f64,
}

/// The robot's own data.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Robot {
    /// Initial pose of each gripper: x px, y px, θ rad.
    pub start: Vec<[f64; 3]>,
    /// Speed limits: px/s, px/s, rad/s.
    pub speeds: [f64; 3],
    /// Lowest and highest x, and y, px.
    pub workspace_px: [[f64; 2]; 2],
    /// Maximum distance between the grippers, px.
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
