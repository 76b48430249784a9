//! A rope on a table, in its plane.

use crate::gripper::Pose;
use crate::held::Held;
use crate::options::{Options, OptionsError};
use crate::rod::Energy;
use crate::shape::{bow, lay, poses};

/// A rope on a table, held by grippers.
///
/// The same options and the same commands at the same steps give the same rope, to the last bit, on every machine.
#[derive(Debug, Clone)]
pub struct Simulation(Held<2, 3, 5, Pose>);

impl Simulation {
    /// The rope at rest in the start of its seed: gently bent, without loops, in the middle of the picture.
    ///
    /// # Errors
    /// Options out of their ranges.
    pub fn new(options: &Options) -> Result<Self, OptionsError> {
        options.check()?;
        let (heading, aside, _) = bow(options.seed);
        let middle = options.middle(aside);
        let line = lay(options.nodes, options.segment_px(), middle, &heading);
        let poses = poses(&line, &heading);
        let workspace_px = options.workspace_px();
        Ok(Self(Held::new(options, line, &poses, workspace_px)))
    }

    /// What it was made with.
    pub fn options(&self) -> &Options {
        &self.0.options
    }

    /// Tells the grippers their velocities, from now on: x and y in px/s, the angle in rad/s; a gripper that is not told any
    /// stops. The robot keeps to its limits whatever it is told, and stops by itself when it has not been told anything for
    /// the time of its watchdog.
    pub fn command(&mut self, velocities: &[[f64; 3]]) {
        self.0.robot.command(velocities);
    }

    /// Goes on by [`STEP_S`](crate::STEP_S).
    pub fn step(&mut self) {
        self.0.step();
    }

    /// How many steps have been made.
    pub fn steps(&self) -> u64 {
        self.0.steps
    }

    /// Where the grippers are.
    pub fn grippers(&self) -> &[Pose] {
        self.0.robot.poses()
    }

    /// How fast they go: x and y in px/s, the angle in rad/s.
    pub fn velocities(&self) -> &[[f64; 3]] {
        self.0.robot.velocities()
    }

    /// How far before a gripper's place its jaws hold the rope, in pixels.
    pub fn jaw_px(&self) -> f64 {
        self.0.jaw_px()
    }

    /// The whole rope, from end to end.
    pub fn nodes(&self) -> &[[f64; 2]] {
        self.0.rod.nodes()
    }

    /// The part that is not within a gripper's jaws.
    pub fn visible(&self) -> &[[f64; 2]] {
        self.0.visible()
    }

    /// What is stored in the rope.
    pub fn energy(&mut self) -> Energy {
        self.0.energy()
    }

    /// Takes the grippers to these poses at half of what the robot can, all in the same time, and lets the rope come to rest.
    pub fn drive_to(&mut self, poses: &[Pose]) {
        self.0.drive_to(poses);
    }

    /// Lets the rope come to rest between grippers that stand still.
    pub fn settle(&mut self) {
        self.0.settle();
    }
}
