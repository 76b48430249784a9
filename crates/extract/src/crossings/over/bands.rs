//! Compares a strand's cross-sections along it. Except for brightness, the shade from edge to edge
//! is the same everywhere.
//!
//! Dashes and the grooves of a twisted rope make the surface vary along the strand. But each such
//! band runs all across it, straight or slanted, and so does not change the ratios between adjacent
//! lines. If the other strand is on top, its bands and shades run along this strand's
//! cross-sections, and these ratios change.

use super::axis::Axis;
use super::lines::{LINES, Line, block, core, levels};
use super::{Mean, beyond_px};
use crate::image::ray::{LANES, Lanes};

/// Slants of a band: pixels along the strand for each pixel across it.
const LEANS: [f32; 7] = [0.0, 0.25, -0.25, 0.5, -0.5, 0.75, -0.75];
/// Minimum number of lines for a band to count.
const FEWEST: f32 = 3.0;
/// Lower bound of a divisor that is a sum of shares.
const LEAST: f32 = 1e-3;

/// The lines along a strand, around another one.
pub(super) struct Bands<'a> {
    pub(super) lines: &'a [Line],
    pub(super) aside_px: &'a [f32; LINES],
    pub(super) step_px: f32,
    /// Distance from the other strand's axis up to which a place is in that strand's middle.
    pub(super) core_px: f32,
    pub(super) yuv: bool,
}

/// Each line's share of the mean of all lines, for each channel.
type Shares = [[f32; 3]; LINES];

impl Bands<'_> {
    /// Deviation of the first strand's lines, within the other, from their shares outside of it.
    #[inline(always)]
    pub(super) fn change(&self, [axis, other]: [&Axis; 2]) -> Mean {
        let beside_px = other.half_px + beyond_px(other.half_px);
        let Some(shares) = self.shares(axis.count, beside_px) else {
            return Mean::default();
        };
        let outside = |distances: &[f32], k: usize| {
            let (mut outside, here) = ([0.0; LANES], block(distances, k));
            for (outside, here) in outside.iter_mut().zip(here) {
                *outside = if here > beside_px { 1.0 } else { 0.0 };
            }
            outside
        };
        let mut best = (f32::INFINITY, 0.0);
        for lean in LEANS {
            let mean = self.off(axis.count, &shares, lean, outside);
            let off = mean.sum / mean.count.max(1.0);
            if mean.count > 0.0 && off < best.0 {
                best = (off, lean);
            }
        }
        self.off(axis.count, &shares, best.1, |distances, k| {
            core(distances, k, self.core_px)
        })
    }

    /// The shares at places where all lines are this far from the other strand, or `None` if there
    /// are too few such places.
    #[inline(always)]
    fn shares(&self, count: usize, beside_px: f32) -> Option<Shares> {
        let (mut sums, mut places) = ([[[0.0; LANES]; 3]; LINES], [0.0; LANES]);
        for first in (0..count).step_by(LANES) {
            let mut all = [1.0; LANES];
            for line in self.lines {
                let here = block(&line.distances.as_flattened()[..count], first);
                for (all, here) in all.iter_mut().zip(here) {
                    *all = if here > beside_px { *all } else { 0.0 };
                }
            }
            for (places, all) in places.iter_mut().zip(&all) {
                *places += all;
            }
            for (sums, line) in sums.iter_mut().zip(self.lines) {
                for (sums, channel) in sums.iter_mut().zip(&line.colors) {
                    let here = block(&channel.as_flattened()[..count], first);
                    for l in 0..LANES {
                        sums[l] += all[l] * here[l];
                    }
                }
            }
        }
        let sums = sums.map(|channels| channels.map(|sums| sums.iter().sum::<f32>()));
        let mean = |c: usize| sums.iter().map(|sums| sums[c]).sum::<f32>() / LINES as f32;
        let means = [mean(0), mean(1), mean(2)].map(|mean| mean.max(1.0));
        let shares = sums.map(|sums| [0, 1, 2].map(|c| sums[c] / means[c]));
        (places.iter().sum::<f32>() >= 2.0).then_some(shares)
    }

    /// Deviation of the lines from their shares of the common brightness at each place. `counts`
    /// returns the weights of places, from a line's distances from the other strand and the first
    /// place's index.
    #[inline(always)]
    fn off(
        &self,
        count: usize,
        shares: &Shares,
        lean: f32,
        counts: impl Fn(&[f32], usize) -> Lanes,
    ) -> Mean {
        let later = self.aside_px.map(|aside_px| {
            // Shifted so that no offset is negative.
            let on_px = lean * aside_px + lean.abs() * self.aside_px[LINES - 1];
            (on_px.max(0.0) / self.step_px + 0.5) as usize
        });
        let (mut sums, mut places) = ([0.0; LANES], [0.0; LANES]);
        for first in (0..count).step_by(LANES) {
            let mut weights = [[0.0; LANES]; LINES];
            let mut colors = [[[0.0; LANES]; 3]; LINES];
            let (mut seen, mut light) = ([0.0; LANES], [[0.0; LANES]; 3]);
            let mut whole = [[0.0; LANES]; 3];
            for (k, line) in self.lines.iter().enumerate() {
                let from = first + later[k];
                if from >= count {
                    continue;
                }
                weights[k] = counts(&line.distances.as_flattened()[..count], from);
                for l in 0..LANES {
                    let is_there = from + l < count;
                    weights[k][l] = if is_there { weights[k][l] } else { 0.0 };
                    seen[l] += weights[k][l];
                }
                for c in 0..3 {
                    colors[k][c] = block(&line.colors[c].as_flattened()[..count], from);
                    for l in 0..LANES {
                        light[c][l] += weights[k][l] * colors[k][c][l];
                        whole[c][l] += weights[k][l] * shares[k][c];
                    }
                }
            }
            for c in 0..3 {
                for l in 0..LANES {
                    light[c][l] /= whole[c][l].max(LEAST);
                }
            }
            for k in 0..LINES {
                for l in 0..LANES {
                    let off = |c: usize| (colors[k][c][l] - shares[k][c] * light[c][l]).abs();
                    let weight = if seen[l] >= FEWEST {
                        weights[k][l]
                    } else {
                        0.0
                    };
                    sums[l] += weight * levels([off(0), off(1), off(2)], self.yuv);
                    places[l] += weight;
                }
            }
        }
        Mean {
            sum: sums.iter().sum(),
            count: places.iter().sum(),
        }
    }
}
