//! Which of two strands lies on top where they cross, seen in the image.
//!
//! Along the upper strand its surface goes on: what is seen on a line that runs parallel to its axis
//! (a highlight, the shade toward its edge, its color) is the same before the crossing, in it, and
//! after it. Along the lower strand each such line is cut by the upper one's two edges, its shadow
//! and its own shading. So a few lines along each strand are looked at twice: how far the image
//! through the crossing is from what is predicted of it from just outside, and how much it changes
//! on the way through the middle of the crossing, where no blur of lens or motion mixes in the
//! table. The upper strand is the one that surprises less. That compares colors, shading and edges
//! at once, and needs no model of a rope or of the light.

use std::ops::Range;

use crate::Image;
use crate::color;
use crate::place::{Place, spline, tangent};
use crate::scene::Curve;
use crate::vec2::{self, Vec2};

/// Lines along each strand.
const LINES: usize = 5;
/// How far aside the outermost lines run, in half-widths: farther out, lens and table mix into the
/// strand's own color.
const SPAN: f32 = 0.7;
/// Beyond the other strand's edge the lens and an error of the width reach this far, in pixels…
const BLUR_PX: f32 = 1.5;
/// …and a shadow of it, in half-widths.
const SHADOW: f32 = 0.5;
/// The middle of the crossing, in half-widths of the other strand, and at least a sharp lens's blur
/// within its edges, in pixels.
const CORE: f32 = 0.8;
const SHARP_PX: f32 = 1.0;
/// How much is looked at before and after the crossing, in half-widths of the other strand, and at
/// least in pixels.
const AROUND: f32 = 1.6;
const AROUND_LEAST_PX: f32 = 4.0;
/// The most samples that one such look takes.
const MOST_AROUND: usize = 24;
/// Strands that cross at a flatter angle than this sine are looked at no farther than it tells.
const FLATTEST: f32 = 0.12;
/// The most samples of an axis: what the above comes to when the step is a twelfth of the width.
const MOST_SAMPLES: usize = 320;
/// Levels of difference that mean nothing: rounding.
const ROUNDING: f32 = 1.0;
/// How fast certainty grows with the margin between the strands. The logistic regression of "right"
/// over 2200 drawn crossings (every contrast from none on; braided, speckled, blurred by lens and by
/// motion, shining, flat) gives a slope of 12 for the log-odds; half of it makes the hyperbolic
/// tangent of the same curve. The number of samples does not enter: what misleads is not noise.
const CERTAINTY: f32 = 6.0;

/// Memory of the step.
#[derive(Debug)]
pub(crate) struct Judge {
    axes: [Axis; 2],
    line: Line,
}

/// One line along a strand.
#[derive(Debug)]
struct Line {
    /// How far each sample of the axis, moved aside to the line, is from the other strand's axis.
    distances: Vec<f32>,
    /// The image before, in and after the crossing.
    colors: Vec<[f32; 3]>,
}

impl Default for Judge {
    fn default() -> Self {
        // All that it can come to, so that no later crossing, flatter than those before, allocates.
        let axis = || Axis {
            samples: Vec::with_capacity(MOST_SAMPLES),
            center: 0,
            half_px: 0.0,
        };
        Self {
            axes: [axis(), axis()],
            line: Line {
                distances: Vec::with_capacity(MOST_SAMPLES),
                colors: Vec::with_capacity(MOST_SAMPLES),
            },
        }
    }
}

/// What the image says.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Verdict {
    /// Whether the second strand is the upper one.
    pub(crate) second: bool,
    /// From 0 (a toss of a coin) to 1 (certain): 2p − 1 for a probability p of being right.
    pub(crate) confidence: f32,
}

/// A strand's axis around the crossing, finely sampled.
#[derive(Debug)]
struct Axis {
    samples: Vec<Sample>,
    /// The sample at the crossing.
    center: usize,
    half_px: f32,
}

#[derive(Clone, Copy, Debug)]
struct Sample {
    at: Vec2,
    normal: Vec2,
}

/// How little the image along a strand is that of a surface that goes on.
#[derive(Clone, Copy, Debug, Default)]
struct Surprise {
    /// Off what is seen outside of the crossing.
    off: Mean,
    /// Off the line's own mean in the middle of the crossing.
    unsteady: Mean,
}

/// A mean of differences, in levels.
#[derive(Clone, Copy, Debug, Default)]
struct Mean {
    sum: f32,
    count: f32,
}

impl Judge {
    /// Compares the strands around places `a` and `b`, which lie over each other.
    pub(crate) fn judge(&mut self, image: &Image, curves: &[Curve], [a, b]: [Place; 2]) -> Verdict {
        let widths = [a, b].map(|place| curves[place.curve].width_px);
        let [ta, tb] = [a, b].map(|place| tangent(&curves[place.curve], place.at));
        let sin = vec2::cross(ta, tb).abs().max(FLATTEST);
        let across_px = 0.5 * (widths[0] + widths[1]) / sin;
        let wider_px = 0.5 * widths[0].max(widths[1]);
        let reach_px = 1.1 * across_px + beyond_px(wider_px) + around_px(wider_px) + BLUR_PX;
        // At a pixel's steps nothing is missed; of thick ropes a dozen steps a width tell as much.
        let step_px = ((widths[0] + widths[1]) / 24.0).max(1.0);
        let mut reaches = [[reach_px; 2]; 2];
        if a.curve == b.curve {
            share_loop(&curves[a.curve], [a.at, b.at], &mut reaches);
        }
        for ((axis, place), reach) in self.axes.iter_mut().zip([a, b]).zip(reaches) {
            axis.lay(&curves[place.curve], place.at, reach, step_px);
        }
        let [first, second] = &self.axes;
        let [a, b] = [[first, second], [second, first]]
            .map(|[axis, other]| surprise(image, axis, other, step_px, &mut self.line));
        verdict(a, b)
    }
}

/// Ends the axes of two places of one curve, the first before the second, halfway between them: a
/// small loop is not to be followed into the other pass.
fn share_loop(curve: &Curve, [first, second]: [f32; 2], reaches: &mut [[f32; 2]; 2]) {
    let half_px = |way: f32| 0.5 * way * curve.spacing_px();
    let between = half_px(second - first);
    reaches[0][1] = reaches[0][1].min(between);
    reaches[1][0] = reaches[1][0].min(between);
    if curve.closed {
        let around = half_px(curve.intervals() as f32 - (second - first));
        reaches[0][0] = reaches[0][0].min(around);
        reaches[1][1] = reaches[1][1].min(around);
    }
}

/// The upper strand is the one that surprises less.
fn verdict(a: Surprise, b: Surprise) -> Verdict {
    let margin = a.off.above(b.off) + a.unsteady.above(b.unsteady);
    Verdict {
        second: margin > 0.0,
        confidence: (CERTAINTY * margin.abs()).tanh(),
    }
}

impl Mean {
    fn add(&mut self, levels: f32) {
        self.sum += levels;
        self.count += 1.0;
    }

    /// How much larger than `other` it is, from −1 to 1; 0 when one of them is not known.
    fn above(self, other: Mean) -> f32 {
        if self.count == 0.0 || other.count == 0.0 {
            return 0.0;
        }
        let (a, b) = (self.sum / self.count, other.sum / other.count);
        (a - b) / (a + b + ROUNDING)
    }
}

/// How far beyond the edge of a strand of this half-width another one is disturbed by it.
fn beyond_px(half_px: f32) -> f32 {
    BLUR_PX + SHADOW * half_px
}

fn around_px(half_px: f32) -> f32 {
    (AROUND * half_px).max(AROUND_LEAST_PX)
}

impl Axis {
    /// Samples `curve` every `step_px` around place `at`, as far back and ahead as `reach_px` says.
    fn lay(&mut self, curve: &Curve, at: f32, reach_px: [f32; 2], step_px: f32) {
        self.samples.clear();
        self.center = 0;
        self.half_px = 0.5 * curve.width_px;
        let step = step_px / curve.spacing_px().max(1e-3);
        let most = |px: f32| ((px / step_px) as i32).min(MOST_SAMPLES as i32 / 2 - 1);
        let [back, ahead] = reach_px.map(most);
        let last = curve.intervals() as f32;
        for k in -back..=ahead {
            let place = at + step * k as f32;
            if !curve.closed && !(0.0..=last).contains(&place) {
                continue;
            }
            if k <= 0 {
                self.center = self.samples.len();
            }
            self.samples.push(Sample {
                at: spline(curve, place),
                normal: vec2::normal(tangent(curve, place)),
            });
        }
    }

    /// The distance from `p` to the axis near sample `from`, and the nearest sample.
    fn distance(&self, p: Vec2, from: usize) -> (f32, usize) {
        let square = |i: usize| {
            let d = vec2::sub(p, self.samples[i].at);
            vec2::dot(d, d)
        };
        let (mut i, mut best) = (from, square(from));
        loop {
            let ahead = (i + 1 < self.samples.len()).then(|| (square(i + 1), i + 1));
            let back = (i > 0).then(|| (square(i - 1), i - 1));
            match ahead.into_iter().chain(back).find(|(d, _)| *d < best) {
                Some((d, j)) => (best, i) = (d, j),
                None => return (best.sqrt(), i),
            }
        }
    }
}

/// How much the lines along `axis` are disturbed where `other` lies over or under it.
fn surprise(image: &Image, axis: &Axis, other: &Axis, step_px: f32, line: &mut Line) -> Surprise {
    let mut all = Surprise::default();
    if axis.samples.is_empty() || other.samples.is_empty() {
        return all;
    }
    let yuv = color::is_yuv(image.format());
    let touched_px = other.half_px + beyond_px(other.half_px);
    let core_px = (CORE * other.half_px).min(other.half_px - SHARP_PX);
    let around = ((around_px(other.half_px) / step_px) as usize).clamp(2, MOST_AROUND);
    for k in 0..LINES {
        let share = 2.0 * k as f32 / (LINES - 1) as f32 - 1.0;
        let aside_px = SPAN * axis.half_px * share;
        let point = |sample: &Sample| vec2::along(sample.at, sample.normal, aside_px);
        line.distances.clear();
        let mut near = other.center;
        line.distances.extend(axis.samples.iter().map(|sample| {
            let (distance, at) = other.distance(point(sample), near);
            near = at;
            distance
        }));
        let Some(inside) = touched(&line.distances, axis.center, touched_px) else {
            continue;
        };
        let seen =
            inside.start.saturating_sub(around)..(inside.end + around).min(axis.samples.len());
        line.colors.clear();
        let samples = &axis.samples[seen.clone()];
        line.colors
            .extend(samples.iter().map(|s| color::between(image, point(s))));
        // Three samples are less than a width.
        if 2.0 * step_px <= other.half_px {
            smooth(&mut line.colors);
        }
        let inside_seen = inside.start - seen.start..inside.end - seen.start;
        all.off
            .add_prediction(&line.colors, inside_seen.clone(), yuv);
        let core = line.distances[inside].iter().map(|d| *d < core_px);
        let colors = line.colors[inside_seen].iter().zip(core);
        all.unsteady
            .add_change(colors.filter(|(_, core)| *core).map(|(c, _)| *c), yuv);
    }
    all
}

/// Averages each with its neighbors: what the camera's noise adds to a difference falls by half.
fn smooth(colors: &mut [[f32; 3]]) {
    let Some(mut before) = colors.first().copied() else {
        return;
    };
    for i in 1..colors.len().saturating_sub(1) {
        let [here, after] = [colors[i], colors[i + 1]];
        colors[i] = std::array::from_fn(|c| (before[c] + here[c] + after[c]) / 3.0);
        before = here;
    }
}

/// The samples around `center` that lie within `touched_px` of the other strand.
fn touched(distances: &[f32], center: usize, touched_px: f32) -> Option<Range<usize>> {
    let near = (0..distances.len())
        .filter(|&i| distances[i] < touched_px)
        .min_by_key(|i| i.abs_diff(center))?;
    let back = distances[..near].iter().rev();
    let from = near - back.take_while(|d| **d < touched_px).count();
    let ahead = distances[near..].iter();
    let to = near + ahead.take_while(|d| **d < touched_px).count();
    Some(from..to)
}

impl Mean {
    /// Adds how far the samples `inside` are from what those before and after them say.
    fn add_prediction(&mut self, colors: &[[f32; 3]], inside: Range<usize>, yuv: bool) {
        let outside = [&colors[..inside.start], &colors[inside.end..]];
        let (from, to) = match outside.map(median_color) {
            [Some(from), Some(to)] => (from, to),
            // The strand ends in the crossing.
            [Some(one), None] | [None, Some(one)] => (one, one),
            [None, None] => return,
        };
        let steps = inside.len() as f32 + 1.0;
        for (k, color) in colors[inside].iter().enumerate() {
            let t = (k as f32 + 1.0) / steps;
            let expected = std::array::from_fn(|c| from[c] + t * (to[c] - from[c]));
            self.add(difference(*color, expected, yuv));
        }
    }

    /// Adds how far the colors are from their mean.
    fn add_change(&mut self, colors: impl Iterator<Item = [f32; 3]> + Clone, yuv: bool) {
        let (mut count, mut sum) = (0.0, [0.0; 3]);
        for color in colors.clone() {
            count += 1.0;
            sum = std::array::from_fn(|c| sum[c] + color[c]);
        }
        // Fewer have little choice but to be near their mean.
        if count >= 3.0 {
            let mean = sum.map(|s| s / count);
            colors.for_each(|color| self.add(difference(color, mean, yuv)));
        }
    }
}

/// The mean difference of a channel, U and V counting double as they span half the range.
fn difference(a: [f32; 3], b: [f32; 3], yuv: bool) -> f32 {
    let chroma = if yuv { 2.0 } else { 1.0 };
    let d = |c: usize| (a[c] - b[c]).abs();
    (d(0) + chroma * (d(1) + d(2))) / 3.0
}

/// The median of each channel; none of fewer than two samples.
fn median_color(colors: &[[f32; 3]]) -> Option<[f32; 3]> {
    let colors = &colors[..colors.len().min(MOST_AROUND)];
    if colors.len() < 2 {
        return None;
    }
    let mut channels = [[0.0; MOST_AROUND]; 3];
    for (k, color) in colors.iter().enumerate() {
        for (channel, value) in channels.iter_mut().zip(color) {
            channel[k] = *value;
        }
    }
    Some(channels.map(|mut channel| crate::background::median(&mut channel[..colors.len()])))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_one_curve_each_strand_ends_halfway_to_the_other() {
        let mut curve = Curve::empty();
        curve.points.resize(101, [0.0; 2]);
        curve.length_px = 200.0;
        let mut open = [[90.0; 2]; 2];
        share_loop(&curve, [20.0, 40.0], &mut open);
        assert_eq!(open, [[90.0, 20.0], [20.0, 90.0]]);
        curve.closed = true;
        curve.length_px = 202.0;
        let mut closed = [[90.0; 2]; 2];
        share_loop(&curve, [20.0, 40.0], &mut closed);
        assert_eq!(closed, [[81.0, 20.0], [20.0, 81.0]]);
    }
}
