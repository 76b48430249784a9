//! The distinct colors of a picture. A range's content is counted by color instead of by pixel.

use crate::image::{Image, color};
use crate::mask::hsv;
use crate::options::HsvRange;

/// Bits of each channel that distinguish colors. Finer steps are camera noise.
const BITS: usize = 6;

/// The colors of a picture.
#[derive(Debug)]
pub(super) struct Palette {
    /// Hue in degrees, saturation and value of each: the mean of its pixels.
    pub(super) colors: Vec<[f32; 3]>,
    /// Red, green and blue of each.
    pub(super) levels: Vec<[f32; 3]>,
    /// Number of pixels of each.
    count: Vec<f32>,
    /// The color of each pixel, in row order.
    pub(super) of: Vec<u32>,
}

impl Palette {
    pub(super) fn new(image: &Image) -> Self {
        let mut number = vec![u32::MAX; 1 << (3 * BITS)];
        let mut sums: Vec<[u32; 4]> = Vec::new();
        let mut of = Vec::with_capacity(image.width() * image.height());
        for y in 0..image.height() {
            for x in 0..image.width() {
                let rgb = color::rgb(image, x, y);
                let bin = rgb.iter().fold(0, |bin, &level| {
                    (bin << BITS) | usize::from(level >> (8 - BITS))
                });
                if number[bin] == u32::MAX {
                    number[bin] = sums.len() as u32;
                    sums.push([0; 4]);
                }
                let sum = &mut sums[number[bin] as usize];
                for (sum, level) in sum.iter_mut().zip(rgb) {
                    *sum += u32::from(level);
                }
                sum[3] += 1;
                of.push(number[bin]);
            }
        }
        let mean = |&[r, g, b, n]: &[u32; 4]| [r, g, b].map(|sum| sum as f32 / n as f32);
        let levels: Vec<[f32; 3]> = sums.iter().map(mean).collect();
        let color = |levels: &[f32; 3]| {
            let (hue, saturation, value) = hsv::hsv(levels.map(|level| (level + 0.5) as u8));
            [hue, saturation, value]
        };
        Self {
            colors: levels.iter().map(color).collect(),
            levels,
            count: sums.iter().map(|sum| sum[3] as f32).collect(),
            of,
        }
    }

    /// True for each color that is in one of the ranges.
    pub(super) fn held(&self, ranges: &[HsvRange]) -> Vec<bool> {
        let is_held = |color: &[f32; 3]| ranges.iter().any(|range| hsv::holds(range, *color));
        self.colors.iter().map(is_held).collect()
    }

    /// Number of pixels whose color satisfies `is_such`.
    pub(super) fn pixels(&self, is_such: impl Fn(usize) -> bool) -> f32 {
        let count = self.count.iter().enumerate();
        count.filter(|(i, _)| is_such(*i)).map(|(_, n)| n).sum()
    }
}
