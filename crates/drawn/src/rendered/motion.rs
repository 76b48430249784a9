//! Motion of the rope. Its heading as a function of arc length is a sum of a few slow bending modes
//! and one turn that now and then closes to a loop.
//!
//! The centerline is the integral of the heading, so its length never changes and equal steps along
//! it are equal arc lengths by construction. The motion repeats after [`PERIOD_S`]. The room that
//! it needs is therefore measured before the first frame, and the rope is made as long as the image
//! allows.

use super::RenderOptions;
use super::portable::{cos_turns, sin_turns, smoothstep};
use lariat_portable::SplitMix64;

/// Period of the motion, in seconds.
const PERIOD_S: f64 = 60.0;
/// Number of bending modes in addition to the loop.
const MODES: usize = 4;
/// Largest amplitude of the heading in each mode, in turns. Their sum is small enough that the rope
/// bends no tighter than a few times its width.
const MODE_TURNS: [f64; MODES] = [0.08, 0.07, 0.04, 0.02];
/// Bend at rest in each mode, in turns, to one side or the other.
const REST_TURNS: [f64; MODES] = [0.06, 0.13, 0.0, 0.0];
/// Number of moments at which the room is measured, one every 50 ms of the period.
const TRIALS: u32 = 1200;

/// A slow oscillation with a whole number of cycles per period.
#[derive(Debug, Clone, Copy)]
struct Wave {
    amplitude: f64,
    cycles: f64,
    phase: f64,
}

impl Wave {
    fn new(random: &mut SplitMix64, amplitude: f64, cycles: std::ops::Range<u64>) -> Self {
        let choices = cycles.end - cycles.start;
        Self {
            amplitude,
            cycles: (cycles.start + random.next_u64() % choices) as f64,
            phase: random.uniform(0.0, 1.0),
        }
    }

    fn at(&self, time_s: f64) -> f64 {
        self.amplitude * sin_turns(self.cycles * time_s / PERIOD_S + self.phase)
    }
}

/// Motion of the rope.
#[derive(Debug)]
pub(super) struct Motion {
    /// Heading of the rope as a whole, in turns.
    heading: f64,
    sway: Wave,
    modes: [Wave; MODES],
    rest: [f64; MODES],
    /// Degree to which the loop is closed; swings about ½ and saturates outside [0, 1].
    closing: Wave,
    /// For each segment, the shape of each mode, followed by the heading that the complete loop
    /// adds. In turns.
    basis: Vec<[f64; MODES + 1]>,
    /// Mean position of the centroid.
    centre_px: [f64; 2],
    drift_px: [Wave; 2],
    length_px: f64,
}

impl Motion {
    /// Makes the motion for the options' seed, in an image of their size.
    pub(super) fn new(options: &RenderOptions) -> Self {
        let random = &mut SplitMix64::of_stream(options.seed, 1);
        let size_px = [f64::from(options.width), f64::from(options.height)];
        let along = if size_px[0] < size_px[1] { 0.25 } else { 0.0 };
        let turned = 0.25 + 0.25 * random.sign();
        let mut motion = Self {
            heading: along + turned,
            sway: Wave::new(random, 0.05, 2..5),
            modes: MODE_TURNS.map(|turns| {
                let amplitude = turns * random.uniform(0.7, 1.0);
                Wave::new(random, amplitude, 2..6)
            }),
            rest: REST_TURNS.map(|turns| turns * random.sign() * random.uniform(0.7, 1.0)),
            closing: Wave {
                amplitude: 0.7,
                cycles: 2.0,
                // The rope begins open and crosses itself after about six seconds.
                phase: random.uniform(0.78, 0.86),
            },
            basis: Vec::new(),
            centre_px: [0.0; 2],
            drift_px: [0, 1].map(|axis| Wave::new(random, 0.03 * size_px[axis], 1..4)),
            length_px: 0.0,
        };
        let loop_turns = random.sign() * random.uniform(0.82, 0.92);
        let loop_at = random.uniform(0.6, 0.66);
        // About three pixels per segment, so that no corner is visible at their joints.
        let segments = (((size_px[0] + size_px[1]) / 6.0) as usize).max(96);
        motion.set_basis(segments, loop_at, loop_turns);
        motion.fit(options, size_px);
        motion
    }

    fn set_basis(&mut self, segments: usize, loop_at: f64, loop_turns: f64) {
        /// Share of the rope that the loop takes.
        const LOOP_SHARE: f64 = 0.46;
        self.basis = (0..segments)
            .map(|i| {
                let sigma = (i as f64 + 0.5) / segments as f64;
                let mut row = [0.0; MODES + 1];
                for (k, value) in row[..MODES].iter_mut().enumerate() {
                    *value = cos_turns((k + 1) as f64 * sigma / 2.0);
                }
                row[MODES] = loop_turns * smoothstep((sigma - loop_at) / LOOP_SHARE + 0.5);
                row
            })
            .collect();
    }

    /// Makes the rope as long as the image allows at every moment, and centers its motion.
    fn fit(&mut self, options: &RenderOptions, size_px: [f64; 2]) {
        let mut low = [f64::MAX; 2];
        let mut high = [f64::MIN; 2];
        let mut points = Vec::with_capacity(self.basis.len() + 1);
        for trial in 0..TRIALS {
            self.shape(PERIOD_S * f64::from(trial) / f64::from(TRIALS), &mut points);
            for point in &points {
                for axis in 0..2 {
                    low[axis] = low[axis].min(point[axis]);
                    high[axis] = high[axis].max(point[axis]);
                }
            }
        }
        let margin_px = options.rope_px + 0.02 * size_px[0].min(size_px[1]);
        let fits_px = [0, 1].map(|axis| {
            let room = size_px[axis] - 2.0 * (margin_px + self.drift_px[axis].amplitude);
            room / (high[axis] - low[axis])
        });
        self.length_px = fits_px[0].min(fits_px[1]);
        self.centre_px = [0, 1].map(|axis| {
            // The center of the top-left pixel is (0, 0).
            (size_px[axis] - 1.0) / 2.0 - self.length_px * (low[axis] + high[axis]) / 2.0
        });
    }

    /// Computes a rope of length 1 around its centroid.
    fn shape(&self, time_s: f64, points: &mut Vec<[f64; 2]>) {
        let heading = self.heading + self.sway.at(time_s);
        let closed = smoothstep(0.5 + self.closing.at(time_s));
        let mut swing = self.rest;
        for (swing, mode) in swing.iter_mut().zip(&self.modes) {
            *swing += mode.at(time_s);
        }
        let step = 1.0 / self.basis.len() as f64;
        points.clear();
        let [mut x, mut y] = [0.0, 0.0];
        let [mut sum_x, mut sum_y] = [0.0, 0.0];
        points.push([x, y]);
        for row in &self.basis {
            let mut turns = heading + closed * row[MODES];
            for k in 0..MODES {
                turns += swing[k] * row[k];
            }
            x += step * cos_turns(turns);
            y += step * sin_turns(turns);
            sum_x += x;
            sum_y += y;
            points.push([x, y]);
        }
        let count = points.len() as f64;
        for point in points {
            *point = [point[0] - sum_x / count, point[1] - sum_y / count];
        }
    }

    /// Length of the rope in pixels.
    pub(super) fn length_px(&self) -> f64 {
        self.length_px
    }

    /// Number of points that [`centerline`](Self::centerline) makes.
    pub(super) fn point_count(&self) -> usize {
        self.basis.len() + 1
    }

    /// Computes the centerline at this time, in pixels: points at equal steps from tip to tip.
    pub(super) fn centerline(&self, time_s: f64, points: &mut Vec<[f64; 2]>) {
        self.shape(time_s, points);
        let offset = [0, 1].map(|axis| self.centre_px[axis] + self.drift_px[axis].at(time_s));
        for point in points {
            for axis in 0..2 {
                point[axis] = self.length_px * point[axis] + offset[axis];
            }
        }
    }
}
