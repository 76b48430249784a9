//! Rejects lines that are debris of the mask: noise and slivers.
//!
//! A stray is a short fragment. The thinner and fainter it is, the longer it must be to stay. A
//! sliver runs next to a longer line over its whole length, and is much thinner or much shorter. It
//! is a rim, a highlight or a shadow that the mask treats as a separate rope.

use crate::centerline::line::{Line, Sample};
use crate::image::gray::GrayPlane;
use crate::statistics::quantile;
use crate::vec2;

/// Minimum area of a rope, in squares of the ropes' width, weighted with the mask's level relative
/// to the best line. A rope shows more of itself, except beyond the image's border.
const LEAST_SQUARES: f32 = 4.5;
/// Maximum distance of a sliver's samples from the longer line's middle, in that line's widths, and
/// the minimum share of samples within it.
const BESIDE: (f32, f32) = (1.5, 0.9);
/// Maximum width of a sliver, relative to the longer line. It may be wider if it is short.
const THINNER: f32 = 0.6;
/// Maximum length of a sliver, relative to the longer line. It may be longer if it is thin.
const SHORTER: f32 = 0.5;
/// Number of places sampled along a line.
const ASKED: usize = 24;

/// Measurements of a line.
#[derive(Clone, Copy, Debug, Default)]
struct Figures {
    length_px: f32,
    width_px: f32,
    /// Mean level of the mask along it.
    level: f32,
    is_noise: bool,
}

/// Buffers and result of the step.
#[derive(Debug, Default)]
pub(crate) struct NoiseFilter {
    figures: Vec<Figures>,
    /// Buffer for medians.
    values: Vec<f32>,
    order: Vec<usize>,
}

impl NoiseFilter {
    /// Reserves memory for this many lines.
    pub(crate) fn reserve(&mut self, lines: usize) {
        self.figures.reserve(lines);
        self.order.reserve(lines);
        self.values.reserve(ASKED);
    }

    /// Finds noise and slivers, with `levels` as the confidence of the mask. The longest line
    /// always stays.
    pub(crate) fn find(&mut self, lines: &[Line], levels: &GrayPlane) {
        self.figures.clear();
        for line in lines {
            self.values.clear();
            self.values.extend(asked(line).map(|s| s.width_px));
            let width_px = quantile(&mut self.values, 0.5).max(1.0);
            let (mut level, mut count) = (0.0, 0);
            for sample in asked(line) {
                level += levels.sample(sample.at);
                count += 1;
            }
            self.figures.push(Figures {
                length_px: line.length_px(),
                width_px,
                level: level / count.max(1) as f32,
                is_noise: false,
            });
        }
        let width_px = self.usual_width_px();
        let sure = self.figures.iter().map(|f| f.level).fold(1.0, f32::max);
        let longest = (0..lines.len()).max_by(|&a, &b| {
            let [a, b] = [a, b].map(|l| self.figures[l].length_px);
            a.total_cmp(&b)
        });
        for l in 0..lines.len() {
            let own = self.figures[l];
            let squares = own.length_px / width_px * (own.width_px / width_px).min(1.0);
            let is_crumb = squares * own.level / sure < LEAST_SQUARES;
            self.figures[l].is_noise = Some(l) != longest && (is_crumb || self.is_sliver(l, lines));
        }
    }

    /// Returns whether line `l` of the last call of `find` is a stray or a sliver.
    pub(crate) fn is_noise(&self, l: usize) -> bool {
        self.figures.get(l).is_some_and(|f| f.is_noise)
    }

    /// Median width of the lines, weighted by length.
    fn usual_width_px(&mut self) -> f32 {
        let figures = &self.figures;
        self.order.clear();
        self.order.extend(0..figures.len());
        self.order
            .sort_unstable_by(|&a, &b| figures[a].width_px.total_cmp(&figures[b].width_px));
        let mut rest_px = 0.5 * figures.iter().map(|f| f.length_px).sum::<f32>();
        for &l in &self.order {
            rest_px -= figures[l].length_px;
            if rest_px <= 0.0 {
                return figures[l].width_px;
            }
        }
        1.0
    }

    fn is_sliver(&self, l: usize, lines: &[Line]) -> bool {
        let own = self.figures[l];
        (0..lines.len()).any(|other| {
            let longer = self.figures[other];
            let is_less = own.width_px < THINNER * longer.width_px
                || own.length_px < SHORTER * longer.length_px;
            let is_longer = longer.length_px > own.length_px && !longer.is_noise;
            is_longer && is_less && lies_beside(&lines[l], &lines[other], longer.width_px)
        })
    }
}

/// Samples spread evenly along a line.
fn asked(line: &Line) -> impl Iterator<Item = &Sample> {
    let stride = line.samples.len().div_ceil(ASKED).max(1);
    line.samples.iter().step_by(stride)
}

/// Returns whether nearly all of `line` is next to `longer`, a line of this width.
fn lies_beside(line: &Line, longer: &Line, width_px: f32) -> bool {
    let reach_px = BESIDE.0 * width_px;
    // Samples are at most a quarter of a width apart, and half a width is accurate enough.
    let step_px = longer.length_px() / longer.samples.len().max(1) as f32;
    let stride = ((0.5 * width_px / step_px.max(0.1)) as usize).max(1);
    let count = asked(line).count();
    let mut left = ((1.0 - BESIDE.1) * count as f32) as usize;
    for sample in asked(line) {
        let mut places = longer.samples.iter().step_by(stride);
        if places.all(|place| vec2::distance(place.at, sample.at) > reach_px) {
            let Some(fewer) = left.checked_sub(1) else {
                return false;
            };
            left = fewer;
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A straight line from left to right.
    fn line([x, y]: [f32; 2], length: usize, width_px: f32) -> Line {
        let sample = |i| Sample {
            at: [x + i as f32, y],
            weight: 1.0,
            width_px,
            side: 0.0,
        };
        Line {
            samples: (0..=length).map(sample).collect(),
            closed: false,
            border: [false; 2],
        }
    }

    fn noise(lines: &[Line], level: u8) -> Vec<bool> {
        let mut levels = GrayPlane::default();
        levels.resize(400, 200);
        // The mask is certain in the upper half.
        for y in 0..200 {
            levels.row_mut(y).fill(if y < 100 { 255 } else { level });
        }
        let mut noise = NoiseFilter::default();
        noise.find(lines, &levels);
        (0..lines.len()).map(|l| noise.is_noise(l)).collect()
    }

    #[test]
    fn a_short_piece_is_a_stray_and_the_only_one_is_not() {
        let rope = || line([20.0, 20.0], 300, 8.0);
        let crumb = || line([50.0, 80.0], 30, 8.0);
        let short = line([50.0, 50.0], 64, 8.0);
        assert_eq!(noise(&[rope(), short, crumb()], 255), [false, false, true]);
        assert_eq!(noise(&[crumb()], 255), [false]);
    }

    #[test]
    fn a_faint_piece_must_be_longer() {
        let lines = [line([20.0, 20.0], 300, 8.0), line([50.0, 150.0], 64, 8.0)];
        assert_eq!(noise(&lines, 255), [false, false]);
        assert_eq!(noise(&lines, 90), [false, true]);
    }

    #[test]
    fn a_sliver_goes_and_a_rope_beside_a_rope_stays() {
        let rope = || line([20.0, 20.0], 300, 8.0);
        let thin = line([40.0, 30.0], 250, 3.0);
        let beside = line([40.0, 30.0], 250, 7.0);
        assert_eq!(noise(&[rope(), thin], 255), [false, true]);
        assert_eq!(noise(&[rope(), beside], 255), [false, false]);
        // This line is as thin, but elsewhere.
        let thin = line([40.0, 60.0], 250, 3.0);
        assert_eq!(noise(&[rope(), thin], 255), [false, false]);
    }
}
