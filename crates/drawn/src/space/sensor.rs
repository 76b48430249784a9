//! A depth camera's image, with its noise and its holes.

use super::eye::Eye;
use super::paint::{Hit, Hits, hits};
use super::rope::LiftedRope;
use lariat_portable::SplitMix64;

/// Number of rays along a pixel's side.
const RAYS: usize = 3;

/// Errors of a depth camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthSensor {
    /// Factor of the noise: the standard deviation of a depth z is this times z². The factor is s /
    /// (f B) for a disparity error of s pixels. In 1/mm.
    pub noise_per_mm: f64,
    /// Resolution of the depth, mm.
    pub unit_mm: f64,
    /// Side length, in pixels, of the square over which the noise is averaged: 1, or a larger odd
    /// number.
    pub grain_px: usize,
    /// Share of all pixels without a depth.
    pub holes: f64,
    /// Share of edge pixels without a depth. The other edge pixels see both sides of the edge and
    /// have a depth in between.
    pub edge_holes: f64,
    /// Offset of the second imager to the right, mm. Points that it cannot see have no depth. 0: no
    /// second imager.
    pub baseline_mm: f64,
}

impl DepthSensor {
    /// A current stereo camera at half a meter: 0.9 mm of noise, whole millimeters, a hundredth of
    /// holes, 50 mm of baseline.
    pub const STEREO: Self = Self {
        noise_per_mm: 0.9 / (500.0 * 500.0),
        unit_mm: 1.0,
        grain_px: 1,
        holes: 0.01,
        edge_holes: 0.5,
        baseline_mm: 50.0,
    };
}

/// A fixed depth camera for a series of images. It keeps the data that do not depend on the rope.
#[derive(Debug, Clone)]
pub struct DepthPainter {
    eye: Eye,
    sensor: DepthSensor,
    /// Depth of the table at each pixel.
    table: Vec<f64>,
    /// For the middle of each pixel: the depth of the table, and the column in which the second
    /// imager sees that point.
    middles: Vec<(f64, Option<usize>)>,
    /// Noise of the first image. Later images use the same noise from a random start.
    noise: Vec<f64>,
}

impl DepthPainter {
    /// Makes the camera in front of a table without a rope.
    pub fn new(eye: &Eye, sensor: &DepthSensor) -> Self {
        let [width, height] = eye.size;
        let places = || (0..width * height).map(|i| [i % width, i / width]);
        let empty = Hits::new(eye, RAYS);
        let middle = |[x, y]: [usize; 2]| {
            let (x, y) = (x as f64, y as f64);
            let depth = eye.table_depth(eye.ray([x, y]));
            let column = (x - eye.focal_px[0] * sensor.baseline_mm / depth).round();
            let is_seen = sensor.baseline_mm != 0.0 && column >= 0.0;
            (depth, is_seen.then(|| (column as usize).min(width - 1)))
        };
        Self {
            eye: *eye,
            sensor: *sensor,
            table: places().map(|at| mean(&empty.of_table(at))).collect(),
            middles: places().map(middle).collect(),
            noise: Vec::new(),
        }
    }

    /// Returns the depth image, row by row, in units; 0 where the depth is unknown.
    pub fn image(&mut self, rope: &LiftedRope, seed: u64) -> Vec<u16> {
        let mut random = SplitMix64::of_stream(seed, 2);
        let begin = match self.noise.len() {
            0 => {
                self.noise = noise(self.eye.size, self.sensor.grain_px, &mut random);
                0
            }
            count => random.below(count),
        };
        let Self { eye, sensor, .. } = &*self;
        let hits = hits(rope, eye, RAYS);
        let unseen = self.unseen_by_the_second(rope);
        let width = eye.size[0];
        let noise = self.noise[begin..].iter().chain(&self.noise);
        (self.table.iter().zip(noise).enumerate())
            .map(|(i, (&table, &noise))| {
                let (mean, on_rope) = match hits.near_rope([i % width, i / width]) {
                    Some(of_pixel) => {
                        let on_rope = of_pixel.iter().filter(|hit| hit.light.is_some());
                        (mean(of_pixel), on_rope.count())
                    }
                    None => (table, 0),
                };
                let is_edge = !matches!(on_rope, 0) && on_rope < RAYS * RAYS;
                let hole = random.unit() < sensor.holes
                    || random.unit() < sensor.edge_holes && is_edge
                    || unseen(i) && on_rope == 0;
                let measured = mean + sensor.noise_per_mm * mean * mean * noise;
                match hole {
                    true => 0,
                    false => (measured / sensor.unit_mm + 0.5).clamp(0.0, 65_535.0) as u16,
                }
            })
            .collect()
    }

    /// Returns a test for pixels that show a point hidden from the second imager by the rope.
    fn unseen_by_the_second(&self, rope: &LiftedRope) -> impl Fn(usize) -> bool + use<'_> {
        let Self { eye, sensor, .. } = self;
        let second = Eye {
            translation: [
                eye.translation[0] - sensor.baseline_mm,
                eye.translation[1],
                eye.translation[2],
            ],
            ..*eye
        };
        let there = hits(rope, &second, 1);
        let width = eye.size[0];
        move |i| {
            let (depth, column) = self.middles[i];
            let hits = column.and_then(|column| there.near_rope([column, i / width]));
            hits.is_some_and(|hits| hits[0].light.is_some() && hits[0].depth < depth - 1.0)
        }
    }
}

/// Mean depth of a pixel's rays.
fn mean(hits: &[Hit]) -> f64 {
    hits.iter().map(|hit| hit.depth).sum::<f64>() / hits.len() as f64
}

/// Draws a depth image, row by row, in units; 0 where the depth is unknown.
pub fn depth(rope: &LiftedRope, eye: &Eye, sensor: &DepthSensor, seed: u64) -> Vec<u16> {
    DepthPainter::new(eye, sensor).image(rope, seed)
}

/// Noise of variance 1, averaged over squares of this many pixels per side.
fn noise([width, height]: [usize; 2], grain: usize, random: &mut SplitMix64) -> Vec<f64> {
    let white: Vec<f64> = (0..width * height).map(|_| random.normal()).collect();
    if grain <= 1 {
        return white;
    }
    let reach = (grain / 2) as isize;
    (0..(width * height) as isize)
        .map(|i| {
            let (x, y) = (i % width as isize, i / width as isize);
            let mut sum = 0.0;
            for dy in -reach..=reach {
                for dx in -reach..=reach {
                    let column = (x + dx).rem_euclid(width as isize);
                    let row = (y + dy).rem_euclid(height as isize);
                    sum += white[(row * width as isize + column) as usize];
                }
            }
            sum / grain as f64
        })
        .collect()
}
