//! A rope on a table, in its plane.

use crate::gripper::Pose;
use crate::held::Held;
use crate::options::{Options, OptionsError};
use crate::rod::Energy;
use crate::shape::{bow, lay, poses};

/// A rope on a table, held by grippers.
///
/// The same options and the same commands at the same steps give the same rope, bit for bit, on
/// every machine.
#[derive(Debug, Clone)]
pub struct Simulation(Held<2, 3, 5, Pose>);

impl Simulation {
    /// Makes the rope at rest in the start position of its seed: gently bent, without loops, in the
    /// middle of the picture.
    ///
    /// # Errors
    /// Returns an error if an option is out of its range.
    pub fn new(options: &Options) -> Result<Self, OptionsError> {
        options.check()?;
        let (heading, aside, _) = bow(options.seed);
        let middle = options.middle(aside);
        let line = lay(options.nodes, options.segment_px(), middle, &heading);
        let poses = poses(&line, &heading);
        let workspace_px = options.workspace_px();
        Ok(Self(Held::new(options, line, &poses, workspace_px)))
    }

    /// Returns the options.
    pub fn options(&self) -> &Options {
        &self.0.options
    }

    /// Sets the velocities of the grippers: x and y in px/s, the angle in rad/s. A gripper without
    /// a velocity stops. The robot keeps to its limits whatever the command, and stops by itself if
    /// no command comes within the time of its watchdog.
    pub fn command(&mut self, velocities: &[[f64; 3]]) {
        self.0.robot.command(velocities);
    }

    /// Advances by [`STEP_S`](crate::STEP_S).
    pub fn step(&mut self) {
        self.0.step();
    }

    /// Returns the number of steps so far.
    pub fn steps(&self) -> u64 {
        self.0.steps
    }

    /// Returns the poses of the grippers.
    pub fn grippers(&self) -> &[Pose] {
        self.0.robot.poses()
    }

    /// Returns the velocities of the grippers: x and y in px/s, the angle in rad/s.
    pub fn velocities(&self) -> &[[f64; 3]] {
        self.0.robot.velocities()
    }

    /// Returns the length of rope in the jaws, measured ahead from a gripper's position, in pixels.
    pub fn jaw_px(&self) -> f64 {
        self.0.jaw_px()
    }

    /// Returns the whole rope, from end to end.
    pub fn nodes(&self) -> &[[f64; 2]] {
        self.0.rod.nodes()
    }

    /// Returns the part outside the grippers' jaws.
    pub fn visible(&self) -> &[[f64; 2]] {
        self.0.visible()
    }

    /// Returns the energy stored in the rope.
    pub fn energy(&mut self) -> Energy {
        self.0.energy()
    }

    /// Moves the grippers to these poses at half of the robot's limits, all in the same time, and
    /// lets the rope come to rest.
    pub fn drive_to(&mut self, poses: &[Pose]) {
        self.0.drive_to(poses);
    }

    /// Lets the rope come to rest between stationary grippers.
    pub fn settle(&mut self) {
        self.0.settle();
    }
}
