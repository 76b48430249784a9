//! A rendered rope with a known centerline. The same options give the same frames, bit for bit, on
//! every machine.
//!
//! The table and its light are drawn once. Each frame wipes the rope off, draws it at its new
//! position, and adds the camera's noise on the way into the caller's memory. Frame k depends only
//! on the options and on k.

pub(crate) mod draw;
mod motion;
pub(crate) mod mottling;
pub(crate) mod portable;
pub(crate) mod table;
pub(crate) mod truth;

use lariat_message::{Centerlines, MAX_POINTS, PixelFormat};
use thiserror::Error;

use draw::{Area, Brush, Canvas};
use motion::Motion;
use table::SensorNoise;

/// Appearance and motion of the rendered rope.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RenderOptions {
    /// Selects the rope, its motion and its noise.
    pub seed: u64,
    /// Pixels per row, 64 to 8192.
    pub width: u32,
    /// Number of rows, 64 to 8192.
    pub height: u32,
    /// Width of the rope in pixels: at least 3, at most a twentieth of the image's shorter side.
    pub rope_px: f64,
    /// Color of the rope in full light: red, green, blue.
    pub rope_rgb: [u8; 3],
    /// Color of the table in full light.
    pub table_rgb: [u8; 3],
    /// Standard deviation of the camera's noise, in steps of a byte, 0 to 4.
    pub noise: f64,
    /// Time between two frames of the rope's motion, in seconds. This does not affect the rate at
    /// which frames are sent.
    pub frame_interval_s: f64,
    /// Number of frames; `None`: unlimited.
    pub frames: Option<u64>,
    /// Number of points of the true centerline, 2 to 256.
    pub truth_points: u32,
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self {
            seed: 1,
            width: 640,
            height: 480,
            rope_px: 12.0,
            rope_rgb: [40, 92, 190],
            table_rgb: [226, 221, 210],
            noise: 2.5,
            frame_interval_s: 1.0 / 30.0,
            frames: None,
            truth_points: 120,
        }
    }
}

/// The options do not describe a picture of a rope.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("the rendered rope needs {what}")]
pub struct RenderError {
    /// The requirement, and the requested value.
    what: String,
}

impl RenderOptions {
    fn check(&self) -> Result<(), RenderError> {
        let require = |is_met: bool, what: String| {
            if is_met {
                Ok(())
            } else {
                Err(RenderError { what })
            }
        };
        let (width, height) = (self.width, self.height);
        let sizes = 64..=8192;
        require(
            sizes.contains(&width) && sizes.contains(&height),
            format!("an image of 64×64 to 8192×8192 pixels, not of {width}×{height}"),
        )?;
        let widest_px = f64::from(width.min(height)) / 20.0;
        require(
            (3.0..=widest_px).contains(&self.rope_px),
            format!(
                "a rope from 3 to {widest_px} pixels wide in this image (a twentieth of its shorter side), not {}",
                self.rope_px
            ),
        )?;
        require(
            (0.0..=4.0).contains(&self.noise),
            format!("noise from 0 to 4, not {}", self.noise),
        )?;
        require(
            (0.0..=3600.0).contains(&self.frame_interval_s),
            format!(
                "a time between frames of 0 to 3600 s, not {}",
                self.frame_interval_s
            ),
        )?;
        require(
            (2..=MAX_POINTS as u32).contains(&self.truth_points),
            format!(
                "2 to {MAX_POINTS} points of truth, not {}",
                self.truth_points
            ),
        )
    }
}

/// A film of the rendered rope.
#[derive(Debug)]
pub struct Rendered {
    options: RenderOptions,
    motion: Motion,
    brush: Brush,
    noise: SensorNoise,
    /// The table without the rope.
    table: Vec<u8>,
    /// The table with the rope, without noise.
    scene: Vec<u8>,
    /// Region where the scene differs from the table.
    drawn: Area,
    line: Vec<[f64; 2]>,
    sequence: u64,
}

impl Rendered {
    /// Makes the film, before its first frame.
    ///
    /// # Errors
    /// Returns an error if an option is out of its range.
    pub fn new(options: &RenderOptions) -> Result<Self, RenderError> {
        options.check()?;
        let motion = Motion::new(options);
        let table = table::lit_table(options);
        let row_bytes = PixelFormat::Rgb8.row_bytes(options.width);
        Ok(Self {
            options: *options,
            brush: Brush::new(options, motion.length_px()),
            noise: SensorNoise::new(options.seed, options.noise, row_bytes),
            scene: table.clone(),
            table,
            drawn: Area::default(),
            line: Vec::with_capacity(motion.point_count()),
            motion,
            sequence: 0,
        })
    }

    fn wipe(&mut self) {
        let width = self.options.width as usize;
        let Area { x, y } = self.drawn;
        for row in y[0]..y[1] {
            let bytes = 3 * (row * width + x[0])..3 * (row * width + x[1]);
            self.scene[bytes.clone()].copy_from_slice(&self.table[bytes]);
        }
    }

    /// Returns the options.
    pub fn options(&self) -> &RenderOptions {
        &self.options
    }

    /// Skips to the frame after number `sequence`, as if all frames up to it had been drawn.
    pub fn pass_over(&mut self, sequence: u64) {
        self.sequence = sequence;
    }

    /// Draws the next frame. Returns its number, from 1, or `None` after the last one.
    pub fn advance(&mut self) -> Option<u64> {
        if self.options.frames.is_some_and(|end| self.sequence >= end) {
            return None;
        }
        self.wipe();
        let time_s = self.sequence as f64 * self.options.frame_interval_s;
        self.sequence += 1;
        self.motion.centerline(time_s, &mut self.line);
        let (width, height) = (self.options.width as usize, self.options.height as usize);
        self.drawn = self.brush.area(&self.line, width, height);
        let canvas = &mut Canvas {
            pixels: &mut self.scene,
            width,
            height,
        };
        self.brush.draw(&self.line, canvas);
        Some(self.sequence)
    }

    /// Writes the frame's pixels (red, green, blue) with the camera's noise.
    pub fn write(&self, pixels: &mut [u8]) {
        let row_bytes = PixelFormat::Rgb8.row_bytes(self.options.width);
        self.noise
            .add(self.sequence, row_bytes, &self.scene, pixels);
    }

    /// Fills in the true position of the rope in this frame. Returns `false` before the first
    /// frame.
    pub fn truth(&self, truth: &mut Centerlines) -> bool {
        if self.line.is_empty() {
            return false;
        }
        truth.width = self.options.width;
        truth.height = self.options.height;
        truth::fill(
            &self.line,
            self.motion.length_px(),
            self.options.rope_px,
            self.options.truth_points as usize,
            truth,
        );
        true
    }
}
