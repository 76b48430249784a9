//! Whether the table's deviations from a smooth colour are a pattern or noise.
//!
//! Noise at one pixel says nothing about the next but one; a pattern does. The covariance of the deviations at pixels a
//! few steps apart (the autocovariance of the residuals, as a variogram has it) is the pattern's own variance, freed of
//! the noise's.

use super::background::Background;
use super::threshold;
use crate::image::gray::GrayPlane;
use crate::image::{Image, color};

/// Samples along each side of the grid.
const GRID: usize = 64;
/// Steps from a pixel to the one it is compared with, to the right and down. Sensors that interpolate colour and cameras
/// that code the image spread noise to direct neighbors; squares of a few pixels change sign between two and six.
const LAGS: [usize; 3] = [2, 4, 6];
/// Deviations count up to this many times the table's noise (their median): a faint rope is far off in a few places, a
/// pattern deviates everywhere.
const MOST: f32 = 1.5;
/// The least deviation that matters, in levels: with more, noise alone would lift the floor of the cut.
const LEAST: f32 = threshold::LEVEL_FLOOR / threshold::NOISE_FLOOR;
/// A pattern is at least this share of all deviation: smoothing of noise by a camera's coding reaches a third.
const SHARE: f32 = 0.5;
/// An eighth and an eleventh of the image's shorter side are wider than ropes are, and no period fits both.
const FAR: [usize; 2] = [8, 11];
/// The share of their covariance that light and shade keep over that distance.
const STILL: f32 = 0.6;

/// What the table's deviations from a smooth colour are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Deviation {
    /// Noise, or too little to matter.
    Noise,
    /// A pattern of the size of ropes, or smaller.
    Pattern,
    /// Light and shade, or surfaces, much larger than ropes.
    Uneven,
}

/// What sets the floor of the cut: the table's noise and the coding of the image, or more.
pub(crate) fn deviation(table: &Table) -> Deviation {
    let all = LAGS.map(|lag| table.covariances(lag));
    let largest = all.into_iter().flatten().map(f32::abs).fold(0.0, f32::max);
    let pattern = largest.sqrt();
    let noise = table.background.noise;
    if pattern < SHARE * noise || pattern < LEAST {
        return Deviation::Noise;
    }
    let side = table.image.width().min(table.image.height());
    let mut far = FAR
        .into_iter()
        .flat_map(|part| table.covariances((side / part).max(LAGS[0])));
    match far.all(|covariance| covariance > STILL * largest) {
        true => Deviation::Uneven,
        false => Deviation::Pattern,
    }
}

/// An image, what was taken for its table, and which pixels were.
pub(crate) struct Table<'a> {
    pub(crate) image: &'a Image<'a>,
    pub(crate) background: &'a Background,
    pub(crate) difference: &'a GrayPlane,
    /// Below this difference a pixel is table.
    pub(crate) cut: u8,
}

impl Table<'_> {
    /// The covariance of the deviations `lag` pixels apart, to the right and down: that of the channel where it is
    /// largest, in squared levels.
    fn covariances(&self, lag: usize) -> [f32; 2] {
        let (width, height) = (self.image.width(), self.image.height());
        if width <= lag || height <= lag {
            return [0.0; 2];
        }
        let (columns, rows) = (GRID.min(width - lag), GRID.min(height - lag));
        let (mut counts, mut sums) = ([0u32; 2], [[0.0f32; 3]; 2]);
        for j in 0..rows {
            let y = (2 * j + 1) * (height - lag) / (2 * rows);
            for i in 0..columns {
                let x = (2 * i + 1) * (width - lag) / (2 * columns);
                let Some(here) = self.residual(x, y) else {
                    continue;
                };
                let others = [self.residual(x + lag, y), self.residual(x, y + lag)];
                for (way, there) in others.into_iter().enumerate() {
                    let Some(there) = there else { continue };
                    counts[way] += 1;
                    (0..3).for_each(|c| sums[way][c] += here[c] * there[c]);
                }
            }
        }
        std::array::from_fn(|way| {
            let larger = |a: f32, b: f32| if b.abs() > a.abs() { b } else { a };
            sums[way].into_iter().fold(0.0, larger) / counts[way].max(1) as f32
        })
    }

    /// How far the pixel's channels are off the table's surface, in levels; nothing where it is not table.
    fn residual(&self, x: usize, y: usize) -> Option<[f32; 3]> {
        if self.difference.row(y)[x] >= self.cut {
            return None;
        }
        let (pixel, table) = (color::native(self.image, x, y), self.background.at(x, y));
        let chroma = if color::is_yuv(self.image.format()) {
            2.0
        } else {
            1.0
        };
        // Twice the least: squares of one color taken for the table, those of the other count in full.
        let most = (MOST * self.background.noise).max(2.0 * LEAST);
        let weights = [1.0, chroma, chroma];
        Some(std::array::from_fn(|c| {
            (weights[c] * (f32::from(pixel[c]) - table[c])).clamp(-most, most)
        }))
    }
}
