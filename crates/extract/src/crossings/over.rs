//! Which of two strands lies on top where they cross, seen in the image.
//!
//! Along the upper strand its surface goes on: what is seen on a line that runs parallel to its axis
//! (a highlight, the shade toward its edge, its color) is the same before the crossing, in it, and
//! after it. Along the lower strand each such line is cut by the upper one's two edges, its shadow
//! and its own shading. So a few lines along each strand are looked at twice: how far the image
//! through the crossing is from what is predicted of it from just outside, and how much it changes
//! on the way through the middle of the crossing, where no blur of lens or motion mixes in the
//! table. The upper strand is the one that surprises less, and whose own [edges](rims) and [cross-sections](bands)
//! are seen. That compares colors, shading, texture and edges at once, and needs no model of a rope or of the light.

mod axis;
mod bands;
mod lines;
mod rims;

use lariat_portable::{Arch, Simd, WithSimd};

use super::place::{Place, tangent};
use crate::image::Image;
use crate::scene::Curve;
use crate::statistics::grade;
use crate::vec2;
use axis::Axis;
use lines::Lines;
use rims::Rims;

/// Beyond the other strand's edge the lens and an error of the width reach this far, in pixels…
const BLUR_PX: f32 = 1.5;
/// …and a shadow of it, in half-widths.
const SHADOW: f32 = 0.5;
/// How much is looked at before and after the crossing, in half-widths of the other strand, and at
/// least in pixels.
const AROUND: f32 = 1.6;
const AROUND_LEAST_PX: f32 = 4.0;
/// Strands that cross at a flatter angle than this sine are looked at no farther than it tells.
const FLATTEST: f32 = 0.12;
/// The most samples of an axis: what the above comes to when the step is a twelfth of the width.
const MOST_SAMPLES: usize = 320;
/// Levels of difference that mean nothing: rounding.
const ROUNDING: f32 = 1.0;
/// How fast certainty grows with the margin between the strands. The logistic regression of "right"
/// over 2900 drawn crossings (every contrast from none on; dashed, twisted, braided, speckled, blurred by lens and by
/// motion, shining, flat) gives a slope of 10 for the log-odds; half of it makes the hyperbolic
/// tangent of the same curve. The number of samples does not enter: what misleads is not noise.
const CERTAINTY: f32 = 5.0;
/// How much the edges count beside the surface: with more, crossings of dashed ropes are told better, and those of speckled ones worse.
const RIMS: f32 = 0.4;
/// A share by which edges stand out that means nothing.
const LEAST_SHARE: f32 = 0.05;
/// How much the cross-sections count beside the surface, where they are seen well; and by how much less the surface does
/// then as it is predicted: dashes begin and end anywhere.
const BANDS: f32 = 1.1;
const PREDICTED: f32 = 0.6;
/// Cross-sections are seen well where edges are so sharp, and strands so thick, in half-widths.
const SHARP: (f32, f32) = (0.7, 1.0);
const THICK_PX: (f32, f32) = (2.0, 4.0);

/// Memory of the step.
#[derive(Debug, Default)]
pub(crate) struct Judge {
    axes: [Axis; 2],
    lines: Lines,
}

/// What the image says.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Verdict {
    /// Whether the second strand is the upper one.
    pub(crate) second: bool,
    /// From 0 (a toss of a coin) to 1 (certain): 2p − 1 for a probability p of being right.
    pub(crate) confidence: f32,
}

/// How little the image along a strand is that of a surface that goes on.
#[derive(Clone, Copy, Debug, Default)]
struct Surprise {
    /// Off what is seen outside of the crossing.
    off: Mean,
    /// Off the line's own mean in the middle of the crossing.
    unsteady: Mean,
    /// Off what is seen across the strand outside of the crossing.
    bands: Mean,
    /// Its own edges there.
    rims: Option<Rims>,
}

/// A mean of differences, in levels.
#[derive(Clone, Copy, Debug, Default)]
struct Mean {
    sum: f32,
    count: f32,
}

impl Judge {
    /// Compares the strands around places `a` and `b`, which lie over each other.
    pub(crate) fn judge(&mut self, image: &Image, curves: &[Curve], places: [Place; 2]) -> Verdict {
        Arch::new().dispatch(Judging {
            judge: self,
            image,
            curves,
            places,
        })
    }

    #[inline(always)]
    fn judge_in<S: Simd>(
        &mut self,
        simd: S,
        image: &Image,
        curves: &[Curve],
        [a, b]: [Place; 2],
    ) -> Verdict {
        let widths = [curves[a.curve].width_px, curves[b.curve].width_px];
        let (ta, tb) = (
            tangent(&curves[a.curve], a.at),
            tangent(&curves[b.curve], b.at),
        );
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
        let [first, second] = &mut self.axes;
        first.lay(&curves[a.curve], a.at, reaches[0], step_px);
        second.lay(&curves[b.curve], b.at, reaches[1], step_px);
        let rims = [
            rims::seen(simd, image, [first, second]),
            rims::seen(simd, image, [second, first]),
        ];
        let clear = clear(rims, 0.5 * widths[0].min(widths[1]));
        let how = (step_px, clear > 0.0);
        let mut a = self.lines.surprise(simd, image, [first, second], how);
        let mut b = self.lines.surprise(simd, image, [second, first], how);
        [a.rims, b.rims] = rims;
        verdict(a, b, clear)
    }
}

/// A judgement, for the widest registers.
struct Judging<'a> {
    judge: &'a mut Judge,
    image: &'a Image<'a>,
    curves: &'a [Curve],
    places: [Place; 2],
}

impl WithSimd for Judging<'_> {
    type Output = Verdict;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Verdict {
        self.judge
            .judge_in(simd, self.image, self.curves, self.places)
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

/// From 0 to 1, how well strands of this half-width and with these edges show what is across them.
fn clear(rims: [Option<Rims>; 2], half_px: f32) -> f32 {
    let sharpness = |rims: Option<Rims>| rims.map_or(0.0, |rims| rims.sharpness);
    let sharpness = sharpness(rims[0]).min(sharpness(rims[1]));
    grade(sharpness, SHARP.0, SHARP.1) * grade(half_px, THICK_PX.0, THICK_PX.1)
}

/// The upper strand is the one that surprises less; `clear` is how well the cross-sections are seen.
fn verdict(a: Surprise, b: Surprise, clear: f32) -> Verdict {
    let margin = (1.0 - PREDICTED * clear) * a.off.above(b.off)
        + a.unsteady.above(b.unsteady)
        + BANDS * clear * a.bands.above(b.bands)
        + above(a.rims, b.rims);
    Verdict {
        second: margin > 0.0,
        confidence: libm::tanhf(CERTAINTY * margin.abs()),
    }
}

/// How much less the edges of the first strand stand out than those of the second, weighed; 0 when one of them is not known,
/// or not sharp.
fn above(a: Option<Rims>, b: Option<Rims>) -> f32 {
    let (Some(a), Some(b)) = (a, b) else {
        return 0.0;
    };
    let apart = (b.share - a.share) / (a.share + b.share + LEAST_SHARE);
    RIMS * a.sharpness.min(b.sharpness) * apart
}

impl Mean {
    #[inline(always)]
    fn add(&mut self, sum: f32, count: f32) {
        self.sum += sum;
        self.count += count;
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_one_curve_each_strand_ends_halfway_to_the_other() {
        let mut curve = Curve::default();
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
