//! Decides which of two strands is on top where they cross, from the image.
//!
//! The upper strand's surface continues through the crossing. On a line parallel to its axis, the
//! image (a highlight, the shade toward its edge, its color) is the same before, in and after the
//! crossing. On the lower strand, each such line is cut by the upper strand's two edges, its shadow
//! and its shading.
//!
//! A few lines along each strand are therefore read. The image in the middle of the crossing, where
//! no blur of lens or motion mixes in the table, changes less along the upper strand. If the edges
//! are [sharp](mod@sharpness), so that the strands are clearly visible, the upper strand also keeps its
//! [cross-section](bands). This compares colors, shading and texture at once, and needs no model of
//! a rope or of the light.

mod axis;
mod bands;
mod lines;
mod sharpness;

use lariat_portable::{Arch, Simd, WithSimd};

use super::place::{Place, tangent};
use crate::image::Image;
use crate::scene::Curve;
use crate::statistics::grade;
use crate::vec2;
use axis::Axis;
use lines::Lines;
use sharpness::sharpness;

/// Reach of the lens's blur and of an error of the width beyond the other strand's edge, in pixels.
const BLUR_PX: f32 = 1.5;
/// Reach of the other strand's shadow beyond its edge, in half-widths.
const SHADOW: f32 = 0.5;
/// Length read before and after the crossing, in half-widths of the other strand, and its minimum
/// in pixels.
const AROUND: f32 = 1.6;
const AROUND_LEAST_PX: f32 = 4.0;
/// Minimum sine of the crossing angle, for the length that is read. Flatter crossings are read no
/// farther.
const FLATTEST: f32 = 0.12;
/// Maximum number of samples of an axis: the length above at a step of a twelfth of the width.
const MOST_SAMPLES: usize = 320;
/// Difference in levels that means nothing, because of rounding.
const ROUNDING: f32 = 1.0;
/// Growth of confidence with the margin between the strands. A logistic regression of "right" over
/// the 2,124 crossings of `lariat-bench accuracy --rendered --seed 400000 --seeds 60` gives a slope
/// of 15.8 ± 2.8 for the log-odds, and so at least 10. A hyperbolic tangent with half that slope is
/// the same curve. The lower end holds because ropes without any surface show less than these. The
/// number of samples does not matter, because the errors are not noise.
const CERTAINTY: f32 = 5.0;
/// Weight of the cross-sections relative to the surface, if they are clearly visible.
const BANDS: f32 = 1.1;
/// Range of edge sharpness over which cross-sections become clearly visible.
const SHARP: (f32, f32) = (0.61, 0.7);
/// Range of half-widths over which cross-sections become clearly visible.
const THICK_PX: (f32, f32) = (2.0, 4.0);

/// Memory of the step.
#[derive(Debug, Default)]
pub(crate) struct Judge {
    axes: [Axis; 2],
    lines: Lines,
}

/// The judgement from the image.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Verdict {
    /// True if the second strand is the upper one.
    pub(crate) second: bool,
    /// From 0 (a coin toss) to 1 (certain): 2p − 1, where p is the probability of being right.
    pub(crate) confidence: f32,
}

/// Deviations of the image along a strand from the image of a continuous surface.
#[derive(Clone, Copy, Debug, Default)]
struct Surprise {
    /// Deviation from the line's own mean in the middle of the crossing.
    unsteady: Mean,
    /// Difference from the cross-section outside of the crossing.
    bands: Mean,
}

/// A mean of differences, in levels.
#[derive(Clone, Copy, Debug, Default)]
struct Mean {
    sum: f32,
    count: f32,
}

impl Judge {
    /// Compares the strands at places `a` and `b`, where they cross.
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
        // A step of one pixel misses nothing. For thick ropes, a dozen steps a width tell as much.
        let step_px = ((widths[0] + widths[1]) / 24.0).max(1.0);
        let mut reaches = [[reach_px; 2]; 2];
        if a.curve == b.curve {
            share_loop(&curves[a.curve], [a.at, b.at], &mut reaches);
        }
        let [first, second] = &mut self.axes;
        first.lay(&curves[a.curve], a.at, reaches[0], step_px);
        second.lay(&curves[b.curve], b.at, reaches[1], step_px);
        let of_first = sharpness(simd, image, [first, second]);
        let sharpness = of_first.min(sharpness(simd, image, [second, first]));
        let half_px = 0.5 * widths[0].min(widths[1]);
        // How well the cross-sections are visible, from 0 to 1.
        let clear = grade(sharpness, SHARP.0, SHARP.1) * grade(half_px, THICK_PX.0, THICK_PX.1);
        let how = (step_px, clear > 0.0);
        let a = self.lines.surprise(simd, image, [first, second], how);
        let b = self.lines.surprise(simd, image, [second, first], how);
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

/// Ends the axes of two places of one curve, the first before the second, halfway between them. A
/// small loop must not be followed into the other pass.
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

/// Chooses the strand with the smaller residuals as the upper one. `clear` tells how well the
/// cross-sections are visible.
fn verdict(a: Surprise, b: Surprise, clear: f32) -> Verdict {
    let margin = a.unsteady.above(b.unsteady) + BANDS * clear * a.bands.above(b.bands);
    Verdict {
        second: margin > 0.0,
        confidence: libm::tanhf(CERTAINTY * margin.abs()),
    }
}

impl Mean {
    #[inline(always)]
    fn add(&mut self, sum: f32, count: f32) {
        self.sum += sum;
        self.count += count;
    }

    /// Relative excess over `other`, from −1 to 1; 0 if one of them is unknown.
    fn above(self, other: Mean) -> f32 {
        if self.count == 0.0 || other.count == 0.0 {
            return 0.0;
        }
        let (a, b) = (self.sum / self.count, other.sum / other.count);
        (a - b) / (a + b + ROUNDING)
    }
}

/// Distance beyond the edge of a strand of this half-width within which it disturbs another one.
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
