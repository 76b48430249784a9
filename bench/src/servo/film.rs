//! The animated picture: the camera's view, the controller's result, and the remaining error. A
//! lifted rope is also shown from the side.
//!
//! Pictures are scaled down and drawn on as they arrive. At the end, when the whole duration is
//! known, a strip with the error is added to each, and all become one GIF.

mod dashes;
mod encode;
mod strip;

use anyhow::Result;
use dashes::dashes;
use image::{RgbImage, imageops};
use lariat_chain::canvas::Canvas;

/// Maximum width of the film. Wider pictures are scaled down by an integer factor.
const WIDTH_PX: usize = 320;
/// Interval between two pictures of the film.
const STEP_S: f64 = 0.1;
/// Look-ahead time of the arrows that show a gripper's motion.
const AHEAD_S: f64 = 0.5;
/// Maximum length of an arrow and radius of a turn's arrow, in pixels of the film.
const LONGEST_PX: f64 = 44.0;
const TURN_PX: f64 = 9.0;
/// Minimum length of an arrow, in pixels of the film. Shorter ones are not drawn.
const SHORTEST_PX: f64 = 5.0;

const TARGET: [u8; 3] = [0, 150, 60];
const SEEN: [u8; 3] = [255, 140, 0];
const UNSURE: [u8; 3] = [190, 0, 90];
const ROPE: [u8; 3] = [150, 180, 220];
const ARROW: [u8; 3] = [20, 20, 20];
const WHITE: [u8; 3] = [255, 255, 255];

/// A film in progress.
#[derive(Debug)]
pub(super) struct Film {
    /// Size of the camera's images.
    size_px: [usize; 2],
    /// Camera pixels per film pixel, along each side.
    scale: usize,
    /// The target in each view, in pixels of the film.
    target: Vec<Vec<[f64; 2]>>,
    pictures: Vec<Picture>,
    /// Time and error of every shot, including those between pictures.
    errors: Vec<[f64; 2]>,
    next_s: f64,
}

/// A picture of the film without its strip.
#[derive(Debug)]
struct Picture {
    at_s: f64,
    picture: RgbImage,
}

/// The data of one time.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shot<'a> {
    /// Red, green, blue, row by row, without padding.
    pub rgb: &'a [u8],
    pub sketch: &'a Sketch,
    /// Time since the first image.
    pub at_s: f64,
    pub error_px: f64,
}

/// The drawing over an image, in all its views. Positions are in the image's pixels.
#[derive(Debug, Clone, Default)]
pub(super) struct Sketch {
    /// The true rope, for images that do not show it, and its width.
    pub rope: Vec<[f64; 2]>,
    pub rope_px: f64,
    /// The curve that the controller received, once in each view. Empty if there was none.
    pub seen: Vec<Vec<[f64; 2]>>,
    pub control_points: Vec<[f64; 2]>,
    /// Regions that contain the control points with 95 % probability, if known.
    pub ellipses: Vec<Vec<[f64; 2]>>,
    /// Position of each gripper and its motion: px/s to the right and down, rad/s clockwise.
    pub grippers: Vec<([f64; 2], [f64; 3])>,
}

impl Film {
    /// Creates a film of a camera with images of this size. `target` is the target curve in each
    /// view.
    pub(super) fn new(size_px: [usize; 2], target: &[Vec<[f64; 2]>]) -> Self {
        let scale = size_px[0].div_ceil(WIDTH_PX).max(1);
        Self {
            size_px,
            scale,
            target: target.iter().map(|line| all_smaller(line, scale)).collect(),
            pictures: Vec::new(),
            errors: Vec::new(),
            next_s: f64::NEG_INFINITY,
        }
    }

    /// Returns whether a shot at this time becomes a picture. Other shots contribute only their
    /// error.
    pub(super) fn wants(&self, at_s: f64) -> bool {
        // A camera's images may arrive slightly early.
        at_s >= self.next_s - 0.1 * STEP_S
    }

    /// Adds a shot, which must be later than the previous ones. An image whose size differs from
    /// the film's adds no picture.
    pub(super) fn add(&mut self, shot: &Shot) {
        self.errors.push([shot.at_s, shot.error_px]);
        let [width, height] = self.size_px.map(|side| side as u32);
        let has_image =
            shot.rgb.len() == 3 * self.size_px.iter().product::<usize>() && !shot.rgb.is_empty();
        if !self.wants(shot.at_s) || !has_image {
            return;
        }
        let Some(image) = RgbImage::from_raw(width, height, shot.rgb.to_vec()) else {
            return;
        };
        self.next_s = match self.pictures.first() {
            // The film keeps its own rhythm from its first picture on, independent of the images'
            // times.
            Some(first) => {
                let beats = ((shot.at_s - first.at_s) / STEP_S + 0.1).floor() + 1.0;
                first.at_s + beats * STEP_S
            }
            None => shot.at_s + STEP_S,
        };
        let scale = self.scale as u32;
        let small = imageops::thumbnail(&image, width / scale, height / scale);
        let mut canvas = Canvas::on(small);
        self.draw(&mut canvas, shot.sketch);
        let at_s = shot.at_s;
        let picture = canvas.picture;
        self.pictures.push(Picture { at_s, picture });
    }

    fn draw(&self, canvas: &mut Canvas, sketch: &Sketch) {
        let places = |line: &[[f64; 2]]| all_smaller(line, self.scale);
        canvas.line(&places(&sketch.rope), sketch.rope_px / self.scale as f64);
        canvas.ink(ROPE, 1.0);
        for dash in self.target.iter().flat_map(|line| dashes(line, [6.0, 4.0])) {
            canvas.line(&dash, 2.0);
        }
        canvas.ink(TARGET, 1.0);
        for line in &sketch.seen {
            canvas.line(&places(line), 1.4);
        }
        canvas.ink(SEEN, 1.0);
        for ellipse in &sketch.ellipses {
            canvas.line(&places(ellipse), 1.2);
        }
        canvas.ink(UNSURE, 1.0);
        let points = places(&sketch.control_points);
        canvas.dots(&points, 5.2);
        canvas.ink(WHITE, 1.0);
        canvas.dots(&points, 3.6);
        canvas.ink(SEEN, 1.0);
        for &(at, velocity) in &sketch.grippers {
            arrows(canvas, smaller(at, self.scale), velocity, self.scale);
        }
    }

    /// Returns the film as a GIF that loops.
    ///
    /// # Errors
    /// No picture was added, or it is too large for a GIF.
    pub(super) fn finish(self) -> Result<Vec<u8>> {
        let strip = strip::Strip::new(&self.errors);
        let pictures: Vec<(f64, RgbImage)> = (self.pictures.into_iter())
            .map(|picture| (picture.at_s, strip.below(&picture.picture, picture.at_s)))
            .collect();
        encode::gif(&pictures)
    }
}

/// Maps camera pixels to film pixels. Pixel centers are integers in both.
fn smaller(p: [f64; 2], scale: usize) -> [f64; 2] {
    p.map(|c| (c + 0.5) / scale as f64 - 0.5)
}

fn all_smaller(line: &[[f64; 2]], scale: usize) -> Vec<[f64; 2]> {
    line.iter().map(|&p| smaller(p, scale)).collect()
}

/// Draws arrows for a gripper's motion and turn.
fn arrows(canvas: &mut Canvas, at: [f64; 2], [vx, vy, turn]: [f64; 3], scale: usize) {
    let ahead = [vx, vy].map(|v| AHEAD_S * v / scale as f64);
    let length = (ahead[0] * ahead[0] + ahead[1] * ahead[1]).sqrt();
    let mut lines = Vec::new();
    if length > SHORTEST_PX {
        let share = (LONGEST_PX / length).min(1.0);
        let tip = [0, 1].map(|k| at[k] + share * ahead[k]);
        lines.push((share * length, vec![at, tip]));
    }
    // Limited so that the head does not reach the tail.
    let angle = (AHEAD_S * turn).clamp(-5.0, 5.0);
    if (TURN_PX * angle).abs() > SHORTEST_PX {
        let point = |i: u32| {
            let (sine, cosine) = libm::sincos(angle * f64::from(i) / 16.0);
            // Clockwise from the top.
            [at[0] + TURN_PX * sine, at[1] - TURN_PX * cosine]
        };
        lines.push((TURN_PX * angle.abs(), (0..=16).map(point).collect()));
    }
    // A light rim separates the arrows from the rope.
    for (width, color) in [(3.6, WHITE), (1.7, ARROW)] {
        for (length, line) in &lines {
            canvas.line(line, width);
            canvas.head(line, (0.6 * length).min(5.0), width);
        }
        canvas.ink(color, 1.0);
    }
}

#[cfg(test)]
mod tests;
