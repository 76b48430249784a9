//! Ropes with a surface: round shading, a highlight, a shadow on what is below, and speckles.

use lariat_portable::SplitMix64;

use super::{Vec2, distance, normal};

/// A rope, or a part of one, to paint over the existing picture.
#[derive(Clone)]
pub(crate) struct Strand {
    pub points: Vec<Vec2>,
    pub width_px: f32,
    pub surface: Surface,
}

/// The look of a strand.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surface {
    pub color: [f32; 3],
    /// Darkening of the edges relative to the middle, as a share.
    pub shade: f32,
    /// Brightness of the highlight, in levels, and its position across the strand, in half-widths.
    pub gloss: f32,
    pub gloss_at: f32,
    /// Darkening of the surface below, directly at the strand's edge, as a share.
    pub shadow: f32,
    /// Standard deviation of its speckles, in levels.
    pub speckles: f32,
    /// Amplitude of the braid, in levels. Its stripes are slanted, four in every three widths.
    pub braid: f32,
}

/// A picture in progress.
pub(crate) struct Canvas {
    pub width: usize,
    pub height: usize,
    pub pixels: Vec<[f32; 3]>,
}

impl Canvas {
    pub(crate) fn new(width: usize, height: usize, table: [f32; 3]) -> Self {
        Self {
            width,
            height,
            pixels: vec![table; width * height],
        }
    }

    /// Paints `strand`, whose ends are cut straight.
    pub(crate) fn paint(&mut self, strand: &Strand, random: &mut SplitMix64) {
        let half = strand.width_px / 2.0;
        let shadow_px = 0.7 * half + 1.0;
        let mut lengths = vec![0.0];
        for pair in strand.points.windows(2) {
            lengths.push(lengths[lengths.len() - 1] + distance(pair[0], pair[1]));
        }
        let total = lengths[lengths.len() - 1];
        let mut nearest = vec![(f32::INFINITY, 0.0f32); self.pixels.len()];
        for (pair, &before) in strand.points.windows(2).zip(&lengths) {
            self.measure(pair, before, half + shadow_px + 1.0, &mut nearest);
        }
        let surface = strand.surface;
        for (pixel, (aside, along)) in self.pixels.iter_mut().zip(nearest) {
            if !aside.is_finite() {
                continue;
            }
            let share = (half - aside.abs() + 0.5).clamp(0.0, 1.0);
            // The shadow fades toward the ends of the strand, where it comes down to the table.
            let fade = (along.min(total - along) / (4.0 * half)).clamp(0.0, 1.0);
            let near = 1.0 - ((aside.abs() - half) / shadow_px).clamp(0.0, 1.0);
            let t = aside / half;
            let round = 1.0 - surface.shade * (t * t).min(1.0);
            let shine = surface.gloss * (-((t - surface.gloss_at) / 0.15).powi(2)).exp();
            let turns = along / (0.75 * strand.width_px) + 0.5 * t;
            let braid = surface.braid * (std::f32::consts::TAU * turns).sin();
            let speckle = surface.speckles * normal(random) + braid;
            for (p, c) in pixel.iter_mut().zip(surface.color) {
                let below = *p * (1.0 - surface.shadow * fade * near);
                *p = below + share * (c * round + shine + speckle - below);
            }
        }
    }

    /// Measures the offset from a straight segment, and the arc length, of the pixels near it.
    fn measure(&self, pair: &[Vec2], before: f32, reach: f32, nearest: &mut [(f32, f32)]) {
        let (a, b) = (pair[0], pair[1]);
        let length = distance(a, b).max(1e-6);
        let along = [(b[0] - a[0]) / length, (b[1] - a[1]) / length];
        let span = |c: usize, side: usize| {
            let low = (a[c].min(b[c]) - reach).max(0.0) as usize;
            low..((a[c].max(b[c]) + reach + 1.0).max(0.0) as usize).min(side)
        };
        for y in span(1, self.height) {
            for x in span(0, self.width) {
                let d = [x as f32 - a[0], y as f32 - a[1]];
                let ahead = d[0] * along[0] + d[1] * along[1];
                let aside = along[0] * d[1] - along[1] * d[0];
                // Half a pixel beyond the segment, so that bends leave no gaps.
                if (-0.5..=length + 0.5).contains(&ahead) {
                    let cell = &mut nearest[y * self.width + x];
                    if aside.abs() < cell.0.abs() {
                        *cell = (aside, before + ahead);
                    }
                }
            }
        }
    }

    /// Softens the picture with the weights 1, 2, 1 in both directions, `times` times.
    pub(crate) fn soften(&mut self, times: usize) {
        for step in [1, self.width].repeat(times) {
            let before = self.pixels.clone();
            for i in step..before.len() - step {
                let sides = [before[i - step], before[i + step]];
                self.pixels[i] = std::array::from_fn(|c| {
                    0.25 * (sides[0][c] + 2.0 * before[i][c] + sides[1][c])
                });
            }
        }
    }

    /// The picture as RGB bytes, with noise of this standard deviation.
    pub(crate) fn bytes(&self, noise: f32, random: &mut SplitMix64) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(3 * self.pixels.len());
        for pixel in &self.pixels {
            bytes.extend(pixel.map(|p| (p + noise * normal(random) + 0.5).clamp(0.0, 255.0) as u8));
        }
        bytes
    }
}
