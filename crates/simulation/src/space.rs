//! A rope in 3-D: lifted by its grippers, with gravity and a table below.

use crate::gripper::SpacePose;
use crate::held::Held;
use crate::options::{Options, OptionsError};
use crate::rod::Energy;
use crate::shape::{bow, lay, poses};

/// Radius of the rope, mm, which is the height of its centerline on the table.
pub const RADIUS_MM: f64 = 6.0;
/// Maximum height of a gripper, mm.
const HIGHEST_MM: f64 = 140.0;
/// Range of the grippers' heights at the start, mm.
const START_MM: [f64; 2] = [60.0, 90.0];

/// A rope held by grippers above a table at z = 0, with z up. The origin of x and y is the middle
/// of the visible part. A millimeter corresponds to a pixel in the plane.
///
/// The same options and the same commands at the same steps give the same rope, bit for bit, on
/// every machine.
#[derive(Debug, Clone)]
pub struct SpaceSimulation(Held<3, 6, 11, SpacePose>);

impl SpaceSimulation {
    /// Makes the rope at rest in the start position of its seed: gently bent, without loops, its
    /// ends held above the middle of the table.
    ///
    /// # Errors
    /// Returns an error if an option is out of its range.
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

    /// Returns the range of the grippers: minimum and maximum of x, y and z.
    pub fn workspace_mm(options: &Options) -> [[f64; 2]; 3] {
        let [x, y] = options
            .picture_px
            .map(|size| 0.5 * size - options.limits.margin_px);
        [[-x, x], [-y, y], [RADIUS_MM, HIGHEST_MM]]
    }

    /// Returns the options.
    pub fn options(&self) -> &Options {
        &self.0.options
    }

    /// Sets the velocities of the grippers: along x, y and z in mm/s, about x, y and z in rad/s. A
    /// gripper without a velocity stops. The robot keeps to its limits as [in the
    /// plane](crate::Simulation::command).
    pub fn command(&mut self, velocities: &[[f64; 6]]) {
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
    pub fn grippers(&self) -> &[SpacePose] {
        self.0.robot.poses()
    }

    /// Returns the length of rope in the jaws, measured ahead from a gripper's position, in
    /// millimeters.
    pub fn jaw_mm(&self) -> f64 {
        self.0.jaw_px()
    }

    /// Returns the whole rope, from end to end, mm.
    pub fn nodes(&self) -> &[[f64; 3]] {
        self.0.rod.nodes()
    }

    /// Returns the part outside the grippers' jaws.
    pub fn visible(&self) -> &[[f64; 3]] {
        self.0.visible()
    }

    /// Returns the energy stored in the rope.
    pub fn energy(&mut self) -> Energy {
        self.0.energy()
    }

    /// Moves the grippers to these poses at half of the robot's limits, all in the same time, and
    /// lets the rope come to rest.
    pub fn drive_to(&mut self, poses: &[SpacePose]) {
        self.0.drive_to(poses);
    }

    /// Lets the rope come to rest between stationary grippers.
    pub fn settle(&mut self) {
        self.0.settle();
    }
}

/// Point at this height above a place in the picture. In the picture, y points down; here, it
/// points away from the viewer.
fn above(options: &Options, [x, y]: [f64; 2], height_mm: f64) -> [f64; 3] {
    let [width, height] = options.picture_px;
    [x - 0.5 * width, 0.5 * height - y, height_mm]
}

/// Converts a pose of the plane to a level pose at a height.
pub(crate) fn lifted(options: &Options, pose: &crate::Pose, height_mm: f64) -> SpacePose {
    let (sin, cos) = libm::sincos(pose.angle_rad);
    SpacePose {
        at: above(options, pose.at, height_mm),
        along: [cos, -sin, 0.0],
    }
}
