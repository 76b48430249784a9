//! Rope and robot together, step by step, with the same code in the plane and in 3-D.

use crate::gripper::{Grip, Robot};
use crate::options::Options;
use crate::rod::{Energy, Material, Rod};

/// Duration of a step.
pub const STEP_NS: u64 = 1_000_000;
/// Duration of a step in seconds.
pub const STEP_S: f64 = 1e-3;
/// Number of nodes at each end that are inside the jaws. There, the gripper determines the rope's
/// position and direction.
pub(crate) const HELD: usize = 3;

/// Share of its speed that a rope loses per second to the air and to internal friction.
const DAMPING_PER_S: f64 = 4.0;
/// A rope is at rest if all its nodes are slower than this.
const AT_REST_PX_S: f64 = 0.2;
/// Maximum time to wait for a rope to come to rest.
const LONGEST_REST_S: f64 = 4.0;
/// Relative stretch at which a rope is taut and the robot pulls no farther.
const TAUT: f64 = 5e-4;
/// Share of the robot's limits that unhurried motions use.
const UNHURRIED: f64 = 0.5;

/// A rope and its grippers, in `D` dimensions, with `V` velocity coordinates per gripper.
#[derive(Debug, Clone)]
pub(crate) struct Held<const D: usize, const V: usize, const BAND: usize, P> {
    pub(crate) options: Options,
    pub(crate) rod: Rod<D, BAND>,
    pub(crate) robot: Robot<D, V, P>,
    pub(crate) steps: u64,
}

impl<const D: usize, const V: usize, const BAND: usize, P: Grip<D, V>> Held<D, V, BAND, P> {
    /// Lays a rope along these nodes and lets it come to rest in its grippers.
    pub(crate) fn new(
        options: &Options,
        line: Vec<[f64; D]>,
        poses: &[P],
        workspace_px: [[f64; 2]; D],
    ) -> Self {
        let segment_px = options.segment_px();
        let material = Material {
            segment_px,
            // Converts m⁴ to px⁴.
            bending_px4_s2: options.stiffness * 1e12,
            friction: options.friction,
            damping_per_s: DAMPING_PER_S,
            lies_at_px: crate::RADIUS_MM,
        };
        let held = poses[..options.grippers].to_vec();
        let held_px = (HELD - 1) as f64 * segment_px;
        let mut new = Self {
            options: *options,
            rod: Rod::new(line, material),
            robot: Robot::new(held, options.limits, workspace_px, held_px),
            steps: 0,
        };
        new.settle();
        new.steps = 0;
        new
    }

    pub(crate) fn step(&mut self) {
        let too_long_px = (self.rod.stretch() - TAUT) * self.options.length_px;
        self.robot.step(STEP_S, too_long_px);
        let segment_px = self.options.segment_px();
        let last = self.options.nodes - 1;
        let grippers = self.robot.poses().iter().enumerate();
        let held = grippers.flat_map(|(gripper, pose)| {
            (0..HELD).map(move |i| {
                let node = if gripper == 0 { i } else { last - i };
                (node, pose.tip(i as f64 * segment_px))
            })
        });
        self.rod.step(STEP_S, held);
        self.steps += 1;
    }

    pub(crate) fn jaw_px(&self) -> f64 {
        (HELD - 1) as f64 * self.options.segment_px()
    }

    pub(crate) fn visible(&self) -> &[[f64; D]] {
        let nodes = self.rod.nodes();
        let end = match self.options.grippers {
            1 => nodes.len(),
            _ => nodes.len() + 1 - HELD,
        };
        &nodes[HELD - 1..end]
    }

    pub(crate) fn energy(&mut self) -> Energy {
        self.rod.energy()
    }

    pub(crate) fn drive_to(&mut self, poses: &[P]) {
        let limits = self.options.limits;
        let (speed, turn) = (UNHURRIED * limits.speed_px_s, UNHURRIED * limits.turn_rad_s);
        let ways = |robot: &Robot<D, V, P>| -> Vec<[f64; V]> {
            let pairs = robot.poses().iter().zip(poses);
            pairs.map(|(from, to)| from.way(to)).collect()
        };
        let time_s = |way: &[f64; V]| {
            let of = |part: &[f64]| part.iter().map(|v| v * v).sum::<f64>().sqrt();
            (of(&way[..D]) / speed).max(of(&way[D..]) / turn)
        };
        let longest_s = ways(&self.robot).iter().map(time_s).fold(0.0, f64::max);
        let steps = (longest_s / STEP_S) as u64 + 1;
        for left in (1..=steps).rev() {
            let mut rates = ways(&self.robot);
            for rate in rates.as_flattened_mut() {
                *rate /= left as f64 * STEP_S;
            }
            self.robot.command(&rates);
            self.step();
        }
        self.settle();
    }

    pub(crate) fn settle(&mut self) {
        self.robot.command(&[]);
        for step in 0..(LONGEST_REST_S / STEP_S) as usize {
            self.step();
            if step > 100 && self.rod.speed_px_s() < AT_REST_PX_S {
                break;
            }
        }
    }
}
