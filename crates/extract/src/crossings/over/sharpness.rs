//! Sharpness of a strand's edges. Blurred by lens or motion, a strand shows little of its surface.

use lariat_portable::Simd;

use super::axis::Axis;
use super::lines::levels;
use super::{ROUNDING, beyond_px};
use crate::image::ray::LANES;
use crate::image::{Image, color};

/// Distance to either side of an edge where the image is read, in half-widths, and its minimum in
/// pixels: beyond a lens's blur.
const ASIDE: f32 = 0.2;
const ASIDE_PX: f32 = 1.25;
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

/// Sharpness of the first strand's edges outside of the second strand: their step as a share of the
/// step from the strand's middle to the outside. It is 0 if too little of them is visible.
#[inline(always)]
pub(super) fn sharpness<S: Simd>(simd: S, image: &Image, [axis, other]: [&Axis; 2]) -> f32 {
    let off_px = (ASIDE * axis.half_px).max(ASIDE_PX);
    let (inner_px, outer_px) = (axis.half_px - off_px, axis.half_px + off_px);
    let aside_px = [-inner_px, -outer_px, inner_px, outer_px, 0.0];
    let beside_px = other.half_px + beyond_px(other.half_px);
    let [mut beside, mut whole] = <[Steps; 2]>::default();
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
                let is_beside = is(near.min(far) > beside_px * beside_px);
                let step = |from: usize, c: usize| colors[outer][c][l] - colors[from][c][l];
                let at_edge = [step(inner, 0), step(inner, 1), step(inner, 2)];
                beside.add(edge, at_edge, is_beside);
                whole.add(edge, [step(4, 0), step(4, 1), step(4, 2)], is_beside);
            }
        }
    }
    let yuv = color::is_yuv(image.format());
    match (beside.mean(yuv), whole.mean(yuv)) {
        (Some(beside), Some(whole)) => beside / (whole + ROUNDING),
        _ => 0.0,
    }
}
