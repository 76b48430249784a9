//! A writhing rope. Its heading is that of a more or less closed ring, plus bending modes that
//! swing at different rates.
//!
//! The centerline is the integral of the heading. Its length never changes, and equal steps along
//! it are equal arc lengths.

use crate::rendered::portable::{cos_turns, sin_turns};
use lariat_portable::SplitMix64;

/// Amplitudes of the bending modes, in turns.
const MODE_TURNS: [f64; 4] = [0.14, 0.12, 0.08, 0.04];
/// Number of segments of the centerline.
const SEGMENTS: usize = 240;

/// A periodic swing.
#[derive(Debug, Clone, Copy)]
struct Wave {
    amplitude: f64,
    period_s: f64,
    phase: f64,
}

impl Wave {
    fn new(random: &mut SplitMix64, amplitude: f64, periods_s: [f64; 2]) -> Self {
        Self {
            amplitude,
            period_s: random.uniform(periods_s[0], periods_s[1]),
            phase: random.uniform(0.0, 1.0),
        }
    }

    fn at(&self, time_s: f64) -> f64 {
        self.amplitude * sin_turns(time_s / self.period_s + self.phase)
    }
}

/// Motion of one rope.
#[derive(Debug)]
pub(super) struct Writhe {
    heading: f64,
    sway: Wave,
    /// Turns of the ring, and their swing.
    curl: f64,
    curling: Wave,
    modes: [Wave; 4],
    /// Bending of each segment by each mode.
    shapes: Vec<[f64; 4]>,
    centre_px: [f64; 2],
    drift_px: [Wave; 2],
    length_px: f64,
}

impl Writhe {
    /// Makes a rope that stays within an image of this size.
    pub(super) fn new(random: &mut SplitMix64, size_px: [f64; 2], rope_px: f64) -> Self {
        let side_px = size_px[0].min(size_px[1]);
        let curl = random.sign() * random.uniform(0.7, 1.0);
        let mut writhe = Self {
            heading: random.uniform(0.0, 1.0),
            sway: Wave::new(random, 0.1, [9.0, 16.0]),
            curl,
            curling: Wave::new(random, 0.45, [7.0, 13.0]),
            modes: MODE_TURNS.map(|turns| Wave::new(random, turns, [5.0, 11.0])),
            shapes: (0..SEGMENTS).map(shape).collect(),
            centre_px: size_px.map(|side| 0.5 * side),
            drift_px: [0, 1].map(|axis| Wave::new(random, 0.05 * size_px[axis], [6.0, 14.0])),
            length_px: 1.0,
        };
        // The rope is made as long as possible while it stays inside. The tested moments extend
        // over many periods.
        let mut points = Vec::new();
        let mut farthest = [0.0f64; 2];
        for trial in 0..2000 {
            let time_s = 0.37 * f64::from(trial);
            writhe.centerline(time_s, [0.0; 2], &mut points);
            let middle =
                [0, 1].map(|axis| writhe.centre_px[axis] + writhe.drift_px[axis].at(time_s));
            for p in &points {
                for axis in 0..2 {
                    farthest[axis] = farthest[axis].max((p[axis] - middle[axis]).abs());
                }
            }
        }
        let room = [0, 1].map(|axis| (0.44 * size_px[axis] - 1.5 * rope_px) / farthest[axis]);
        writhe.length_px = room[0].min(room[1]).min(1.9 * side_px);
        writhe
    }

    pub(super) fn length_px(&self) -> f64 {
        self.length_px
    }

    /// Computes the centerline at this time, moved by `offset`: points at equal steps from tip to
    /// tip.
    pub(super) fn centerline(&self, time_s: f64, offset: [f64; 2], points: &mut Vec<[f64; 2]>) {
        let heading = self.heading + self.sway.at(time_s);
        let curl = self.curl + self.curling.at(time_s);
        let swing = self.modes.map(|mode| mode.at(time_s));
        let step_px = self.length_px / SEGMENTS as f64;
        points.clear();
        let (mut at, mut sum) = ([0.0; 2], [0.0; 2]);
        points.push(at);
        for (i, shape) in self.shapes.iter().enumerate() {
            let mut turns = heading + curl * (middle(i) - 0.5);
            for (swing, shape) in swing.iter().zip(shape) {
                turns += swing * shape;
            }
            at = [
                at[0] + step_px * cos_turns(turns),
                at[1] + step_px * sin_turns(turns),
            ];
            sum = [sum[0] + at[0], sum[1] + at[1]];
            points.push(at);
        }
        let count = points.len() as f64;
        let by = [0, 1].map(|axis| {
            let centre = self.centre_px[axis] + self.drift_px[axis].at(time_s) + offset[axis];
            centre - sum[axis] / count
        });
        for point in points {
            *point = [point[0] + by[0], point[1] + by[1]];
        }
    }
}

/// Position of a segment's middle along the rope, from 0 to 1.
fn middle(segment: usize) -> f64 {
    (segment as f64 + 0.5) / SEGMENTS as f64
}

/// Bending of a segment by each mode.
fn shape(segment: usize) -> [f64; 4] {
    let sigma = middle(segment);
    std::array::from_fn(|k| cos_turns((k + 1) as f64 * sigma / 2.0))
}
