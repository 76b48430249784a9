//! Which lines are crumbs of the mask and no ropes: noise and slivers.
//!
//! A stray is a short piece, the less of a rope the thinner and the fainter it is. A sliver lies beside a longer line all
//! along and is much thinner or much shorter: a rim, a highlight, a shadow that the mask took for a rope of its own.

use crate::centerline::line::{Line, Sample};
use crate::image::gray::GrayPlane;
use crate::statistics::quantile;
use crate::vec2;

/// Fewer squares of the ropes' width than this are a stray, where each counts as much as the mask is sure of it: a rope
/// shows more of itself, except beyond the picture's border.
const LEAST_SQUARES: f32 = 4.5;
/// How far from the longer line's middle a sliver's samples are at most, in that line's widths, and the share that must be.
const BESIDE: (f32, f32) = (1.5, 0.9);
/// A sliver is thinner than this share of the longer line, or shorter than that.
const THINNER: f32 = 0.6;
const SHORTER: f32 = 0.5;
/// Places along a line at which it is looked at.
const ASKED: usize = 24;

/// A line in figures.
#[derive(Clone, Copy, Debug, Default)]
struct Figures {
    length_px: f32,
    width_px: f32,
    /// The mask's mean along it.
    level: f32,
    is_noise: bool,
}

/// Memory and result of the step.
#[derive(Debug, Default)]
pub(crate) struct NoiseFilter {
    figures: Vec<Figures>,
    /// Memory for medians, and for what is to be summed by width.
    values: Vec<f32>,
    order: Vec<usize>,
}

impl NoiseFilter {
    /// Makes room for so many lines.
    pub(crate) fn reserve(&mut self, lines: usize) {
        self.figures.reserve(lines);
        self.order.reserve(lines);
        self.values.reserve(ASKED);
    }

    /// Judges lines by how sure the mask `levels` is along them; the longest always stays.
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

    /// Whether line `l` of those last judged is no rope.
    pub(crate) fn is_noise(&self, l: usize) -> bool {
        self.figures.get(l).is_some_and(|f| f.is_noise)
    }

    /// The width at which half of all length is reached, from the thinnest line on.
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

/// Samples evenly spread along a line.
fn asked(line: &Line) -> impl Iterator<Item = &Sample> {
    let stride = line.samples.len().div_ceil(ASKED).max(1);
    line.samples.iter().step_by(stride)
}

/// Whether nearly all of `line` lies beside `longer`, which is so wide.
fn lies_beside(line: &Line, longer: &Line, width_px: f32) -> bool {
    let reach_px = BESIDE.0 * width_px;
    // Samples are a quarter of a width apart or less; half a width is near enough.
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
        // The upper half is sure.
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
        // As thin, but elsewhere.
        let thin = line([40.0, 60.0], 250, 3.0);
        assert_eq!(noise(&[rope(), thin], 255), [false, false]);
    }
}
