//! Difference of the smoothed picture from the table, for pictures in which noise hides the rope in
//! single pixels.
//!
//! Noise is independent from pixel to pixel, and grain nearly so at a distance of three; a rope is
//! wider. Each channel's signed deviation from the table is therefore averaged around every pixel
//! before the channels are compared. Noise shrinks to a fifth, and the rope's edges stay where they
//! are.

use super::background::Background;
use crate::image::gray::GrayPlane;
use crate::image::{Image, color};
use crate::statistics::median;

/// A Gaussian of 1.3 px, from its middle outward, and its sum. It is wide enough for grain of two
/// pixels and narrower than ropes.
const GAUSSIAN: [f32; 4] = [1.0, 0.744, 0.306, 0.070];
const SUM: f32 = 3.240;
const REACH: usize = GAUSSIAN.len() - 1;
const ROWS: usize = 2 * REACH + 1;
/// Samples along each side of the grid on which the remaining noise is measured.
const GRID: usize = 48;

/// Memory of the step.
#[derive(Debug, Default)]
pub(crate) struct Smoother {
    /// Deviations along one row, padded with copies of those of the first and last pixels.
    row: Vec<[f32; 3]>,
    /// Some rows, each smoothed along itself.
    rows: [Vec<[f32; 3]>; ROWS],
    samples: Vec<f32>,
}

impl Smoother {
    /// Reserves the buffers for images of this width.
    pub(crate) fn reserve(&mut self, width: usize) {
        self.row.resize(width + 2 * REACH, [0.0; 3]);
        for row in &mut self.rows {
            row.resize(width, [0.0; 3]);
        }
        self.samples.reserve(GRID * GRID);
    }

    /// Writes the difference to `out`. Returns the remaining noise: the median of the difference.
    pub(crate) fn run(
        &mut self,
        image: &Image,
        background: &Background,
        out: &mut GrayPlane,
    ) -> f32 {
        let (width, height) = (image.width(), image.height());
        self.reserve(width);
        let chroma = color::chroma_weight(image.format());
        for y in 0..REACH.min(height) {
            self.take_row(image, background, y);
        }
        for y in 0..height {
            if y + REACH < height {
                self.take_row(image, background, y + REACH);
            }
            let place = |k: usize| (y + k).saturating_sub(REACH).min(height - 1) % ROWS;
            let rows: [&[[f32; 3]]; ROWS] = std::array::from_fn(|k| &self.rows[place(k)][..]);
            for (x, level) in out.row_mut(y).iter_mut().enumerate() {
                let mut sum = [0.0; 3];
                for (k, row) in rows.iter().enumerate() {
                    let weight = GAUSSIAN[k.abs_diff(REACH)];
                    (0..3).for_each(|c| sum[c] += weight * row[x][c]);
                }
                let [a, b, c] = sum.map(f32::abs);
                *level = (a.max(chroma * b.max(c)) / (SUM * SUM)).min(255.0) as u8;
            }
        }
        self.noise(out)
    }

    /// Smooths one row along itself.
    fn take_row(&mut self, image: &Image, background: &Background, y: usize) {
        let width = image.width();
        for x in 0..width {
            let pixel = color::native(image, x, y);
            let table = background.at_place([x as f32, y as f32]);
            self.row[REACH + x] = [0, 1, 2].map(|c| f32::from(pixel[c]) - table[c]);
        }
        let (first, last) = (self.row[REACH], self.row[REACH + width - 1]);
        self.row[..REACH].fill(first);
        self.row[REACH + width..].fill(last);
        let out = &mut self.rows[y % ROWS];
        for (out, around) in out.iter_mut().zip(self.row.windows(ROWS)) {
            let mut sum = [0.0; 3];
            for (k, value) in around.iter().enumerate() {
                let weight = GAUSSIAN[k.abs_diff(REACH)];
                (0..3).for_each(|c| sum[c] += weight * value[c]);
            }
            *out = sum;
        }
    }

    fn noise(&mut self, difference: &GrayPlane) -> f32 {
        let (width, height) = (difference.width(), difference.height());
        let (columns, rows) = (GRID.min(width), GRID.min(height));
        self.samples.clear();
        for j in 0..rows {
            let row = difference.row((2 * j + 1) * height / (2 * rows));
            let places = (0..columns).map(|i| (2 * i + 1) * width / (2 * columns));
            self.samples.extend(places.map(|x| f32::from(row[x]) + 0.5));
        }
        median(&mut self.samples)
    }
}
