//! The image on a few lines along a strand, and its deviation from a continuous surface.

use std::ops::Range;

use lariat_portable::Simd;

use super::axis::Axis;
use super::bands::Bands;
use super::{MOST_SAMPLES, Mean, Surprise, beyond_px};
use crate::image::ray::{LANES, Lanes};
use crate::image::{Image, color};

/// Number of lines along each strand.
pub(super) const LINES: usize = 5;
/// Offset of the outermost lines, in half-widths. Farther out, lens and table mix into the strand's
/// own color.
const SPAN: f32 = 0.7;
/// Extent of the crossing's middle, in half-widths of the other strand. It ends at least a sharp
/// lens's blur, in pixels, inside of that strand's edges.
const CORE: f32 = 0.8;
const SHARP_PX: f32 = 1.0;
/// Maximum number of blocks of samples.
const BLOCKS: usize = MOST_SAMPLES.div_ceil(LANES);

/// Memory of the lines along one strand.
#[derive(Debug)]
pub(super) struct Lines {
    lines: Vec<Line>,
    /// The colors as read.
    read: [Vec<Lanes>; 3],
}

/// One line along a strand.
#[derive(Debug)]
pub(super) struct Line {
    /// Distance from the other strand's axis to each sample of the axis, moved aside to the line.
    pub(super) distances: Vec<Lanes>,
    /// The image there, by channel.
    pub(super) colors: [Vec<Lanes>; 3],
    /// Samples that the other strand touches; may be empty.
    inside: Range<usize>,
}

impl Default for Lines {
    fn default() -> Self {
        let lanes = || vec![[0.0; LANES]; BLOCKS];
        let line = || Line {
            distances: lanes(),
            colors: [lanes(), lanes(), lanes()],
            inside: 0..0,
        };
        Self {
            lines: (0..LINES).map(|_| line()).collect(),
            read: [lanes(), lanes(), lanes()],
        }
    }
}

impl Lines {
    /// Measures how much the other strand disturbs the lines along the first axis, over or under
    /// it. The bands across it are measured only if `with_bands` is set.
    #[inline(always)]
    pub(super) fn surprise<S: Simd>(
        &mut self,
        simd: S,
        image: &Image,
        [axis, other]: [&Axis; 2],
        (step_px, with_bands): (f32, bool),
    ) -> Surprise {
        let mut all = Surprise::default();
        if axis.count == 0 || other.count == 0 {
            return all;
        }
        let mut aside_px = [0.0; LINES];
        for (k, aside_px) in aside_px.iter_mut().enumerate() {
            let share = 2.0 * k as f32 / (LINES - 1) as f32 - 1.0;
            *aside_px = SPAN * axis.half_px * share;
        }
        for (b, block) in axis.blocks.iter().enumerate() {
            let squares = other.squares(simd, block, &aside_px);
            for (line, squares) in self.lines.iter_mut().zip(&squares) {
                for (distance, square) in line.distances[b].iter_mut().zip(squares) {
                    *distance = square.sqrt();
                }
            }
        }
        let touched_px = other.half_px + beyond_px(other.half_px);
        // Smooth only if three samples span less than a width.
        let smooth = 2.0 * step_px <= other.half_px;
        for (line, aside_px) in self.lines.iter_mut().zip(aside_px) {
            let distances = &line.distances.as_flattened()[..axis.count];
            line.inside = touched(distances, axis.center, touched_px).unwrap_or(0..0);
            if !line.inside.is_empty() {
                line.look(image, axis, aside_px, smooth.then_some(&mut self.read));
            }
        }
        let yuv = color::is_yuv(image.format());
        let core_px = (CORE * other.half_px).min(other.half_px - SHARP_PX);
        for line in self.lines.iter().filter(|line| !line.inside.is_empty()) {
            line.add_change(core_px, yuv, &mut all.unsteady);
        }
        if with_bands && self.lines.iter().all(|line| !line.inside.is_empty()) {
            let bands = Bands {
                lines: &self.lines,
                aside_px: &aside_px,
                step_px,
                core_px,
                yuv,
            };
            all.bands = bands.change([axis, other]);
        }
        all
    }
}

impl Line {
    /// Fills in the colors along the axis. With `smoothing` as a buffer, each is averaged with its
    /// neighbors, which halves the camera noise in a difference.
    #[inline(always)]
    fn look(
        &mut self,
        image: &Image,
        axis: &Axis,
        aside_px: f32,
        smoothing: Option<&mut [Vec<Lanes>; 3]>,
    ) {
        let (from, to) = match smoothing {
            Some(read) => (read, Some(&mut self.colors)),
            None => (&mut self.colors, None),
        };
        for (b, block) in axis.blocks.iter().enumerate() {
            let colors = color::between_each(image, &block.moved(aside_px));
            for (channel, colors) in from.iter_mut().zip(&colors) {
                channel[b] = *colors;
            }
        }
        let Some(to) = to else {
            return;
        };
        for (to, from) in to.iter_mut().zip(from) {
            let from = &from.as_flattened()[..axis.count];
            let to = &mut to.as_flattened_mut()[..axis.count];
            let last = from.len() - 1;
            (to[0], to[last]) = (from[0], from[last]);
            if let Some(to) = to.get_mut(1..last) {
                let threes = from.iter().zip(&from[1..]).zip(&from[2..]);
                for (to, ((before, here), after)) in to.iter_mut().zip(threes) {
                    *to = (before + here + after) / 3.0;
                }
            }
        }
    }

    /// The channels of the samples inside of the crossing.
    #[inline(always)]
    fn within(&self) -> [&[f32]; 3] {
        let [a, b, c] = &self.colors;
        [
            &a.as_flattened()[self.inside.clone()],
            &b.as_flattened()[self.inside.clone()],
            &c.as_flattened()[self.inside.clone()],
        ]
    }

    /// Adds the deviations of the colors in the middle of the crossing from their mean.
    #[inline(always)]
    fn add_change(&self, core_px: f32, yuv: bool, mean: &mut Mean) {
        let [a, b, c] = self.within();
        let distances = &self.distances.as_flattened()[self.inside.clone()];
        let (mut counts, mut sums) = ([0.0; LANES], [[0.0; LANES]; 3]);
        for k in (0..a.len()).step_by(LANES) {
            let here = [block(a, k), block(b, k), block(c, k)];
            let core = core(distances, k, core_px);
            for l in 0..LANES {
                counts[l] += core[l];
                for c in 0..3 {
                    sums[c][l] += core[l] * here[c][l];
                }
            }
        }
        let count: f32 = counts.iter().sum();
        // Fewer samples are always near their mean.
        if count < 3.0 {
            return;
        }
        let mut middle = [0.0; 3];
        for (middle, sums) in middle.iter_mut().zip(&sums) {
            *middle = sums.iter().sum::<f32>() / count;
        }
        let mut sums = [0.0; LANES];
        for k in (0..a.len()).step_by(LANES) {
            let here = [block(a, k), block(b, k), block(c, k)];
            let core = core(distances, k, core_px);
            for l in 0..LANES {
                let off = |c: usize| (here[c][l] - middle[c]).abs();
                sums[l] += core[l] * levels([off(0), off(1), off(2)], yuv);
            }
        }
        mean.add(sums.iter().sum(), count);
    }
}

/// The numbers from place `k` on, and 0 beyond the last.
#[inline(always)]
pub(super) fn block(values: &[f32], k: usize) -> Lanes {
    let mut lanes = [0.0; LANES];
    let values = &values[k..];
    match values.first_chunk() {
        Some(whole) => lanes = *whole,
        None => lanes[..values.len()].copy_from_slice(values),
    }
    lanes
}

/// A weight of 1 for each distance from place `k` on that is less than `core_px`, otherwise 0.
#[inline(always)]
pub(super) fn core(distances: &[f32], k: usize, core_px: f32) -> Lanes {
    let (mut core, here) = ([0.0; LANES], block(distances, k));
    for l in 0..LANES {
        let is_core = (here[l] < core_px) & (k + l < distances.len());
        core[l] = if is_core { 1.0 } else { 0.0 };
    }
    core
}

/// Mean difference over the channels. U and V count double because they span half the range.
#[inline(always)]
pub(super) fn levels([a, b, c]: [f32; 3], yuv: bool) -> f32 {
    let chroma = if yuv { 2.0 } else { 1.0 };
    (a + chroma * (b + c)) / 3.0
}

/// The samples nearest to `center` that are within `touched_px` of the other strand.
#[inline(always)]
fn touched(distances: &[f32], center: usize, touched_px: f32) -> Option<Range<usize>> {
    let is_touched = |i: usize| distances.get(i).is_some_and(|d| *d < touched_px);
    let near = (0..distances.len()).find_map(|far| {
        let (back, ahead) = (center.checked_sub(far), center + far);
        let back = back.filter(|&i| is_touched(i));
        back.or_else(|| is_touched(ahead).then_some(ahead))
    })?;
    let back = distances[..near].iter().rev();
    let from = near - back.take_while(|d| **d < touched_px).count();
    let ahead = distances[near..].iter();
    let to = near + ahead.take_while(|d| **d < touched_px).count();
    Some(from..to)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_touched_nearest_to_the_crossing_counts() {
        let distances = [1.0, 1.0, 9.0, 9.0, 9.0, 1.0, 1.0, 1.0, 9.0];
        assert_eq!(touched(&distances, 3, 2.0), Some(0..2));
        assert_eq!(touched(&distances, 4, 2.0), Some(5..8));
        assert_eq!(touched(&distances, 8, 2.0), Some(5..8));
        assert_eq!(touched(&distances, 4, 0.5), None);
    }
}
