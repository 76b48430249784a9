//! Whether the table's deviations from a smooth colour are a pattern or noise.
//!
//! Noise at one pixel says nothing about the next but one; a pattern does. The covariance of the deviations at pixels a
//! few steps apart (the autocovariance of the residuals, as a variogram has it) is the pattern's own variance, freed of
//! the noise's.

use super::background::Background;
use super::threshold;
use crate::image::gray::GrayPlane;
use crate::image::{Image, PixelFormat, color};
use lariat_portable::{Arch, NullaryFnOnce};

/// Samples along each side of the grid at most, and pixels from one to the next at least: a small picture has fewer.
const GRID: usize = 64;
const PITCH: usize = 3;
/// Samples that are worked on side by side.
const LANES: usize = 16;
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

    /// How far each pixel's channels are off the table's surface, in levels; 0 where it is not table.
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
        // Twice the least: squares of one color taken for the table, those of the other count in full.
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

/// A row of the grid.
struct Residuals {
    channels: [[f32; GRID]; 3],
    /// 1 for a pixel of the table, 0 for another.
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

/// Sums over pairs of pixels, to the right and down: how many, and the products of their residuals in each channel.
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
