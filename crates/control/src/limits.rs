//! Enforces the robot's limits on every velocity.

use crate::robot::Robot;
use crate::{Coordinates, INPUTS, dimensions};

/// A gripper moves towards a border no faster than would take it there in this time, s. If commands
/// come at least this often, it does not cross the border.
const BORDER_S: f64 = 0.1;

/// Limits of all coordinates, px-like.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Limits {
    /// Coordinates per gripper.
    axes: usize,
    /// Factors that convert coordinates to px-like ones.
    scale: Coordinates,
    /// The speed limits as given.
    given: Coordinates,
    speeds: Coordinates,
    accelerations: Coordinates,
    least: Coordinates,
    most: Coordinates,
    longest_apart_px: f64,
}

impl Limits {
    pub(crate) fn new<const A: usize>(robot: &Robot<A>) -> Self {
        let scale = std::array::from_fn(|i| match i % A < dimensions(A) {
            true => 1.0,
            false => robot.lever_px,
        });
        // Coordinates after the second gripper's do not move.
        let each = |of: fn(&Robot<A>, usize) -> [f64; A]| -> Coordinates {
            std::array::from_fn(|i| scale[i] * of(robot, (i / A).min(1))[i % A])
        };
        let given: Coordinates = std::array::from_fn(|i| match i / A < robot.grippers {
            true => robot.speeds[i % A],
            false => 0.0,
        });
        let longest_apart_px = match robot.grippers {
            2 => robot.longest_apart_px,
            _ => f64::INFINITY,
        };
        Self {
            axes: A,
            scale,
            given,
            speeds: std::array::from_fn(|i| scale[i] * given[i]),
            accelerations: each(|robot, _| robot.accelerations.unwrap_or([f64::INFINITY; A])),
            least: each(|robot, gripper| robot.workspaces[gripper].least),
            most: each(|robot, gripper| robot.workspaces[gripper].most),
            longest_apart_px,
        }
    }

    /// Converts poses to px-like coordinates.
    pub(crate) fn gather<const A: usize>(&self, poses: &[[f64; A]; 2]) -> Coordinates {
        gathered(poses, |i, coordinate| self.scale[i] * coordinate)
    }

    /// Converts px-like coordinates to poses.
    pub(crate) fn spread<const A: usize>(&self, r: &Coordinates) -> [[f64; A]; 2] {
        by_gripper(|i| r[i] / self.scale[i])
    }

    /// Converts px-like velocities to those of poses. Rounding does not exceed a limit.
    pub(crate) fn spread_velocity<const A: usize>(&self, velocity: &Coordinates) -> [[f64; A]; 2] {
        by_gripper(|i| (velocity[i] / self.scale[i]).clamp(-self.given[i], self.given[i]))
    }

    /// Converts a row of the Jacobian from px-like coordinates to poses.
    pub(crate) fn spread_row<const A: usize>(&self, row: &Coordinates) -> [[f64; A]; 2] {
        by_gripper(|i| row[i] * self.scale[i])
    }

    /// Converts a row of the Jacobian from poses to px-like coordinates.
    pub(crate) fn gather_row<const A: usize>(&self, row: &[[f64; A]; 2]) -> Coordinates {
        gathered(row, |i, entry| entry / self.scale[i])
    }

    pub(crate) fn speed(&self, input: usize) -> f64 {
        self.speeds[input]
    }

    /// Speed from which an input stops within half of this distance. The other half allows for
    /// infrequent commands.
    pub(crate) fn stops_within(&self, input: usize, distance_px: f64) -> f64 {
        (self.accelerations[input] * distance_px).sqrt()
    }

    /// Returns which inputs can move at all.
    pub(crate) fn movable(&self) -> [bool; INPUTS] {
        self.speeds.map(|speed| speed > 0.0)
    }

    /// Returns whether the grippers may be here.
    pub(crate) fn allow(&self, r: &Coordinates) -> bool {
        let inside = (0..INPUTS)
            .all(|i| self.speeds[i] == 0.0 || (self.least[i]..=self.most[i]).contains(&r[i]));
        inside && self.apart(r).0 <= self.longest_apart_px
    }

    /// Returns whether an input is at a border and moves outwards, so that almost nothing is left
    /// of its velocity.
    pub(crate) fn blocks(&self, input: usize, r: &Coordinates, velocity: f64) -> bool {
        let (low, high) = self.room(input, r);
        let velocity = velocity.clamp(-self.speeds[input], self.speeds[input]);
        velocity.clamp(low, high).abs() < 0.1 * velocity.abs()
    }

    /// Limits a wish to what may be commanded. `share` is the allowed share of the full speed, and
    /// `before` is the last command, given `dt_s` ago.
    pub(crate) fn keep(
        &self,
        wish: &Coordinates,
        share: f64,
        before: &Coordinates,
        dt_s: f64,
        r: &Coordinates,
    ) -> Coordinates {
        if !wish.iter().chain(r).all(|number| number.is_finite()) {
            return [0.0; INPUTS];
        }
        let wish = self.tethered(self.saturated(*wish), r);
        let wish = self.saturated(wish).map(|v| share * v);
        let mut kept = self.accelerated(wish, before, dt_s);
        for (i, kept) in kept.iter_mut().enumerate() {
            let (low, high) = self.room(i, r);
            *kept = kept.clamp(low, high);
        }
        // A border may have stopped only one of the grippers.
        let opening = self.opening(&kept, r);
        let allowed = self.allowed_opening(r);
        if opening > allowed {
            kept = kept.map(|v| v * (allowed / opening));
        }
        self.saturated(kept)
    }

    /// Scales the whole vector down, keeping its direction, until each input is within its limit.
    fn saturated(&self, velocity: Coordinates) -> Coordinates {
        let mut share = 1.0f64;
        for (v, limit) in velocity.iter().zip(&self.speeds) {
            if *limit > 0.0 && v.abs() > *limit {
                share = share.min(limit / v.abs());
            }
        }
        // Rounding may exceed a limit in the last digit.
        std::array::from_fn(|i| (share * velocity[i]).clamp(-self.speeds[i], self.speeds[i]))
    }

    /// Moves from the last command towards the wish as far as the accelerations allow. If both are
    /// within the speed limits, so is the result.
    fn accelerated(&self, wish: Coordinates, before: &Coordinates, dt_s: f64) -> Coordinates {
        let mut share = 1.0f64;
        for i in 0..INPUTS {
            let (change, most) = ((wish[i] - before[i]).abs(), self.accelerations[i] * dt_s);
            // Without a limit, `most` is infinite, or NaN if `dt_s` is 0.
            if change > most {
                share = share.min(most / change);
            }
        }
        if share == 1.0 {
            return wish;
        }
        std::array::from_fn(|i| before[i] + share * (wish[i] - before[i]))
    }

    /// Range of velocities that do not lead outside. Outside the workspace, the range contains only
    /// velocities that lead back.
    fn room(&self, input: usize, r: &Coordinates) -> (f64, f64) {
        let low = (self.least[input] - r[input]) / BORDER_S;
        let high = (self.most[input] - r[input]) / BORDER_S;
        (low.min(0.0), high.max(0.0))
    }

    /// Removes the velocity that would pull the rope taut, half from each gripper.
    fn tethered(&self, mut velocity: Coordinates, r: &Coordinates) -> Coordinates {
        let excess = self.opening(&velocity, r) - self.allowed_opening(r);
        if excess.is_nan() || excess <= 0.0 {
            return velocity;
        }
        let (_, away) = self.apart(r);
        for (axis, away) in away.into_iter().enumerate().take(dimensions(self.axes)) {
            velocity[axis] += 0.5 * excess * away;
            velocity[self.axes + axis] -= 0.5 * excess * away;
        }
        velocity
    }

    /// Speed at which the grippers move apart.
    fn opening(&self, velocity: &Coordinates, r: &Coordinates) -> f64 {
        let (_, [x, y, z]) = self.apart(r);
        let [u, v, w] = self.way_between(velocity);
        x * u + y * v + z * w
    }

    /// Distance between the grippers, and the direction from the first to the second.
    fn apart(&self, r: &Coordinates) -> (f64, [f64; 3]) {
        let way = self.way_between(r);
        let [x, y, z] = way;
        let distance = (x * x + y * y + z * z).sqrt();
        if distance == 0.0 {
            return (0.0, [0.0; 3]);
        }
        (distance, way.map(|c| c / distance))
    }

    /// Difference of the grippers' positions or velocities; z is 0 in the plane.
    fn way_between(&self, r: &Coordinates) -> [f64; 3] {
        std::array::from_fn(|axis| match axis < dimensions(self.axes) {
            true => r[self.axes + axis] - r[axis],
            false => 0.0,
        })
    }

    fn allowed_opening(&self, r: &Coordinates) -> f64 {
        ((self.longest_apart_px - self.apart(r).0) / BORDER_S).max(0.0)
    }
}

fn by_gripper<const A: usize>(number: impl Fn(usize) -> f64) -> [[f64; A]; 2] {
    std::array::from_fn(|gripper| std::array::from_fn(|axis| number(A * gripper + axis)))
}

/// Collects the coordinates of both grippers; the rest is 0.
fn gathered<const A: usize>(of: &[[f64; A]; 2], number: impl Fn(usize, f64) -> f64) -> Coordinates {
    let mut all = [0.0; INPUTS];
    for (i, (to, from)) in all.iter_mut().zip(of.as_flattened()).enumerate() {
        *to = number(i, *from);
    }
    all
}
