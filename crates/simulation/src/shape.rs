//! Lines from their heading, and points at equal steps along a line.

use crate::gripper::Pose;
use crate::held::HELD;
use crate::vector::distance;
use lariat_portable::SplitMix64;

/// Returns the start position of a seed: the rope's heading, its offset from the middle as a share
/// of the picture, and a random generator for everything else.
pub(crate) fn bow(seed: u64) -> (impl Fn(f64) -> f64, [f64; 2], SplitMix64) {
    let mut random = SplitMix64::of_stream(seed, 1);
    let bow = random.uniform(0.6, 0.85);
    let sway = random.uniform(-0.15, 0.15);
    let turn = random.uniform(-0.12, 0.12);
    let aside = [(); 2].map(|()| random.uniform(-0.04, 0.04));
    let heading = move |share: f64| {
        let angle = std::f64::consts::PI * share;
        turn + bow * libm::cos(angle) + sway * libm::cos(2.0 * angle)
    };
    (heading, aside, random)
}

/// Lays the nodes of a rope with its middle at `middle`. `heading` gives the rope's heading in
/// radians at a share, 0 to 1, of its free part. The parts in the jaws are straight.
pub(crate) fn lay(
    nodes: usize,
    segment_px: f64,
    middle: [f64; 2],
    heading: impl Fn(f64) -> f64,
) -> Vec<[f64; 2]> {
    let held = (HELD - 1) as f64;
    let free = (nodes - 1) as f64 - 2.0 * held;
    let mut line = vec![[0.0; 2]];
    for segment in 0..nodes - 1 {
        let share = (segment as f64 + 0.5 - held) / free;
        let (sin, cos) = libm::sincos(heading(share.clamp(0.0, 1.0)));
        let [x, y] = line[segment];
        line.push([x + segment_px * cos, y + segment_px * sin]);
    }
    let mean = [0, 1].map(|axis| line.iter().map(|p| p[axis]).sum::<f64>() / nodes as f64);
    for point in &mut line {
        for axis in 0..2 {
            point[axis] += middle[axis] - mean[axis];
        }
    }
    line
}

/// Poses that hold such a rope: at its first end, and at its last one.
pub(crate) fn poses(line: &[[f64; 2]], heading: impl Fn(f64) -> f64) -> [Pose; 2] {
    let pose = |at, angle_rad| Pose { at, angle_rad };
    [
        pose(line[0], heading(0.0)),
        // At the last end, the rope leaves backward.
        pose(line[line.len() - 1], heading(1.0) + std::f64::consts::PI),
    ]
}

/// Returns `count` points (two or more) at equal steps of arc length, from the first point of a
/// line to its last.
pub fn at_equal_steps<const D: usize>(line: &[[f64; D]], count: usize) -> Vec<[f64; D]> {
    let chord = |i: usize| distance(line[i + 1], line[i]);
    let segments = line.len().saturating_sub(1);
    let length_px: f64 = (0..segments).map(chord).sum();
    let mut points = Vec::with_capacity(count);
    let (mut segment, mut passed_px) = (0, 0.0);
    for i in 0..count {
        if segments == 0 {
            points.extend(line.first());
            continue;
        }
        let goal_px = length_px * i as f64 / (count.max(2) - 1) as f64;
        while segment + 1 < segments && passed_px + chord(segment) < goal_px {
            passed_px += chord(segment);
            segment += 1;
        }
        let share = ((goal_px - passed_px) / chord(segment)).clamp(0.0, 1.0);
        let (p, q) = (line[segment], line[segment + 1]);
        points.push(std::array::from_fn(|axis| {
            p[axis] + share * (q[axis] - p[axis])
        }));
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_along_a_line_are_equal() {
        let line = [[0.0, 0.0], [3.0, 0.0], [3.0, 5.0]];
        let points = at_equal_steps(&line, 5);
        let truth = [[0.0, 0.0], [2.0, 0.0], [3.0, 1.0], [3.0, 3.0], [3.0, 5.0]];
        for (point, truth) in points.iter().zip(truth) {
            let off = (point[0] - truth[0]).abs() + (point[1] - truth[1]).abs();
            assert!(off < 1e-12, "{point:?}");
        }
        assert_eq!(at_equal_steps(&[[1.0, 2.0]], 2), [[1.0, 2.0]; 2]);
        assert!(at_equal_steps::<2>(&[], 3).is_empty());
    }
}
