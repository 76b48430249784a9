//! Rope and robot together, step by step.

use crate::gripper::{Pose, Robot};
use crate::options::{Options, OptionsError};
use crate::rod::{Energy, Material, Rod};
use crate::shape::{lay, poses};
use lariat_portable::SplitMix64;

/// How long a step is.
pub const STEP_NS: u64 = 1_000_000;
/// The same in seconds.
pub const STEP_S: f64 = 1e-3;
/// Nodes at each end that are within the jaws: the rope's position and direction there are the gripper's.
pub(crate) const HELD: usize = 3;

/// Gravity in px/s².
const GRAVITY_PX_S2: f64 = 9810.0;
/// What share of its speed a rope loses in a second to the air and in itself.
const DAMPING_PER_S: f64 = 4.0;
/// A rope whose nodes are all slower than this is at rest,
const AT_REST_PX_S: f64 = 0.2;
/// and none is waited for longer than this.
const LONGEST_REST_S: f64 = 4.0;
/// A rope that is stretched by this share is taut: the robot pulls no farther.
const TAUT: f64 = 5e-4;
/// Of what the robot can, what it does where nothing is in a hurry.
const UNHURRIED: f64 = 0.5;

/// A rope on a table, held by grippers.
///
/// The same options and the same commands at the same steps give the same rope, to the last bit, on every machine.
#[derive(Debug, Clone)]
pub struct Simulation {
    options: Options,
    rod: Rod,
    robot: Robot,
    steps: u64,
}

impl Simulation {
    /// The rope at rest in the start of its seed: gently bent, without loops, in the middle of the picture.
    ///
    /// # Errors
    /// Options out of their ranges.
    pub fn new(options: &Options) -> Result<Self, OptionsError> {
        options.check()?;
        let random = &mut SplitMix64::of_stream(options.seed, 1);
        let bow = random.uniform(0.6, 0.85);
        let sway = random.uniform(-0.15, 0.15);
        let turn = random.uniform(-0.12, 0.12);
        let [width, height] = options.picture_px;
        let middle = [
            width / 2.0 + random.uniform(-0.04, 0.04) * width,
            height / 2.0 + random.uniform(-0.04, 0.04) * height,
        ];
        let heading = |share: f64| {
            let angle = std::f64::consts::PI * share;
            turn + bow * libm::cos(angle) + sway * libm::cos(2.0 * angle)
        };
        let segment_px = options.segment_px();
        let line = lay(options.nodes, segment_px, middle, heading);
        let held = poses(&line, heading)[..options.grippers].to_vec();
        let held_px = (HELD - 1) as f64 * segment_px;
        let material = Material {
            segment_px,
            // From m⁴ to px⁴.
            bending_px4_s2: options.stiffness * 1e12,
            friction_px_s2: options.friction * GRAVITY_PX_S2,
            damping_per_s: DAMPING_PER_S,
        };
        let workspace_px = options.workspace_px();
        let mut simulation = Self {
            options: *options,
            rod: Rod::new(line, material),
            robot: Robot::new(held, options.limits, workspace_px, held_px),
            steps: 0,
        };
        simulation.settle();
        simulation.steps = 0;
        Ok(simulation)
    }

    /// What it was made with.
    pub fn options(&self) -> &Options {
        &self.options
    }

    /// Tells the grippers their velocities, from now on: x and y in px/s, the angle in rad/s; a gripper that is not told any
    /// stops. The robot keeps to its limits whatever it is told, and stops by itself when it has not been told anything for
    /// the time of its watchdog.
    pub fn command(&mut self, velocities: &[[f64; 3]]) {
        self.robot.command(velocities);
    }

    /// Goes on by [`STEP_S`].
    pub fn step(&mut self) {
        let too_long_px = (self.rod.stretch() - TAUT) * self.options.length_px;
        self.robot.step(STEP_S, too_long_px);
        let segment_px = self.options.segment_px();
        let last = self.options.nodes - 1;
        let grippers = self.robot.poses().iter().enumerate();
        let held = grippers.flat_map(|(gripper, pose)| {
            (0..HELD).map(move |i| {
                let node = if gripper == 0 { i } else { last - i };
                (node, pose.ahead(i as f64 * segment_px))
            })
        });
        self.rod.step(STEP_S, held);
        self.steps += 1;
    }

    /// How many steps have been made.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Where the grippers are.
    pub fn grippers(&self) -> &[Pose] {
        self.robot.poses()
    }

    /// How fast they go: x and y in px/s, the angle in rad/s.
    pub fn velocities(&self) -> &[[f64; 3]] {
        self.robot.velocities()
    }

    /// How far before a gripper's place its jaws hold the rope, in pixels.
    pub fn jaw_px(&self) -> f64 {
        (HELD - 1) as f64 * self.options.segment_px()
    }

    /// The whole rope, from end to end.
    pub fn nodes(&self) -> &[[f64; 2]] {
        self.rod.nodes()
    }

    /// The part that is not within a gripper's jaws.
    pub fn visible(&self) -> &[[f64; 2]] {
        let nodes = self.rod.nodes();
        let end = match self.options.grippers {
            1 => nodes.len(),
            _ => nodes.len() + 1 - HELD,
        };
        &nodes[HELD - 1..end]
    }

    /// What is stored in the rope.
    pub fn energy(&mut self) -> Energy {
        self.rod.energy()
    }

    /// Takes the grippers to these poses at half of what the robot can, all in the same time, and lets the rope come to rest.
    pub fn drive_to(&mut self, poses: &[Pose]) {
        let limits = self.options.limits;
        let (speed, turn) = (UNHURRIED * limits.speed_px_s, UNHURRIED * limits.turn_rad_s);
        let way = |from: &Pose, to: &Pose| {
            let [x, y] = [to.at[0] - from.at[0], to.at[1] - from.at[1]];
            [x, y, to.angle_rad - from.angle_rad]
        };
        let ways = |robot: &Robot| -> Vec<[f64; 3]> {
            let pairs = robot.poses().iter().zip(poses);
            pairs.map(|(from, to)| way(from, to)).collect()
        };
        let time_s =
            |[x, y, angle]: &[f64; 3]| ((x * x + y * y).sqrt() / speed).max(angle.abs() / turn);
        let longest_s = ways(&self.robot).iter().map(time_s).fold(0.0, f64::max);
        let steps = (longest_s / STEP_S) as u64 + 1;
        for left in (1..=steps).rev() {
            let mut rates = ways(&self.robot);
            for rate in rates.iter_mut().flatten() {
                *rate /= left as f64 * STEP_S;
            }
            self.command(&rates);
            self.step();
        }
        self.settle();
    }

    /// Lets the rope come to rest between grippers that stand still.
    pub fn settle(&mut self) {
        self.command(&[]);
        for step in 0..(LONGEST_REST_S / STEP_S) as usize {
            self.step();
            if step > 100 && self.rod.speed_px_s() < AT_REST_PX_S {
                break;
            }
        }
    }
}
