//! The robot's limits.

use crate::dimensions;
use crate::error::ServoError;
use crate::options::within;
use crate::setters::setters;

/// The grippers, their positions and their limits. Coordinates of a gripper are x px, y px, θ rad;
/// in 3-D (`A` is 6) x, y and z in mm, and three turns in rad. Each field has a method of the same
/// name that sets it: `Robot::default().grippers(2)`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Robot<const A: usize = 3> {
    /// Number of grippers, 1 or 2. Default: 1.
    pub grippers: usize,
    /// Poses at the start. Only [workspaces](Self::workspaces) and
    /// [`longest_apart_px`](Self::longest_apart_px) depend on them; without these, any pose will
    /// do. Default: 0.
    pub start: [[f64; A]; 2],
    /// Speed limits of each gripper: px/s, px/s, rad/s, up to 10⁵. A coordinate with the limit 0
    /// does not move: `[100, 100, 0]` is a gripper that cannot turn. Default: 100, 100, 1; in 3-D
    /// 100 along each axis, and 1 about each.
    pub speeds: [f64; A],
    /// Acceleration limits of each gripper: px/s², px/s², rad/s². A hold is immediate and ignores
    /// them. Default: none.
    pub accelerations: Option<[f64; A]>,
    /// Allowed region of each gripper. Default: anywhere.
    pub workspaces: [Workspace<A>; 2],
    /// Maximum distance between two grippers, px. If it is a little less than the length of the
    /// rope between them, the rope is never pulled taut. Default: infinity.
    pub longest_apart_px: f64,
    /// The lever that converts a turn of 1 rad to px. Choose the size of a bend of the rope. From 1
    /// to 10⁴. Default: 100.
    pub lever_px: f64,
    /// Delay between a command and the robot's motion, s, plus the rope's lag if that is known.
    /// From 0 to 1. Default: 0.
    pub delay_s: f64,
}

impl<const A: usize> Default for Robot<A> {
    fn default() -> Self {
        Self {
            grippers: 1,
            start: [[0.0; A]; 2],
            speeds: std::array::from_fn(|axis| match axis < dimensions(A) {
                true => 100.0,
                false => 1.0,
            }),
            accelerations: None,
            workspaces: [Workspace::ANYWHERE; 2],
            longest_apart_px: f64::INFINITY,
            lever_px: 100.0,
            delay_s: 0.0,
        }
    }
}

setters! {
    {const A: usize} Robot<A>;
    grippers: usize,
    start: [[f64; A]; 2],
    speeds: [f64; A],
    accelerations: Option<[f64; A]>,
    workspaces: [Workspace<A>; 2],
    longest_apart_px: f64,
    lever_px: f64,
    delay_s: f64,
}

/// Bounds of a gripper's coordinates. The gripper slows down towards a border and does not cross it
/// if commands come at least every 0.1 s. A gripper outside may only move back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Workspace<const A: usize = 3> {
    /// Minimum of each coordinate.
    pub least: [f64; A],
    /// Maximum of each coordinate.
    pub most: [f64; A],
}

impl<const A: usize> Workspace<A> {
    /// A workspace without bounds.
    pub const ANYWHERE: Self = Self {
        least: [f64::NEG_INFINITY; A],
        most: [f64::INFINITY; A],
    };
}

impl<const A: usize> Robot<A> {
    pub(crate) fn check(&self) -> Result<(), ServoError> {
        within("grippers", self.grippers as f64, 1.0, 2.0)?;
        for start in self.start.as_flattened() {
            within("start", *start, -1e6, 1e6)?;
        }
        for speed in self.speeds {
            within("speeds", speed, 0.0, 1e5)?;
        }
        if self.speeds == [0.0; A] {
            return Err(ServoError::NothingMoves);
        }
        for acceleration in self.accelerations.iter().flatten() {
            within("accelerations", *acceleration, 1e-3, f64::INFINITY)?;
        }
        within(
            "longest_apart_px",
            self.longest_apart_px,
            0.0,
            f64::INFINITY,
        )?;
        within("lever_px", self.lever_px, 1.0, 1e4)?;
        within("delay_s", self.delay_s, 0.0, 1.0)?;
        for (index, workspace) in self.workspaces[..self.grippers].iter().enumerate() {
            let sides = workspace.least.iter().zip(&workspace.most);
            for ((least, most), axis) in sides.zip(axes(A)) {
                // Also rejects NaN.
                if least.partial_cmp(most) != Some(std::cmp::Ordering::Less) {
                    let gripper = index + 1;
                    return Err(ServoError::Workspace { gripper, axis });
                }
            }
        }
        Ok(())
    }
}

/// Names of the coordinates of a gripper that has this many.
pub(crate) const fn axes(count: usize) -> &'static [&'static str] {
    match count {
        6 => &["x", "y", "z", "θ₁", "θ₂", "θ₃"],
        _ => &["x", "y", "θ"],
    }
}
