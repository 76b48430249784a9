//! A rope in space: lifted by its grippers, with gravity, and a table below it.

use crate::gripper::SpacePose;
use crate::held::Held;
use crate::options::{Options, OptionsError};
use crate::rod::Energy;
use crate::shape::{bow, lay, poses};

/// Radius of the rope, mm: its centerline lies so high on the table.
pub const RADIUS_MM: f64 = 6.0;
/// The highest that a gripper goes, mm.
const HIGHEST_MM: f64 = 140.0;
/// How high the grippers hold a rope at the start, mm.
const START_MM: [f64; 2] = [60.0, 90.0];

/// A rope held by grippers above a table, which is z = 0, with z up; x and y are from the middle of the part that is seen, and a
/// millimetre is what a pixel is in the plane.
///
/// The same options and the same commands at the same steps give the same rope, to the last bit, on every machine.
#[derive(Debug, Clone)]
pub struct SpaceSimulation(Held<3, 6, 11, SpacePose>);

impl SpaceSimulation {
    /// The rope at rest in the start of its seed: gently bent, without loops, its ends held above the middle of the table.
    ///
    /// # Errors
    /// Options out of their ranges.
    pub fn new(options: &Options) -> Result<Self, OptionsError> {
        options.check()?;
        let (heading, aside, mut random) = bow(options.seed);
        let line = lay(
            options.nodes,
            options.segment_px(),
            options.middle(aside),
            &heading,
        );
        let height_mm = random.uniform(START_MM[0], START_MM[1]);
        let poses = poses(&line, &heading).map(|pose| lifted(options, &pose, height_mm));
        let line = line.iter().map(|&at| above(options, at, height_mm));
        let (line, workspace_mm) = (line.collect(), Self::workspace_mm(options));
        Ok(Self(Held::new(options, line, &poses, workspace_mm)))
    }

    /// Where the grippers may go: the lowest and the highest of x, y and z.
    pub fn workspace_mm(options: &Options) -> [[f64; 2]; 3] {
        let [x, y] = options
            .picture_px
            .map(|size| 0.5 * size - options.limits.margin_px);
        [[-x, x], [-y, y], [RADIUS_MM, HIGHEST_MM]]
    }

    /// What it was made with.
    pub fn options(&self) -> &Options {
        &self.0.options
    }

    /// Tells the grippers their velocities, from now on: along x, y and z in mm/s, about x, y and z in rad/s; a gripper that is not
    /// told any stops. The robot keeps to its limits as [in the plane](crate::Simulation::command).
    pub fn command(&mut self, velocities: &[[f64; 6]]) {
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
    pub fn grippers(&self) -> &[SpacePose] {
        self.0.robot.poses()
    }

    /// How far before a gripper's place its jaws hold the rope, in millimetres.
    pub fn jaw_mm(&self) -> f64 {
        self.0.jaw_px()
    }

    /// The whole rope, from end to end, mm.
    pub fn nodes(&self) -> &[[f64; 3]] {
        self.0.rod.nodes()
    }

    /// The part that is not within a gripper's jaws.
    pub fn visible(&self) -> &[[f64; 3]] {
        self.0.visible()
    }

    /// What is stored in the rope.
    pub fn energy(&mut self) -> Energy {
        self.0.energy()
    }

    /// Takes the grippers to these poses at half of what the robot can, all in the same time, and lets the rope come to rest.
    pub fn drive_to(&mut self, poses: &[SpacePose]) {
        self.0.drive_to(poses);
    }

    /// Lets the rope come to rest between grippers that stand still.
    pub fn settle(&mut self) {
        self.0.settle();
    }
}

/// What is so high above a place in the picture; there y goes down, here away from who looks.
fn above(options: &Options, [x, y]: [f64; 2], height_mm: f64) -> [f64; 3] {
    let [width, height] = options.picture_px;
    [x - 0.5 * width, 0.5 * height - y, height_mm]
}

/// A pose of the plane, level at a height.
pub(crate) fn lifted(options: &Options, pose: &crate::Pose, height_mm: f64) -> SpacePose {
    let (sin, cos) = libm::sincos(pose.angle_rad);
    SpacePose {
        at: above(options, pose.at, height_mm),
        along: [cos, -sin, 0.0],
    }
}
