//! A gripper's own axes in 3-D, which turn with it.

/// The direction of a gripper, and the axes about which a [`SpaceServo`](crate::SpaceServo) turns
/// it: two across the rope, and the rope itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tool {
    /// Two axes across the rope, then the rope's direction: orthogonal unit vectors.
    axes: [[f64; 3]; 3],
}

impl Tool {
    /// Creates the axes of a gripper that the rope leaves in this direction. The vector may have
    /// any length except 0. The first axis across the rope is horizontal.
    pub fn new(along: [f64; 3]) -> Self {
        let along = unit(along).unwrap_or([1.0, 0.0, 0.0]);
        let level = unit(cross([0.0, 0.0, 1.0], along)).unwrap_or([1.0, 0.0, 0.0]);
        Self {
            axes: [level, cross(along, level), along],
        }
    }

    /// Direction of the rope that the gripper holds.
    pub fn along(&self) -> [f64; 3] {
        self.axes[2]
    }

    /// Converts a servo's velocity to the robot's frame: velocities along x, y and z, and turns
    /// about these, rad/s.
    pub fn twist(&self, velocity: &[f64; 6]) -> [f64; 6] {
        let [x, y, z, turns @ ..] = *velocity;
        let about = |axis: usize| (0..3).map(|k| turns[k] * self.axes[k][axis]).sum();
        [x, y, z, about(0), about(1), about(2)]
    }

    /// Turns the axes for `seconds` at this velocity, as commanded by the servo.
    pub fn turn(&mut self, velocity: &[f64; 6], seconds: f64) {
        let [.., x, y, z] = self.twist(velocity);
        let about = [x, y, z].map(|turn| turn * seconds);
        let angle = dot(about, about).sqrt();
        if !angle.is_finite() {
            return;
        }
        // Rodrigues' formula with the tangent of half the angle, which for a small step is half the
        // angle. It needs no sine and preserves lengths and right angles.
        let steps = (angle / STEP_RAD).ceil().clamp(1.0, MOST_STEPS);
        let half = about.map(|turn| 0.5 * turn / steps);
        let share = 2.0 / (1.0 + dot(half, half));
        for _ in 0..steps as usize {
            self.axes = self.axes.map(|v| {
                let once = cross(half, v);
                let twice = cross(half, once);
                [0, 1, 2].map(|k| v[k] + share * (once[k] + twice[k]))
            });
        }
    }
}

/// Maximum turn per step. The relative error of each step is at most 10⁻⁵.
const STEP_RAD: f64 = 0.01;
/// Maximum number of steps per call: a whole turn.
const MOST_STEPS: f64 = 628.0;

/// Unit vector; `None` if the vector has no direction.
fn unit(v: [f64; 3]) -> Option<[f64; 3]> {
    let length = dot(v, v).sqrt();
    (length > 1e-12 && length.is_finite()).then(|| v.map(|c| c / length))
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tool_turns_about_its_own_axes_and_stays_one() {
        let mut tool = Tool::new([3.0, 0.0, 0.0]);
        assert_eq!(tool.axes[0], [0.0, 1.0, 0.0]);
        // After a quarter turn about the horizontal axis, the tool points down or up.
        let quarter = std::f64::consts::FRAC_PI_2;
        tool.turn(&[9.0, 9.0, 9.0, quarter, 0.0, 0.0], 1.0);
        assert!((tool.along()[2].abs() - 1.0).abs() < 1e-6, "{tool:?}");
        assert_eq!(
            tool.twist(&[1.0, 2.0, 3.0, 0.5, 0.0, 0.0])[..3],
            [1.0, 2.0, 3.0]
        );
        for step in 0..1000 {
            let turn = [0.3, -0.7, 0.1].map(|t| t * f64::from(step % 7));
            tool.turn(&[0.0, 0.0, 0.0, turn[0], turn[1], turn[2]], 0.02);
        }
        for (i, a) in tool.axes.iter().enumerate() {
            for (j, b) in tool.axes.iter().enumerate() {
                let unit = f64::from(u8::from(i == j));
                assert!((dot(*a, *b) - unit).abs() < 1e-9, "{tool:?}");
            }
        }
        // A vertical direction also has a horizontal axis, and an invalid direction gives finite
        // axes.
        for along in [[0.0, 0.0, 2.0], [0.0; 3], [f64::NAN; 3]] {
            assert!(
                Tool::new(along)
                    .axes
                    .as_flattened()
                    .iter()
                    .all(|c| c.is_finite())
            );
        }
    }
}
