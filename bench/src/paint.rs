//! Pictures drawn for measurements of speed: ropes along given lines, and patterns without a rope.

use std::f64::consts::PI;

use crate::Picture;
use anyhow::{Context, Result};

/// Width of all pictures, px.
pub const WIDTH: usize = 640;
/// Height of all pictures, px.
pub const HEIGHT: usize = 480;
const ROPE: [u8; 3] = [40, 92, 190];
const TABLE: [u8; 3] = [226, 221, 210];
/// Amplitude of the noise in levels. A pattern without noise is easier than a camera's picture.
const NOISE: u64 = 4;

/// Draws a picture. `cover` is the share (0 to 1) of a pixel that is rope. Values above 1 give a
/// pixel darker than the rope.
///
/// # Errors
/// Does not fail: the size is valid.
pub fn picture(cover: impl Fn(usize, usize) -> f64) -> Result<Picture> {
    let mut noise = Noise(1);
    let mut rgb = Vec::with_capacity(3 * WIDTH * HEIGHT);
    for (x, y) in (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y))) {
        let share = cover(x, y);
        for (table, rope) in TABLE.into_iter().zip(ROPE) {
            let level = f64::from(table) + share * (f64::from(rope) - f64::from(table));
            let off = (noise.next_number() % (2 * NOISE + 1)) as f64 - NOISE as f64;
            rgb.push((level + off).clamp(0.0, 255.0) as u8);
        }
    }
    Picture::rgb([WIDTH, HEIGHT], &rgb).context("three bytes a pixel are a picture")
}

/// Draws ropes along lines. Each line is a function of a parameter from 0 to 1.
fn ropes(lines: &[&dyn Fn(f64) -> [f64; 2]], width_px: f64) -> Result<Picture> {
    // One sample per quarter of a pixel of the longest line.
    const SAMPLES: usize = 40_000;
    let mut distance_px = vec![f64::INFINITY; WIDTH * HEIGHT];
    let reach = width_px / 2.0 + 1.0;
    for line in lines {
        for [x, y] in (0..=SAMPLES).map(|i| line(i as f64 / SAMPLES as f64)) {
            let span = |at: f64, end: usize| {
                let from = (at - reach).max(0.0) as usize;
                from..((at + reach) as usize + 1).min(end)
            };
            for (px, py) in span(y, HEIGHT).flat_map(|py| span(x, WIDTH).map(move |px| (px, py))) {
                let away = (px as f64 - x).hypot(py as f64 - y);
                let known = &mut distance_px[py * WIDTH + px];
                *known = known.min(away);
            }
        }
    }
    picture(|x, y| (width_px / 2.0 + 0.5 - distance_px[y * WIDTH + x]).clamp(0.0, 1.0))
}

/// Draws the Chebyshev curve x = T₅, y = T₆, which is open and has (5 − 1)(6 − 1) / 2 crossings.
///
/// # Errors
/// Does not fail: the size is valid.
pub fn ten_crossings() -> Result<Picture> {
    let line = |t: f64| {
        [
            0.5 * WIDTH as f64 + 290.0 * (5.0 * PI * t).cos(),
            0.5 * HEIGHT as f64 + 210.0 * (6.0 * PI * t).cos(),
        ]
    };
    ropes(&[&line], 12.0)
}

/// Draws eight ropes one above the other that do not touch.
///
/// # Errors
/// Does not fail: the size is valid.
pub fn eight_ropes() -> Result<Picture> {
    let lines: [_; 8] = std::array::from_fn(|k| {
        move |t: f64| {
            let wave = 12.0 * (2.0 * PI * (2.0 * t + k as f64 / 8.0)).sin();
            [40.0 + 560.0 * t, 30.0 + 60.0 * k as f64 + wave]
        }
    });
    let lines: Vec<&dyn Fn(f64) -> [f64; 2]> = lines.iter().map(|line| line as _).collect();
    ropes(&lines, 12.0)
}

/// A xorshift generator, whose noise is the same on every machine.
#[derive(Debug, Clone, Copy)]
pub struct Noise(pub u64);

impl Noise {
    /// Returns the next number, of 31 bits.
    pub fn next_number(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 33
    }
}
