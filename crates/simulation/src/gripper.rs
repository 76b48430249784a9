//! The robot: grippers in the plane that go where they are told to, within what a robot allows itself.

use crate::Limits;

/// Where a gripper is: the rope's end, and the direction in which the rope leaves its jaws.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// The rope's end, in pixels.
    pub at: [f64; 2],
    /// The direction from x towards y, in radians.
    pub angle_rad: f64,
}

impl Pose {
    /// The point so far before the rope's end, along the direction.
    pub fn ahead(&self, by_px: f64) -> [f64; 2] {
        let (sin, cos) = libm::sincos(self.angle_rad);
        [self.at[0] + by_px * cos, self.at[1] + by_px * sin]
    }
}

/// One or two grippers, and what they were told last.
#[derive(Debug, Clone)]
pub(crate) struct Robot {
    limits: Limits,
    poses: Vec<Pose>,
    /// x and y in px/s, the angle in rad/s.
    velocities: Vec<[f64; 3]>,
    /// Since the last command.
    silent_s: f64,
    /// Where the grippers may go: the lowest and the highest x, and y.
    workspace_px: [[f64; 2]; 2],
    /// How far the jaws hold the rope.
    held_px: f64,
}

impl Robot {
    pub(crate) fn new(
        poses: Vec<Pose>,
        limits: Limits,
        workspace_px: [[f64; 2]; 2],
        held_px: f64,
    ) -> Self {
        Self {
            limits,
            velocities: vec![[0.0; 3]; poses.len()],
            silent_s: 0.0,
            poses,
            workspace_px,
            held_px,
        }
    }

    pub(crate) fn poses(&self) -> &[Pose] {
        &self.poses
    }

    pub(crate) fn velocities(&self) -> &[[f64; 3]] {
        &self.velocities
    }

    /// Takes a command. What is faster than the limits is slowed down in its direction; what is no number is zero.
    pub(crate) fn command(&mut self, velocities: &[[f64; 3]]) {
        self.silent_s = 0.0;
        for (i, velocity) in self.velocities.iter_mut().enumerate() {
            let asked = velocities.get(i).copied().unwrap_or([0.0; 3]);
            *velocity = self.limits.within(asked);
        }
    }

    /// Moves for so long; where the rope is taut, `too_long_px` says by how much it is stretched too far.
    pub(crate) fn step(&mut self, step_s: f64, too_long_px: f64) {
        self.silent_s += step_s;
        if self.silent_s > self.limits.watchdog_s {
            self.velocities.fill([0.0; 3]);
        }
        if self.velocities.iter().all(|v| *v == [0.0; 3]) {
            return;
        }
        let apart_px = self.apart_px();
        let mut moved = [0.0; 2];
        for (i, (pose, velocity)) in self.poses.iter_mut().zip(&self.velocities).enumerate() {
            let before = pose.ahead(self.held_px);
            pose.at = [0, 1].map(|axis| {
                let [low, high] = self.workspace_px[axis];
                (pose.at[axis] + step_s * velocity[axis]).clamp(low, high)
            });
            pose.angle_rad += step_s * velocity[2];
            moved[i] = distance(before, pose.ahead(self.held_px));
        }
        if too_long_px > 0.0 {
            self.give_way(apart_px - too_long_px, moved);
        }
    }

    /// How far apart the jaws are.
    fn apart_px(&self) -> f64 {
        let [first, second] = &self.poses[..] else {
            return 0.0;
        };
        distance(first.ahead(self.held_px), second.ahead(self.held_px))
    }

    /// The grippers go back along the rope until they are no farther apart than that, each by its share in the motion.
    fn give_way(&mut self, most_px: f64, moved_px: [f64; 2]) {
        let apart_px = self.apart_px();
        let excess_px = apart_px - most_px;
        let [first, second] = &mut self.poses[..] else {
            return;
        };
        let tips = [first.ahead(self.held_px), second.ahead(self.held_px)];
        let all_px = moved_px[0] + moved_px[1];
        if excess_px <= 0.0 || all_px <= 0.0 {
            return;
        }
        let pull = [0, 1].map(|axis| excess_px * (tips[1][axis] - tips[0][axis]) / apart_px);
        let go = |pose: &mut Pose, share: f64| {
            pose.at = [pose.at[0] + share * pull[0], pose.at[1] + share * pull[1]];
        };
        go(first, moved_px[0] / all_px);
        go(second, -moved_px[1] / all_px);
    }
}

impl Limits {
    /// The nearest velocity that is allowed, in the same direction.
    pub(crate) fn within(&self, [x, y, turn]: [f64; 3]) -> [f64; 3] {
        let speed_px_s = (x * x + y * y).sqrt();
        let share = if speed_px_s.is_finite() {
            self.speed_px_s / speed_px_s.max(self.speed_px_s)
        } else {
            // Also where the square of a number overflows: no robot is asked for that in earnest.
            0.0
        };
        let turn = if turn.is_nan() { 0.0 } else { turn };
        let finite = |v: f64| if v.is_finite() { share * v } else { 0.0 };
        [
            finite(x),
            finite(y),
            turn.clamp(-self.turn_rad_s, self.turn_rad_s),
        ]
    }
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    let (x, y) = (a[0] - b[0], a[1] - b[1]);
    (x * x + y * y).sqrt()
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
                    let [x, y, turn] = limits.within([x, y, turn]);
                    let speed = (x * x + y * y).sqrt();
                    assert!(speed <= limits.speed_px_s * (1.0 + 1e-12), "{x} {y}");
                    assert!(turn.abs() <= limits.turn_rad_s);
                }
            }
        }
        assert_eq!(limits.within([30.0, -40.0, 0.5]), [30.0, -40.0, 0.5]);
    }
}
