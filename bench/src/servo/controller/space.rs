//! The controller of a lifted rope: it reads shapes in 3-D and sends gripper velocities in 3-D.

use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use lariat_control::{
    Command as Wish, Metric, Observation, Robot, SpaceServo, Tool, Weights, Why, Workspace,
};
use lariat_fit::Fitter;
use lariat_wire::{Domain, Reader, Seen, Shape, now_ns};

use super::observer::Whole;
use super::{METRIC_ROWS, ways};
use crate::servo::job::{Job, SpaceRobot};
use lariat_chain::settings::Settings;

/// Distance from the target, in the controller's own metric, at which the rope has arrived:
/// slightly more than the depth error.
const TOLERANCE_MM: f64 = 2.0;

/// The reader, the control law, and the directions of the grippers.
pub(super) struct Pilot {
    reader: Reader,
    servo: SpaceServo,
    tools: [Tool; 2],
    told: Option<(Instant, Wish<6>)>,
    max_age: Duration,
    whole: Whole,
}

impl Pilot {
    pub(super) fn open(
        settings: &Settings,
        job: &Job,
        target: &[[f64; 3]],
        robot: &SpaceRobot,
    ) -> Result<Self> {
        let rig = settings.run.rig.parse().context("the rig has no name")?;
        let mut reader = Reader::open_in(Domain::open()?, &rig)?;
        reader.follow_in_space()?;
        let points = lariat_simulation::at_equal_steps(target, settings.extract.points);
        let options = settings.fit.options(points.len(), false);
        let mut fitter = Fitter::<3>::in_dimensions(options)?;
        let fit = fitter.fit(&points).context("the target cannot be fitted")?;
        // The chain's curve is a Bezier curve.
        let order = fit.control_points.len() - 1;
        let rows = (0..METRIC_ROWS).map(|i| {
            let mut row = vec![0.0; order + 1];
            lariat_fit::bernstein(order, i as f64 / (METRIC_ROWS - 1) as f64, &mut row);
            row
        });
        let metric = Metric::of_rows(rows).context("the curve cannot be measured by")?;
        let options = ways(job)
            .robot(known(robot))
            .metric(metric)
            .tolerance_px(TOLERANCE_MM);
        let along = |i: usize| robot.start.get(i).map_or([1.0, 0.0, 0.0], |pose| pose[1]);
        Ok(Self {
            reader,
            servo: SpaceServo::new(options, fit.control_points.as_flattened())?,
            tools: [0, 1].map(|i| Tool::new(along(i))),
            told: None,
            max_age: Duration::from_secs_f64((3.0 * job.period_s).max(0.1)),
            whole: Whole::default(),
        })
    }

    /// Waits for a new image until the deadline. Returns the command and the image's exposure time.
    pub(super) fn decide(&mut self, deadline: Instant) -> Result<(Wish<6>, u64)> {
        let frame = self.reader.wait(deadline)?;
        let (servo, now_ns) = (&mut self.servo, now_ns());
        let rope = match frame.only_rope(self.max_age) {
            // As in the plane: the ends are in the jaws, and whatever is in the jaws is a rope.
            Seen::Fresh(rope) | Seen::Partial(rope) | Seen::Unsure(rope, _) => rope,
            Seen::Lost(_) => return Ok((servo.hold(Why::Lost, now_ns), 0)),
            Seen::Stale(_) => return Ok((servo.hold(Why::Stale, now_ns), 0)),
            Seen::Absent(_) => return Ok((servo.hold(Why::Absent, now_ns), 0)),
        };
        let descriptor = match rope.descriptor3() {
            Ok(descriptor) if Shape::in_space(descriptor).is_ok() => descriptor,
            _ => return Ok((servo.hold(Why::Absent, now_ns), 0)),
        };
        let is_whole = self.whole.is_it(descriptor.length);
        let seen = Observation {
            features: descriptor.control_points().as_flattened(),
            weights: Weights::Covariances3(descriptor.covariances()),
            exposed_ns: rope.exposed_ns(),
            partial: rope.hidden() > 0.0 || !is_whole,
        };
        Ok((servo.see(seen, now_ns), rope.exposed_ns()))
    }

    /// Converts a command to the robot's frame, given the current directions of the grippers.
    pub(super) fn twists(&mut self, wish: &Wish<6>) -> [[f64; 6]; 2] {
        let now = Instant::now();
        if let Some((since, before)) = self.told.replace((now, *wish)) {
            let seconds = now.duration_since(since).as_secs_f64();
            for (tool, velocity) in self.tools.iter_mut().zip(&before.velocities) {
                tool.turn(velocity, seconds);
            }
        }
        [0, 1].map(|i| self.tools[i].twist(&wish.velocities[i]))
    }
}

fn known(robot: &SpaceRobot) -> Robot<6> {
    let [along, about] = robot.speeds;
    let mut start = [[0.0; 6]; 2];
    for (to, [at, _]) in start.iter_mut().zip(&robot.start) {
        to[..3].copy_from_slice(at);
    }
    let side = |which: usize, turns: f64| {
        let [x, y, z] = robot.workspace_mm.map(|sides| sides[which]);
        [x, y, z, turns, turns, turns]
    };
    Robot::default()
        .grippers(robot.start.len())
        .start(start)
        .speeds([along, along, along, about, about, 0.0])
        .workspaces(
            [Workspace {
                least: side(0, f64::NEG_INFINITY),
                most: side(1, f64::INFINITY),
            }; 2],
        )
        .longest_apart_px(robot.longest_apart_mm)
}
