//! The robot: grippers that follow commands within the robot's limits, in the plane or in 3-D.

use crate::Limits;
use crate::vector::{cross, distance, dot, length, push};

/// Pose of a gripper: the rope's end, and the direction in which the rope leaves the jaws.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Position of the rope's end, in pixels.
    pub at: [f64; 2],
    /// Direction, from x toward y, in radians.
    pub angle_rad: f64,
}

impl Pose {
    /// Returns the point `by_px` ahead of the rope's end, along the direction.
    pub fn ahead(&self, by_px: f64) -> [f64; 2] {
        let (sin, cos) = libm::sincos(self.angle_rad);
        [self.at[0] + by_px * cos, self.at[1] + by_px * sin]
    }
}

/// Pose of a gripper in 3-D. Its rotation about the rope does not matter, because the rope may be
/// twisted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpacePose {
    /// Position of the rope's end, in millimeters.
    pub at: [f64; 3],
    /// Direction in which the rope leaves the jaws, of length 1.
    pub along: [f64; 3],
}

impl SpacePose {
    /// Returns the point `by_mm` ahead of the rope's end, along the direction.
    pub fn ahead(&self, by_mm: f64) -> [f64; 3] {
        let mut at = self.at;
        push(&mut at, by_mm, self.along);
        at
    }
}

/// Operations of a robot on a pose. `D` is the number of position coordinates. `V` is the number of
/// velocity coordinates: one per position coordinate, then turns in rad/s.
pub(crate) trait Grip<const D: usize, const V: usize>: Copy {
    fn place(&mut self) -> &mut [f64; D];

    /// Point at this distance ahead of the rope's end.
    fn tip(&self, by_px: f64) -> [f64; D];

    /// Turns for the duration of a step.
    fn turn(&mut self, step_s: f64, velocity: &[f64; V]);

    /// Velocity that leads to another pose within one second.
    fn way(&self, to: &Self) -> [f64; V];
}

impl Grip<2, 3> for Pose {
    fn place(&mut self) -> &mut [f64; 2] {
        &mut self.at
    }

    fn tip(&self, by_px: f64) -> [f64; 2] {
        self.ahead(by_px)
    }

    fn turn(&mut self, step_s: f64, velocity: &[f64; 3]) {
        self.angle_rad += step_s * velocity[2];
    }

    fn way(&self, to: &Self) -> [f64; 3] {
        let [x, y] = [to.at[0] - self.at[0], to.at[1] - self.at[1]];
        [x, y, to.angle_rad - self.angle_rad]
    }
}

impl Grip<3, 6> for SpacePose {
    fn place(&mut self) -> &mut [f64; 3] {
        &mut self.at
    }

    fn tip(&self, by_px: f64) -> [f64; 3] {
        self.ahead(by_px)
    }

    fn turn(&mut self, step_s: f64, &[.., x, y, z]: &[f64; 6]) {
        // ȧ = ω × a; in a step of a millisecond, the chord approximates the arc.
        let change = cross([x, y, z], self.along);
        push(&mut self.along, step_s, change);
        let length = length(self.along);
        self.along = self.along.map(|c| c / length);
    }

    fn way(&self, to: &Self) -> [f64; 6] {
        let axis = cross(self.along, to.along);
        let sine = length(axis);
        let angle = libm::atan2(sine, dot(self.along, to.along));
        // For opposite directions, any axis perpendicular to both would do; no caller needs this
        // case.
        let [a, b, c] = axis.map(|c| if sine > 0.0 { angle * c / sine } else { 0.0 });
        let [x, y, z] = crate::vector::minus(to.at, self.at);
        [x, y, z, a, b, c]
    }
}

/// One or two grippers, and their last command.
#[derive(Debug, Clone)]
pub(crate) struct Robot<const D: usize, const V: usize, P> {
    limits: Limits,
    poses: Vec<P>,
    /// Linear velocities in px/s, then turns in rad/s.
    velocities: Vec<[f64; V]>,
    /// Time since the last command.
    silent_s: f64,
    /// Range of the grippers: minimum and maximum of each coordinate.
    workspace_px: [[f64; 2]; D],
    /// Length over which the jaws hold the rope.
    held_px: f64,
}

impl<const D: usize, const V: usize, P: Grip<D, V>> Robot<D, V, P> {
    pub(crate) fn new(
        poses: Vec<P>,
        limits: Limits,
        workspace_px: [[f64; 2]; D],
        held_px: f64,
    ) -> Self {
        Self {
            limits,
            velocities: vec![[0.0; V]; poses.len()],
            silent_s: 0.0,
            poses,
            workspace_px,
            held_px,
        }
    }

    pub(crate) fn poses(&self) -> &[P] {
        &self.poses
    }

    pub(crate) fn velocities(&self) -> &[[f64; V]] {
        &self.velocities
    }

    /// Takes a command. A velocity above the limits is reduced without changing its direction.
    /// Values that are not numbers become zero.
    pub(crate) fn command(&mut self, velocities: &[[f64; V]]) {
        self.silent_s = 0.0;
        for (i, velocity) in self.velocities.iter_mut().enumerate() {
            let asked = velocities.get(i).copied().unwrap_or([0.0; V]);
            *velocity = self.limits.within::<D, V>(asked);
        }
    }

    /// Moves for the duration of a step. `too_long_px` is the excess length of a taut rope.
    pub(crate) fn step(&mut self, step_s: f64, too_long_px: f64) {
        self.silent_s += step_s;
        if self.silent_s > self.limits.watchdog_s {
            self.velocities.fill([0.0; V]);
        }
        if self.velocities.iter().all(|v| *v == [0.0; V]) {
            return;
        }
        let apart_px = self.apart_px();
        let mut moved = [0.0; 2];
        for (i, (pose, velocity)) in self.poses.iter_mut().zip(&self.velocities).enumerate() {
            let before = pose.tip(self.held_px);
            let place = pose.place().iter_mut().zip(velocity);
            for ((at, velocity), [low, high]) in place.zip(self.workspace_px) {
                *at = (*at + step_s * velocity).clamp(low, high);
            }
            pose.turn(step_s, velocity);
            moved[i] = distance(before, pose.tip(self.held_px));
        }
        if too_long_px > 0.0 {
            self.give_way(apart_px - too_long_px, moved);
        }
    }

    /// Distance between the jaws.
    fn apart_px(&self) -> f64 {
        let [first, second] = &self.poses[..] else {
            return 0.0;
        };
        distance(first.tip(self.held_px), second.tip(self.held_px))
    }

    /// Moves the grippers back along the rope until they are at most `most_px` apart, each in
    /// proportion to its motion.
    fn give_way(&mut self, most_px: f64, moved_px: [f64; 2]) {
        let apart_px = self.apart_px();
        let excess_px = apart_px - most_px;
        let [first, second] = &mut self.poses[..] else {
            return;
        };
        let tips = [first.tip(self.held_px), second.tip(self.held_px)];
        let all_px = moved_px[0] + moved_px[1];
        if excess_px <= 0.0 || all_px <= 0.0 {
            return;
        }
        let pull =
            std::array::from_fn(|axis| excess_px * (tips[1][axis] - tips[0][axis]) / apart_px);
        push(first.place(), moved_px[0] / all_px, pull);
        push(second.place(), -moved_px[1] / all_px, pull);
    }
}

impl Limits {
    /// Returns the nearest velocity within the limits. The linear part keeps its direction; each
    /// turn is limited by itself.
    pub(crate) fn within<const D: usize, const V: usize>(&self, asked: [f64; V]) -> [f64; V] {
        let place: [f64; D] = std::array::from_fn(|axis| asked[axis]);
        let speed_px_s = length(place);
        let share = if speed_px_s.is_finite() {
            self.speed_px_s / speed_px_s.max(self.speed_px_s)
        } else {
            // Also reached if the square of a number overflows, which no real command causes.
            0.0
        };
        let turn = |v: f64| if v.is_nan() { 0.0 } else { v };
        let finite = |v: f64| if v.is_finite() { share * v } else { 0.0 };
        std::array::from_fn(|i| match i < D {
            true => finite(asked[i]),
            false => turn(asked[i]).clamp(-self.turn_rad_s, self.turn_rad_s),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whatever_is_asked_the_robot_stays_within_its_limits() {
        let limits = Limits::default();
        let values = [
            0.0,
            -3.0,
            250.0,
            -1e12,
            1e300,
            f64::NAN,
            f64::INFINITY,
            f64::NEG_INFINITY,
        ];
        for x in values {
            for y in values {
                for turn in values {
                    let [x, y, turn] = limits.within::<2, 3>([x, y, turn]);
                    let speed = (x * x + y * y).sqrt();
                    assert!(speed <= limits.speed_px_s * (1.0 + 1e-12), "{x} {y}");
                    assert!(turn.abs() <= limits.turn_rad_s);
                }
            }
        }
        assert_eq!(
            limits.within::<2, 3>([30.0, -40.0, 0.5]),
            [30.0, -40.0, 0.5]
        );
    }

    #[test]
    fn the_way_to_a_pose_leads_there() {
        let from = SpacePose {
            at: [1.0, 2.0, 3.0],
            along: [0.6, 0.0, 0.8],
        };
        let to = SpacePose {
            at: [4.0, 0.0, 2.0],
            along: [0.0, 1.0, 0.0],
        };
        let way = from.way(&to);
        let mut pose = from;
        for _ in 0..1000 {
            for (at, velocity) in pose.at.iter_mut().zip(way) {
                *at += 1e-3 * velocity;
            }
            pose.turn(1e-3, &way);
        }
        assert!(distance(pose.at, to.at) < 1e-9);
        assert!(distance(pose.along, to.along) < 1e-5, "{pose:?}");
    }
}
