//! What the robot may do.

use crate::dimensions;
use crate::error::ServoError;
use crate::options::within;
use crate::setters::setters;

/// The grippers: where they are, and what they may do. Coordinates of a gripper are x px, y px, θ rad; of one in space (`A` is 6) x, y and z in
/// mm, and three turns in rad. Each field has a method of its name that sets it: `Robot::default().grippers(2)`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Robot<const A: usize = 3> {
    /// How many, 1 or 2. Default: 1.
    pub grippers: usize,
    /// Where they are at the start. Only [workspace](Self::workspaces) and [`longest_apart_px`](Self::longest_apart_px) ask where that
    /// is; without these any place will do. Default: 0.
    pub start: [[f64; A]; 2],
    /// Limits of speed for each gripper: px/s, px/s, rad/s, up to 10⁵. A coordinate with the limit 0 does not move: `[100, 100, 0]` is
    /// a gripper that cannot turn. Default: 100, 100, 1; in space 100 along each axis, and 1 about each.
    pub speeds: [f64; A],
    /// Limits of acceleration for each gripper: px/s², px/s², rad/s². To hold is not limited: that is at once. Default: none.
    pub accelerations: Option<[f64; A]>,
    /// Where each gripper may be. Default: anywhere.
    pub workspaces: [Workspace<A>; 2],
    /// How far two grippers may be from each other, px: a little less than the rope between them is long, which is never pulled
    /// taut then. Default: infinity.
    pub longest_apart_px: f64,
    /// The lever by which a turn counts: 1 rad is as much as so many px. Of the size of a bend of the rope. From 1 to 10⁴. Default: 100.
    pub lever_px: f64,
    /// How long after a command the robot moves, s; and the rope, where that is known to follow late. From 0 to 1. Default: 0.
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

/// Where a gripper may be, by its coordinates. It slows down towards the border and does not cross it, as long as commands come at
/// least every 0.1 s; one that is outside may only come back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Workspace<const A: usize = 3> {
    /// The least of each coordinate.
    pub least: [f64; A],
    /// The most of each coordinate.
    pub most: [f64; A],
}

impl<const A: usize> Workspace<A> {
    /// No bounds.
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
                // NaN is no side either.
                if least.partial_cmp(most) != Some(std::cmp::Ordering::Less) {
                    let gripper = index + 1;
                    return Err(ServoError::Workspace { gripper, axis });
                }
            }
        }
        Ok(())
    }
}

/// What the coordinates of a gripper that has so many are called.
pub(crate) const fn axes(count: usize) -> &'static [&'static str] {
    match count {
        6 => &["x", "y", "z", "θ₁", "θ₂", "θ₃"],
        _ => &["x", "y", "θ"],
    }
}
