//! Which of two strands lies on top where they cross, seen in the image.
//!
//! Along the upper strand its surface goes on: what is seen on a line that runs parallel to its axis
//! (a highlight, the shade toward its edge, its color) is the same before the crossing, in it, and
//! after it. Along the lower strand each such line is cut by the upper one's two edges, its shadow
//! and its own shading. So a few lines along each strand are predicted through the crossing from
//! what is seen on them just outside; the upper strand is the one whose prediction fails less.
//! That compares colors, shading and edges at once, and needs no model of a rope or of the light.

use crate::Image;
use crate::color;
use crate::meet::Place;
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
/// How fast certainty grows with the margin between the strands and with the root of the samples,
/// as if each were a measurement of its own. The logistic regression of "right" over 3000 drawn
/// crossings, of every contrast from none on, some braided, some speckled, gives a slope of 3.9 for
/// the log-odds; half of it makes the hyperbolic tangent of the same curve.
const CERTAINTY: f32 = 1.9;

/// Memory of the step.
#[derive(Debug)]
pub(crate) struct Judge {
    axes: [Axis; 2],
    distances: Vec<f32>,
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
            distances: Vec::with_capacity(MOST_SAMPLES),
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

/// How far the image along a strand is from what is seen on it outside of the crossing.
#[derive(Clone, Copy, Debug, Default)]
struct Surprise {
    /// Sum of the differences in levels over the samples.
    sum: f32,
    samples: f32,
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
        for (axis, place) in self.axes.iter_mut().zip([a, b]) {
            axis.lay(&curves[place.curve], place.at, reach_px, step_px);
        }
        let [first, second] = &self.axes;
        let sa = surprise(image, first, second, step_px, &mut self.distances);
        let sb = surprise(image, second, first, step_px, &mut self.distances);
        verdict(sa, sb)
    }
}

/// The upper strand is the one that surprises less.
fn verdict(a: Surprise, b: Surprise) -> Verdict {
    if a.samples == 0.0 || b.samples == 0.0 {
        return Verdict {
            second: false,
            confidence: 0.0,
        };
    }
    let (mean_a, mean_b) = (a.sum / a.samples, b.sum / b.samples);
    let margin = (mean_a - mean_b) / (mean_a + mean_b + ROUNDING);
    let certainty = CERTAINTY * margin.abs() * a.samples.min(b.samples).sqrt();
    Verdict {
        second: margin > 0.0,
        confidence: certainty.tanh(),
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
    /// Samples `curve` every `step_px` as far as `reach_px` to both sides of place `at`.
    fn lay(&mut self, curve: &Curve, at: f32, reach_px: f32, step_px: f32) {
        self.samples.clear();
        self.center = 0;
        self.half_px = 0.5 * curve.width_px;
        let step = step_px / curve.spacing_px().max(1e-3);
        let most = ((reach_px / step_px) as i32).min(MOST_SAMPLES as i32 / 2 - 1);
        let last = curve.intervals() as f32;
        for k in -most..=most {
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
fn surprise(
    image: &Image,
    axis: &Axis,
    other: &Axis,
    step_px: f32,
    distances: &mut Vec<f32>,
) -> Surprise {
    let mut all = Surprise::default();
    if axis.samples.is_empty() || other.samples.is_empty() {
        return all;
    }
    let touched_px = other.half_px + beyond_px(other.half_px);
    let around = ((around_px(other.half_px) / step_px) as usize).clamp(2, MOST_AROUND);
    for line in 0..LINES {
        let share = 2.0 * line as f32 / (LINES - 1) as f32 - 1.0;
        let aside_px = SPAN * axis.half_px * share;
        let point = |i: usize| {
            let sample = axis.samples[i];
            vec2::along(sample.at, sample.normal, aside_px)
        };
        distances.clear();
        let mut near = other.center;
        distances.extend((0..axis.samples.len()).map(|i| {
            let (distance, at) = other.distance(point(i), near);
            near = at;
            distance
        }));
        if let Some((from, to)) = touched(distances, axis.center, touched_px) {
            let before = from.saturating_sub(around)..from;
            let after = to..(to + around).min(axis.samples.len());
            let color = |i: usize| color::between(image, point(i));
            all.add(
                color,
                before,
                from..to,
                after,
                color::is_yuv(image.format()),
            );
        }
    }
    all
}

/// The samples around `center` that lie within `touched_px` of the other strand.
fn touched(distances: &[f32], center: usize, touched_px: f32) -> Option<(usize, usize)> {
    let near = (0..distances.len())
        .filter(|&i| distances[i] < touched_px)
        .min_by_key(|i| i.abs_diff(center))?;
    let back = distances[..near].iter().rev();
    let from = near - back.take_while(|d| **d < touched_px).count();
    let ahead = distances[near..].iter();
    let to = near + ahead.take_while(|d| **d < touched_px).count();
    Some((from, to))
}

impl Surprise {
    /// Adds one line, whose samples `inside` are predicted from those before and after.
    fn add(
        &mut self,
        color: impl Fn(usize) -> [f32; 3],
        before: std::ops::Range<usize>,
        inside: std::ops::Range<usize>,
        after: std::ops::Range<usize>,
        yuv: bool,
    ) {
        let known = [before, after].map(|range| median_color(range, &color));
        let (from, to) = match known {
            [Some(from), Some(to)] => (from, to),
            // The strand ends in the crossing.
            [Some(one), None] | [None, Some(one)] => (one, one),
            [None, None] => return,
        };
        let count = inside.len() as f32;
        for (k, i) in inside.enumerate() {
            let t = (k as f32 + 1.0) / (count + 1.0);
            let expected = std::array::from_fn(|c| from[c] + t * (to[c] - from[c]));
            self.sum += difference(color(i), expected, yuv);
            self.samples += 1.0;
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
fn median_color(
    range: std::ops::Range<usize>,
    color: &impl Fn(usize) -> [f32; 3],
) -> Option<[f32; 3]> {
    let count = range.len();
    if count < 2 {
        return None;
    }
    let mut channels = [[0.0; MOST_AROUND]; 3];
    for (k, i) in range.enumerate() {
        for (channel, value) in channels.iter_mut().zip(color(i)) {
            channel[k] = value;
        }
    }
    Some(channels.map(|mut channel| crate::background::median(&mut channel[..count])))
}

/// The position at a place of the curve, by the Catmull-Rom spline through its points.
fn spline(curve: &Curve, place: f32) -> Vec2 {
    let (i, t) = split(curve, place);
    let [p, q, r, s] = [-1, 0, 1, 2].map(|k| point(curve, i + k));
    std::array::from_fn(|c| {
        let bend = 2.0 * p[c] - 5.0 * q[c] + 4.0 * r[c] - s[c];
        let twist = 3.0 * (q[c] - r[c]) + s[c] - p[c];
        0.5 * (2.0 * q[c] + t * (r[c] - p[c] + t * (bend + t * twist)))
    })
}

/// The spline's unit tangent there.
fn tangent(curve: &Curve, place: f32) -> Vec2 {
    let (i, t) = split(curve, place);
    let [p, q, r, s] = [-1, 0, 1, 2].map(|k| point(curve, i + k));
    let d = std::array::from_fn(|c| {
        let bend = 2.0 * p[c] - 5.0 * q[c] + 4.0 * r[c] - s[c];
        let twist = 3.0 * (q[c] - r[c]) + s[c] - p[c];
        r[c] - p[c] + t * (2.0 * bend + 3.0 * t * twist)
    });
    vec2::unit_or(d, vec2::unit_or(vec2::sub(r, q), [1.0, 0.0]))
}

/// The piece of the spline and how far into it.
fn split(curve: &Curve, place: f32) -> (i32, f32) {
    let last = curve.intervals() as i32 - 1;
    let i = place.floor() as i32;
    let i = if curve.closed { i } else { i.clamp(0, last) };
    (i, place - i as f32)
}

/// Point `i`, counted around a closed curve, and run on straight beyond the ends of an open one.
fn point(curve: &Curve, i: i32) -> Vec2 {
    let n = curve.points.len() as i32;
    let at = |i: i32| curve.points[i as usize];
    if curve.closed {
        at(i.rem_euclid(n))
    } else if i < 0 {
        vec2::along(at(0), vec2::sub(at(1), at(0)), i as f32)
    } else if i >= n {
        let inner = at(n - 2);
        vec2::along(at(n - 1), vec2::sub(at(n - 1), inner), (i - n + 1) as f32)
    } else {
        at(i)
    }
}
