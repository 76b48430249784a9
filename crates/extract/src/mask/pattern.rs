//! Tells whether the table's deviations from a smooth color are a pattern or noise.
//!
//! Noise at one pixel says nothing about a pixel two steps away; a pattern does. The covariance of
//! the deviations at pixels a few steps apart (the autocovariance of the residuals, as in a
//! variogram) is the pattern's own variance, without that of the noise.

use super::background::Background;
use super::threshold;
use crate::image::gray::GrayPlane;
use crate::image::{Image, PixelFormat, color};
use lariat_portable::{Arch, NullaryFnOnce};

/// Maximum number of samples along each side of the grid, and minimum distance between them in
/// pixels. A small picture has fewer samples.
const GRID: usize = 64;
const PITCH: usize = 3;
/// Samples that are processed in parallel.
const LANES: usize = 16;
/// Distances from a pixel to those it is compared with, to the right and down, in pixels. Sensors
/// that interpolate color and cameras that compress the image spread noise to direct neighbors.
/// Squares of a few pixels change sign between two and six.
const LAGS: [usize; 3] = [2, 4, 6];
/// Maximum deviation that counts, as a multiple of the table's noise (the median deviation). A
/// faint rope deviates a lot in a few places, a pattern everywhere.
const MOST: f32 = 1.5;
/// Minimum deviation that matters, in levels. Above it, noise alone would raise the floor of the
/// cut.
const LEAST: f32 = threshold::LEVEL_FLOOR / threshold::NOISE_FLOOR;
/// Minimum ratio of a pattern to all deviation. Noise that a camera's compression has smoothed
/// reaches a third.
const SHARE: f32 = 0.5;
/// Distances for recognizing light and shade, as fractions of the image's shorter side. An eighth
/// and an eleventh are wider than ropes, and no pattern's period fits both.
const FAR: [usize; 2] = [8, 11];
/// Minimum share of their covariance that light and shade keep over that distance.
const STILL: f32 = 0.6;

/// Kind of the table's deviations from a smooth color.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Deviation {
    /// Noise, or too little to matter.
    Noise,
    /// A pattern of the size of ropes, or smaller.
    Pattern,
    /// Light and shade, or surfaces, much larger than ropes.
    Uneven,
}

/// Finds what sets the floor of the cut: the table's noise and the image's compression, or more.
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

/// An image, its estimated table, and the pixels that are table.
pub(crate) struct Table<'a> {
    pub(crate) image: &'a Image<'a>,
    pub(crate) background: &'a Background,
    pub(crate) difference: &'a GrayPlane,
    /// A pixel is table below this difference.
    pub(crate) cut: u8,
}

impl Table<'_> {
    /// Covariances of the deviations `lag` pixels apart, to the right and down, in squared levels.
    /// Each is the largest among the channels.
    fn covariances(&self, lag: usize) -> [f32; 2] {
        let (width, height) = (self.image.width(), self.image.height());
        if width <= lag || height <= lag {
            return [0.0; 2];
        }
        let along = |side: usize| GRID.min(side.div_ceil(PITCH)).min(side - lag);
        let (columns, rows) = (along(width), along(height));
        let place = |i: usize, count: usize, side: usize| (2 * i + 1) * (side - lag) / (2 * count);
        let table = self;
        let mut compared = Compared::default();
        let mut xs = [0; GRID];
        (0..columns).for_each(|i| xs[i] = place(i, columns, width));
        let there = xs.map(|x| x + lag);
        let (xs, there) = (&xs[..columns], &there[..columns]);
        for j in 0..rows {
            let y = place(j, rows, height);
            Arch::new().dispatch(Compare {
                table,
                here: (xs, y),
                others: [(there, y), (xs, y + lag)],
                compared: &mut compared,
            });
        }
        compared.covariances()
    }

    /// Deviation of each pixel's channels from the table's surface, in levels; 0 where the pixel is
    /// not table.
    #[inline(always)]
    fn residuals(&self, (xs, y): (&[usize], usize)) -> Residuals {
        let mut pixels = [0; GRID];
        color::at_places(self.image, y, xs.iter().copied(), &mut pixels[..xs.len()]);
        let mut off = Residuals::default();
        let [a, b, c] = &mut off.channels;
        self.background.at_each(xs, y, [a, b, c]);
        let difference = self.difference.row(y);
        for (is_table, &x) in off.is_table.iter_mut().zip(xs) {
            *is_table = if difference[x] < self.cut { 1.0 } else { 0.0 };
        }
        // Twice the minimum: if squares of one color are treated as the table, those of the other
        // color count in full.
        let most = (MOST * self.background.noise).max(2.0 * LEAST);
        let weights = match self.image.format() {
            PixelFormat::Gray8 => [1.0, 0.0, 0.0],
            format if color::is_yuv(format) => [1.0, 2.0, 2.0],
            _ => [1.0; 3],
        };
        for (c, levels) in off.channels.iter_mut().enumerate() {
            for i in 0..GRID {
                let pixel = (pixels[i] >> (8 * c) & 0xff) as i32 as f32;
                let level = weights[c] * (pixel - levels[i]);
                levels[i] = off.is_table[i] * level.min(most).max(-most);
            }
        }
        off
    }
}

/// The deviations of a row of the grid.
struct Residuals {
    channels: [[f32; GRID]; 3],
    /// 1 for a pixel of the table, 0 for any other.
    is_table: [f32; GRID],
}

impl Default for Residuals {
    #[inline(always)]
    fn default() -> Self {
        Self {
            channels: [[0.0; GRID]; 3],
            is_table: [0.0; GRID],
        }
    }
}

/// Sums over pairs of pixels, to the right and down: their number, and the products of their
/// residuals in each channel.
#[derive(Default)]
struct Compared {
    counts: [Lanes; 2],
    sums: [[Lanes; 3]; 2],
}

type Lanes = [f32; LANES];

impl Compared {
    fn covariances(&self) -> [f32; 2] {
        std::array::from_fn(|way| {
            let larger = |a: f32, b: f32| if b.abs() > a.abs() { b } else { a };
            let sums = self.sums[way].iter().map(|sums| sums.iter().sum::<f32>());
            sums.fold(0.0, larger) / self.counts[way].iter().sum::<f32>().max(1.0)
        })
    }
}

/// Compares a row of pixels with those to the right and those below.
struct Compare<'a> {
    table: &'a Table<'a>,
    here: (&'a [usize], usize),
    others: [(&'a [usize], usize); 2],
    compared: &'a mut Compared,
}

impl NullaryFnOnce for Compare<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Compared { counts, sums } = self.compared;
        let here = self.table.residuals(self.here);
        for (way, other) in self.others.into_iter().enumerate() {
            let there = self.table.residuals(other);
            add_products(&here.is_table, &there.is_table, &mut counts[way]);
            let channels = here.channels.iter().zip(&there.channels);
            for ((here, there), sums) in channels.zip(&mut sums[way]) {
                add_products(here, there, sums);
            }
        }
    }
}

#[inline(always)]
fn add_products(a: &[f32; GRID], b: &[f32; GRID], sums: &mut Lanes) {
    let pairs = a
        .as_chunks::<LANES>()
        .0
        .iter()
        .zip(b.as_chunks::<LANES>().0);
    for (a, b) in pairs {
        (0..LANES).for_each(|l| sums[l] += a[l] * b[l]);
    }
}
