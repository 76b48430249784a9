//! A lifted simulated rope in front of two cameras above its table: a color camera, and a depth
//! camera next to it.

use lariat_message::{Axes, Centerlines, Descriptors3, PixelFormat, Place, Status};
use lariat_portable::SplitMix64;
use lariat_simulation::{RADIUS_MM, SpaceSimulation};

use super::rays::{Rays, Tube};
use crate::rendered::RenderOptions;
use crate::rendered::table::{SensorNoise, lit_table, to_byte};
use crate::rendered::truth;
use crate::space::{DepthSensor, Eye};

/// Focal length of the color camera and its distance from the table's middle, per picture width. A
/// pixel is about a millimeter, and the picture includes the range of the grippers.
const FOCAL: f64 = 0.875;
const DISTANCE: f64 = 1.1875;
/// Tilt of the color camera from the vertical, degrees.
const LEAN_DEG: f64 = 15.0;
/// Image size and focal length of the depth camera.
const DEPTH_SIZE: [usize; 2] = [848, 480];
const DEPTH_FOCAL_PX: f64 = 425.0;
/// Offset of the depth camera from the color camera, mm.
const ASIDE_MM: [f64; 3] = [-15.0, 0.0, 0.0];
const SENSOR: DepthSensor = DepthSensor::STEREO;

/// Number of points of the drawn line per segment between nodes.
const FINER: usize = 3;
/// A gripper consists of two tubes with these radii: jaws that close around the rope's end, and a
/// wrist. The other two values are where each tube begins, relative to the rope's end. The wrist
/// ends where the jaws begin.
const JAWS_MM: f64 = 9.0;
const WRIST_MM: f64 = 18.0;
const JAWS_FROM_MM: f64 = -14.0;
const WRIST_FROM_MM: f64 = -60.0;
/// Distance between the balls that make up a gripper's tube, in radii.
const GRIPPER_STEP: f64 = 0.35;
/// Colors of rope and grippers: blue, and the orange of robots.
const RGB: [[f32; 3]; 2] = [[40.0, 92.0, 190.0], [204.0, 100.0, 40.0]];

/// Size of the table of depth noise. Each row of each image uses a different section of it.
const NOISE_DEPTHS: usize = 1 << 16;

/// Description of the two cameras, in the form of the users' own files (YAML).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SpaceCameras {
    /// Calibration of the color camera.
    pub color: String,
    /// Calibration of the depth camera, its pose and its error.
    pub depth: String,
    /// Pose of the color camera relative to the table, in whose frame the grippers move. For a
    /// robot, this is the base frame.
    pub pose: String,
}

impl SpaceCameras {
    /// Returns the color camera above the table, for pictures of this size.
    pub fn color_eye(picture: [u32; 2]) -> Eye {
        color_eye(picture.map(|side| side as usize))
    }

    /// Describes the cameras for pictures of this size.
    pub fn new(picture: [u32; 2]) -> Self {
        let eye = Self::color_eye(picture);
        let lens = |eye: &Eye| {
            let ([width, height], [x, y]) = (eye.size, eye.center_px);
            let [focal, _] = eye.focal_px;
            format!(
                "image_width: {width}\nimage_height: {height}\ncamera_matrix: [{focal}, 0, {x}, 0, {focal}, {y}, 0, 0, 1]\n\
                 distortion_coefficients: [0, 0, 0, 0]\n"
            )
        };
        let aside = ASIDE_MM;
        let noise_mm = SENSOR.noise_per_mm * 1e6;
        let [near, far] = [0.5, 1.5].map(|share| share * eye.translation[2]);
        let unit_mm = SENSOR.unit_mm;
        let depth = format!(
            "rotation: [0, 0, 0, 1]\ntranslation_mm: {aside:?}\ndepth_unit_mm: {unit_mm}\nnoise_mm_at_1m: {noise_mm}\n\
             range_mm: [{near}, {far}]\n"
        );
        // The inverse rotation, from the camera's frame.
        let back: [[f64; 3]; 3] = [0, 1, 2].map(|i| [0, 1, 2].map(|k| eye.rotation[k][i]));
        let place = back.map(|row| -row[2] * eye.translation[2]);
        let rows = back.as_flattened();
        Self {
            color: lens(&eye),
            depth: lens(&depth_eye(&eye)) + &depth,
            pose: format!("rotation: {rows:?}\ntranslation_mm: {place:?}\n"),
        }
    }
}

fn color_eye(size: [usize; 2]) -> Eye {
    let width = size[0] as f64;
    Eye::above(FOCAL * width, size, DISTANCE * width, LEAN_DEG, 0.0)
}

fn depth_eye(color: &Eye) -> Eye {
    color.beside(ASIDE_MM, DEPTH_FOCAL_PX, DEPTH_SIZE)
}

/// A lifted simulated rope as the two cameras see it.
#[derive(Debug)]
pub struct SpaceScene {
    color: Color,
    depth: Depth,
    /// Drawn line from end to end, and the indices where the part between the jaws begins and ends.
    line: Vec<[f64; 3]>,
    visible: [usize; 2],
    gripper: Vec<[f64; 3]>,
    /// Visible line in the picture.
    seen: Vec<[f64; 2]>,
}

#[derive(Debug)]
struct Color {
    eye: Eye,
    rays: Rays<3>,
    noise: SensorNoise,
    /// The table without anything on it.
    table: Vec<u8>,
    /// The picture without noise.
    pixels: Vec<u8>,
}

#[derive(Debug)]
struct Depth {
    eye: Eye,
    rays: Rays<2>,
    /// Rays of the second imager.
    second: Rays<1>,
    /// Distance of the table, mm.
    table: Vec<f32>,
    /// Measured distance; 0 where it is unknown.
    depths: Vec<f32>,
    /// Noise of variance 1; holes are NaN.
    noise: Vec<f32>,
    random: SplitMix64,
    seed: u64,
}

impl SpaceScene {
    /// Makes the scene of a simulation. `noise`: noise of the color camera, as a standard deviation
    /// in steps of a byte.
    pub fn new(simulation: &SpaceSimulation, noise: f64) -> Self {
        let options = simulation.options();
        let size = options.picture_px.map(|side| side as usize);
        let eye = color_eye(size);
        let looks = RenderOptions {
            seed: options.seed,
            width: size[0] as u32,
            height: size[1] as u32,
            noise,
            ..RenderOptions::default()
        };
        let table = lit_table(&looks);
        Self {
            color: Color {
                rays: Rays::new(&eye),
                noise: SensorNoise::new(options.seed, noise, 3 * size[0]),
                pixels: table.clone(),
                table,
                eye,
            },
            depth: Depth::new(&depth_eye(&eye), options.seed),
            line: Vec::with_capacity(FINER * simulation.nodes().len()),
            visible: [0; 2],
            gripper: Vec::new(),
            seen: Vec::new(),
        }
    }

    /// Returns width and height of the picture.
    pub fn size(&self) -> [u32; 2] {
        self.color.eye.size.map(|side| side as u32)
    }

    /// Returns width and height of the depth image.
    pub fn depth_size(&self) -> [u32; 2] {
        DEPTH_SIZE.map(|side| side as u32)
    }

    /// Draws the current state of the simulation.
    pub fn draw(&mut self, simulation: &SpaceSimulation) {
        self.trace(simulation);
        let Self {
            color,
            depth,
            line,
            gripper,
            ..
        } = self;
        color.clear();
        depth.clear();
        let rope = Tube {
            line,
            radius_mm: RADIUS_MM,
        };
        color.rays.trace(0, rope);
        depth.trace(0, rope);
        let tubes = [
            ([JAWS_FROM_MM, simulation.jaw_mm()], JAWS_MM),
            ([WRIST_FROM_MM, JAWS_FROM_MM], WRIST_MM),
        ];
        for pose in simulation.grippers() {
            for ([from, to], radius_mm) in tubes {
                let steps = ((to - from) / (GRIPPER_STEP * radius_mm)) as usize + 1;
                let step_mm = (to - from) / steps as f64;
                gripper.clear();
                gripper.extend((0..=steps).map(|i| pose.ahead(from + step_mm * i as f64)));
                let tube = Tube {
                    line: gripper,
                    radius_mm,
                };
                color.rays.trace(1, tube);
                depth.trace(1, tube);
            }
        }
        color.paint();
        depth.measure();
        let [from, to] = self.visible;
        self.seen.clear();
        let eye = &self.color.eye;
        let seen = self.line[from..to].iter().map(|&p| eye.pixel(eye.see(p)));
        self.seen.extend(seen);
    }

    /// Writes the picture with this frame's noise.
    pub fn write(&self, sequence: u64, pixels: &mut [u8]) {
        let Color { eye, noise, .. } = &self.color;
        let row_bytes = PixelFormat::Rgb8.row_bytes(eye.size[0] as u32);
        noise.add(sequence, row_bytes, &self.color.pixels, pixels);
    }

    /// Writes the depth image with this frame's noise, as units of two bytes in native byte order.
    pub fn write_depth(&self, sequence: u64, bytes: &mut [u8]) {
        self.depth.write(sequence, bytes);
    }

    /// Fills in the position of the rope between the jaws in the picture, with this many points.
    /// Returns `false` before the first frame.
    pub fn truth(&self, points: usize, message: &mut Centerlines) -> bool {
        if self.seen.len() < 2 {
            return false;
        }
        [message.width, message.height] = self.size();
        let chords = self.seen.windows(2).map(|pair| {
            let [x, y] = [pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]];
            (x * x + y * y).sqrt()
        });
        let length_px = chords.sum();
        let from = self.line[self.visible[0]];
        let ahead_mm = self.color.eye.see(from)[2];
        let width_px = 2.0 * RADIUS_MM * self.color.eye.focal_px[0] / ahead_mm;
        truth::fill(&self.seen, length_px, width_px, points, message);
        true
    }

    /// Fills in the 3-D position in the table's frame, with this many points at equal steps and
    /// without a curve. Returns `false` before the first frame.
    pub fn truth_in_space(&self, points: usize, message: &mut Descriptors3) -> bool {
        let [from, to] = self.visible;
        let line = &self.line[from..to];
        if line.len() < 2 || points < 2 {
            return false;
        }
        (message.count, message.axes) = (1, Axes::Robot as u32);
        let rope = &mut message.curves[0];
        let segments = line.len() - 1;
        let mut length_mm = 0.0;
        for pair in line.windows(2) {
            let square = |k: usize| (pair[1][k] - pair[0][k]) * (pair[1][k] - pair[0][k]);
            length_mm += (square(0) + square(1) + square(2)).sqrt();
        }
        let count = points.min(rope.points.len());
        for (i, point) in rope.points[..count].iter_mut().enumerate() {
            let place = i as f64 * segments as f64 / (count - 1) as f64;
            let segment = (place as usize).min(segments - 1);
            let share = place - segment as f64;
            let (p, q) = (line[segment], line[segment + 1]);
            *point = [0, 1, 2].map(|k| (p[k] + share * (q[k] - p[k])) as f32);
        }
        (rope.track, rope.status, rope.place) = (1, Status::Ok as u32, Place::Known as u32);
        (rope.count, rope.samples, rope.measured) = (0, count as u32, count as u32);
        (rope.length, rope.width, rope.confidence) = (length_mm, 2.0 * RADIUS_MM, 1.0);
        true
    }

    /// Computes a smooth line through the nodes (Catmull-Rom spline).
    fn trace(&mut self, simulation: &SpaceSimulation) {
        let nodes = simulation.nodes();
        self.line.clear();
        for (i, pair) in nodes.windows(2).enumerate() {
            let (p, q) = (pair[0], pair[1]);
            let before = nodes[i.saturating_sub(1)];
            let after = nodes[(i + 2).min(nodes.len() - 1)];
            for step in 0..FINER {
                let t = step as f64 / FINER as f64;
                self.line.push([0, 1, 2].map(|k| {
                    let (a, b) = (0.5 * (q[k] - before[k]), 0.5 * (after[k] - p[k]));
                    let d = q[k] - p[k];
                    p[k] + t * (a + t * ((3.0 * d - 2.0 * a - b) + t * (a + b - 2.0 * d)))
                }));
            }
        }
        self.line.push(nodes[nodes.len() - 1]);
        let count = simulation.visible().len();
        let first = (nodes.len() - count) / simulation.grippers().len();
        self.visible = [FINER * first, FINER * (first + count - 1) + 1];
    }
}

impl Color {
    fn clear(&mut self) {
        for (pixel, _) in self.rays.pixels() {
            let bytes = 3 * pixel..3 * pixel + 3;
            self.pixels[bytes.clone()].copy_from_slice(&self.table[bytes]);
        }
        self.rays.clear();
    }

    fn paint(&mut self) {
        let share = 1.0 / Rays::<3>::EACH as f32;
        for (pixel, hits) in self.rays.pixels() {
            let of_pixel = &mut self.pixels[3 * pixel..3 * pixel + 3];
            for (channel, byte) in of_pixel.iter_mut().enumerate() {
                let table = f32::from(self.table[3 * pixel + channel]);
                let seen = hits.iter().map(|hit| match hit.tube {
                    Some(tube) => RGB[tube as usize][channel] * (0.55 + 0.45 * hit.light),
                    None => table,
                });
                *byte = to_byte(share * seen.sum::<f32>());
            }
        }
    }
}

impl Depth {
    fn new(eye: &Eye, seed: u64) -> Self {
        let [width, height] = eye.size;
        let random = &mut SplitMix64::of_stream(seed, 6);
        let second = Eye {
            translation: [
                eye.translation[0] - SENSOR.baseline_mm,
                eye.translation[1],
                eye.translation[2],
            ],
            ..*eye
        };
        let table: Vec<f32> = (0..width * height)
            .map(|i| {
                let pixel = [(i % width) as f64, (i / width) as f64];
                eye.table_depth(eye.ray(pixel)) as f32
            })
            .collect();
        let noise = (0..NOISE_DEPTHS + width).map(|_| match random.unit() < SENSOR.holes {
            true => f32::NAN,
            false => random.normal() as f32,
        });
        Self {
            rays: Rays::new(eye),
            second: Rays::new(&second),
            noise: noise.collect(),
            depths: table.clone(),
            table,
            random: SplitMix64::of_stream(seed, 7),
            seed,
            eye: *eye,
        }
    }

    fn clear(&mut self) {
        // Pixels that were hidden from the second imager are reset, too.
        self.depths.copy_from_slice(&self.table);
        self.rays.clear();
        self.second.clear();
    }

    fn trace(&mut self, number: u8, tube: Tube) {
        self.rays.trace(number, tube);
        self.second.trace(number, tube);
    }

    fn measure(&mut self) {
        self.hide();
        for (pixel, hits) in self.rays.pixels() {
            let on_tubes = hits.iter().filter(|hit| hit.tube.is_some()).count();
            if on_tubes == 0 {
                continue;
            }
            let is_edge = on_tubes < hits.len();
            let sum: f32 = hits.iter().map(|hit| hit.depth_mm).sum();
            self.depths[pixel] = match is_edge && self.random.unit() < SENSOR.edge_holes {
                true => 0.0,
                false => sum / hits.len() as f32,
            };
        }
    }

    /// Removes the depth of pixels that a tube hides from the second imager.
    fn hide(&mut self) {
        let width = self.eye.size[0];
        let baseline_px_mm = self.eye.focal_px[0] * SENSOR.baseline_mm;
        for (pixel, hits) in self.second.pixels() {
            let Some(hit) = hits.first().filter(|hit| hit.tube.is_some()) else {
                continue;
            };
            let (column, row) = (pixel % width, pixel / width);
            let ahead_mm = f64::from(self.table[pixel]);
            let to = column as f64 + baseline_px_mm / ahead_mm;
            // The table's depth changes little along a row, so one more column on each side
            // includes all pixels that lead here.
            let first = (to.max(1.0) as usize - 1).min(width);
            for x in first..(first + 3).min(width) {
                let at = row * width + x;
                let ahead_mm = self.table[at];
                let seen_at = (x as f64 - baseline_px_mm / f64::from(ahead_mm)).round();
                if seen_at == column as f64 && hit.depth_mm < ahead_mm - 1.0 {
                    self.depths[at] = 0.0;
                }
            }
        }
    }

    fn write(&self, sequence: u64, bytes: &mut [u8]) {
        let width = self.eye.size[0];
        let random = &mut SplitMix64::of_stream(self.seed ^ 0xDE97, sequence);
        let rows = self.depths.chunks_exact(width);
        let per_unit = 1.0 / SENSOR.unit_mm as f32;
        let noise_per_mm = SENSOR.noise_per_mm as f32;
        for (depths, bytes) in rows.zip(bytes.chunks_exact_mut(2 * width)) {
            let start = random.below(NOISE_DEPTHS);
            let noise = &self.noise[start..start + width];
            for ((bytes, &depth), noise) in bytes.chunks_exact_mut(2).zip(depths).zip(noise) {
                // NaN becomes 0, and 0 remains 0.
                let units = (depth + noise_per_mm * depth * depth * noise) * per_unit + 0.5;
                bytes.copy_from_slice(&(units as u16).to_ne_bytes());
            }
        }
    }
}

#[cfg(test)]
mod tests;
