//! Tells whether a strand's own edges are visible where it crosses another one.
//!
//! The upper strand's rims stand out from what is under them, all the way through the crossing. At
//! the lower strand's rims there is only the upper one's surface. Its dashes and specks differ to
//! one side as often as to the other, so signed steps across an edge are added up. Edges blurred by
//! lens or motion tell little.

use lariat_portable::Simd;

use super::axis::Axis;
use super::lines::levels;
use super::{ROUNDING, beyond_px};
use crate::image::ray::LANES;
use crate::image::{Image, color};
use crate::statistics::grade;

/// Distance to either side of an edge where the image is read, in half-widths, and its minimum in
/// pixels: beyond a lens's blur.
const ASIDE: f32 = 0.2;
const ASIDE_PX: f32 = 1.25;
/// Maximum distance from the other strand's axis, in its half-widths: well within its own edges.
const CORE: f32 = 0.85;
/// Range of an edge's sharpness, as its share of the step from the strand's middle to the outside.
/// Below the range, the edges do not count; above it, they count fully.
const SHARP: (f32, f32) = (0.4, 0.7);
/// Minimum number of places on an edge.
const FEWEST: f32 = 2.0;

/// Mean steps of each channel from inside an edge outward, for both edges of a strand.
#[derive(Default)]
struct Steps {
    sums: [[f32; 3]; 2],
    counts: [f32; 2],
}

impl Steps {
    #[inline(always)]
    fn add(&mut self, edge: usize, step: [f32; 3], counts: f32) {
        self.counts[edge] += counts;
        for (sum, step) in self.sums[edge].iter_mut().zip(step) {
            *sum += counts * step;
        }
    }

    /// The mean step of those edges that are visible.
    fn mean(&self, yuv: bool) -> Option<f32> {
        let (mut sum, mut seen) = (0.0, 0.0);
        for (sums, count) in self.sums.iter().zip(self.counts) {
            if count >= FEWEST {
                sum += levels(sums.map(|step| (step / count).abs()), yuv);
                seen += 1.0;
            }
        }
        (seen > 0.0).then(|| sum / seen)
    }
}

/// Visibility of a strand's edges.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rims {
    /// Contrast of the edges within the other strand, relative to their contrast outside of it.
    pub(super) share: f32,
    /// Sharpness of the edges outside of it, from 0 to 1.
    pub(super) sharpness: f32,
}

/// The edges of the first strand around the second, or `None` if too little of them is visible.
#[inline(always)]
pub(super) fn seen<S: Simd>(simd: S, image: &Image, [axis, other]: [&Axis; 2]) -> Option<Rims> {
    let off_px = (ASIDE * axis.half_px).max(ASIDE_PX);
    let (inner_px, outer_px) = (axis.half_px - off_px, axis.half_px + off_px);
    let aside_px = [-inner_px, -outer_px, inner_px, outer_px, 0.0];
    let within_px = CORE * other.half_px;
    let beside_px = other.half_px + beyond_px(other.half_px);
    let [mut within, mut beside, mut whole] = <[Steps; 3]>::default();
    for (b, block) in axis.blocks.iter().enumerate() {
        let squares = other.squares(simd, block, &aside_px);
        let used = (axis.count - b * LANES).min(LANES);
        let mut colors = [[[0.0; LANES]; 3]; 5];
        for (colors, aside_px) in colors.iter_mut().zip(aside_px) {
            *colors = color::between_each(image, &block.moved(aside_px));
        }
        for edge in 0..2 {
            let [inner, outer] = [2 * edge, 2 * edge + 1];
            for l in 0..used {
                let [near, far] = [squares[inner][l], squares[outer][l]];
                let is = |is: bool| if is { 1.0 } else { 0.0 };
                let is_within = is(near.max(far) < within_px * within_px);
                let is_beside = is(near.min(far) > beside_px * beside_px);
                let step = |from: usize, c: usize| colors[outer][c][l] - colors[from][c][l];
                let at_edge = [step(inner, 0), step(inner, 1), step(inner, 2)];
                within.add(edge, at_edge, is_within);
                beside.add(edge, at_edge, is_beside);
                whole.add(edge, [step(4, 0), step(4, 1), step(4, 2)], is_beside);
            }
        }
    }
    let yuv = color::is_yuv(image.format());
    let [within, beside, whole] = [within.mean(yuv)?, beside.mean(yuv)?, whole.mean(yuv)?];
    Some(Rims {
        share: within / (beside + ROUNDING),
        sharpness: grade(beside / (whole + ROUNDING), SHARP.0, SHARP.1),
    })
}
