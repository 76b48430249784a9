//! Puts centers in order: finds the line through those along a strand.
//!
//! The paper (F. Chen, arXiv 2312.16502) leaves this out. Here, the thinned nerve of the centers
//! has shown the rope's path through its crossings ([`crate::clustering`]), and each center is
//! projected onto that path. The line fits the centers outside crossings and bends least
//! ([`crate::centerline::smooth`]). Each center is weighted by the pixels that it stands for.
//!
//! This gives the order of the centers. They may be in single file, or, on a rope wider than the
//! distance between them, in a zigzag or two abreast. Nothing in the image is measured again except
//! the tips and, for the widths, the sides of the mask.
//!
//! Known limitations:
//! - A hole within a single cell is not seen: strands that enclose one are a single strand there.
//! - Strands alongside each other share centers. Each is laid half its width inside the mask's edge
//!   on its side, if the overlap is recognized as one.
//! - Ropes that cross are one piece of the mask and share its K centers, whatever their colors.
//! - A bend tighter than the distance between centers is cut short.
//! - Centers that avoid the mask's middle pull the line with them. So do centers that leave a part
//!   of the rope without any.

use super::Center;
use crate::bitmap::bits::BitPlane;
use crate::centerline::extender::Extender;
use crate::centerline::line::{Line, OVERLAP, Sample};
use crate::centerline::path;
use crate::centerline::smooth::Smoother;
use crate::centerline::source::{Source, mean_half};
use crate::graph::strands::Strand;
use crate::statistics::quantile_of_positive;
use crate::vec2::{self, Vec2};

/// Distance between samples, in half-widths, and its limits in pixels.
const STEP_HALVES: f32 = 0.25;
const STEPS_PX: [f32; 2] = [0.75, 4.0];
/// Maximum distance of a strand's own centers from its path, in half-widths: slightly more than
/// that of the strand's sides.
const OWN_HALVES: f32 = 1.25;
/// Length over which the centers are smoothed, in widths, with a minimum in pixels. Centers two
/// abreast alternate within this length.
const SMOOTH_WIDTHS: f32 = 0.5;
const SMOOTH_PX: f32 = 2.5;
/// Lengths of the path's ends that are laid again, in half-widths: where thinning has bent them,
/// then where they are extended straight.
const CUTS_HALVES: [f32; 2] = [2.5, 1.0];
const LAST_CUT_HALVES: f32 = 0.7;
/// Weight of a place on an open stretch without a center: negligible, but not 0 as in a crossing.
const NO_CENTER: f32 = 1e-4;
/// Maximum width of a section, as a multiple of the strand's. A wider section is not of this strand
/// alone.
const WIDEST: f32 = 1.6;
/// Distance from the middle of an overlap within which its sides are sought, in half-widths.
const MOST_OVERLAP: f32 = 2.5;
/// Step of the search for the sides of the mask, in pixels.
const SIDE_STEP_PX: f32 = 0.5;

/// Memory of the step.
#[derive(Debug, Default)]
pub(crate) struct Orderer {
    extender: Extender,
    smoother: Smoother,
    spaced: Vec<Sample>,
    /// For each sample, the sums of x, y and weight of the centers there.
    sums: Vec<[f32; 3]>,
    /// The widths as a line of their own.
    widths: Line,
    known: Vec<f32>,
}

impl Orderer {
    /// Reserves room for lines of this many samples.
    pub(crate) fn reserve(&mut self, samples: usize) {
        self.extender.reserve(samples);
        self.spaced.reserve(samples);
        self.sums.reserve(samples);
        self.widths.samples.reserve(samples);
        self.known.reserve(samples);
    }

    /// Fills `line` with the centers along `strand`. Returns false if too little of the line is
    /// left.
    pub(crate) fn build(
        &mut self,
        source: &Source,
        strand: &Strand,
        (centers, mask): (&[Center], &BitPlane),
        line: &mut Line,
    ) -> bool {
        let legs = &source.legs[strand.from as usize..strand.to as usize];
        let mut half_px = mean_half(source, legs);
        let step_px = (STEP_HALVES * half_px).clamp(STEPS_PX[0], STEPS_PX[1]);
        let step_px = step_px.max(source.least_step_px);
        path::lay(source, legs, strand.closed, half_px, line);
        self.extender.begin(source, legs);
        if line.samples.len() < 3 || line.length_px() < step_px {
            return false;
        }
        line.space(step_px, &mut self.spaced);
        self.smoother.smooth(line, reach_px(half_px) / step_px);
        set_apart(line, mask, half_px);
        let difference = source.difference;
        for cut in CUTS_HALVES {
            (self.extender).extend(difference, line, half_px, step_px, cut * half_px);
            self.take_centers(line, centers, half_px, step_px);
            self.smoother.smooth(line, reach_px(half_px) / step_px);
        }
        half_px = 0.5 * self.measure_widths(line, mask, half_px);
        let cut_px = LAST_CUT_HALVES * half_px;
        (self.extender).extend(difference, line, half_px, step_px, cut_px);
        if line.closed {
            line.space(step_px, &mut self.spaced);
        } else {
            line.cut_to(difference);
        }
        let width_px = self.measure_widths(line, mask, half_px);
        self.smooth_widths(line, width_px, reach_px(half_px) / step_px);
        line.samples.len() >= 2
    }

    /// Gives the samples of `line`, `step_px` apart, the positions and weights of the centers along
    /// it.
    fn take_centers(&mut self, line: &mut Line, centers: &[Center], half_px: f32, step_px: f32) {
        self.sums.clear();
        self.sums.resize(line.samples.len(), [0.0; 3]);
        for center in centers {
            let place = nearest(&line.samples, center.at, step_px, OWN_HALVES * half_px);
            if let Some(place) = place {
                let ([x, y], weight) = (center.at, center.pixels as f32);
                let sum = &mut self.sums[place];
                *sum = [sum[0] + weight * x, sum[1] + weight * y, sum[2] + weight];
            }
        }
        // The weight is 1 for the number of pixels between two samples.
        let between = 2.0 * half_px * step_px;
        for (sample, &[x, y, weight]) in line.samples.iter_mut().zip(&self.sums) {
            // In a crossing, a center belongs to both strands. In an overlap, it belongs to neither
            // alone.
            if sample.weight > 0.0 && sample.side == 0.0 {
                sample.weight = (weight / between).max(NO_CENTER);
                if weight > 0.0 {
                    sample.at = [x / weight, y / weight];
                }
            }
        }
    }

    /// Sets the width of each sample of `line` to that of the mask across it, with weight 1 where
    /// only the strand is there. Returns the median of those widths.
    fn measure_widths(&mut self, line: &mut Line, mask: &BitPlane, half_px: f32) -> f32 {
        let widest_px = WIDEST * half_px;
        self.known.clear();
        for i in 0..line.samples.len() {
            let across = vec2::unit_or(vec2::normal(line.slope(i, 2)), [1.0, 0.0]);
            let at = line.samples[i].at;
            let sides =
                [across, vec2::scale(across, -1.0)].map(|way| side_px(mask, at, way, widest_px));
            let width_px = sides[0] + sides[1];
            let sample = &mut line.samples[i];
            sample.width_px = width_px;
            sample.weight = f32::from(sides.iter().all(|&px| px < widest_px) && width_px > 0.0);
            if sample.weight > 0.0 {
                self.known.push(width_px);
            }
        }
        if self.known.is_empty() {
            return 2.0 * half_px;
        }
        quantile_of_positive(&mut self.known, 0.5)
    }

    /// Smooths only the widths. An unknown width becomes the median at the ends, and is
    /// interpolated elsewhere.
    fn smooth_widths(&mut self, line: &mut Line, width_px: f32, reach: f32) {
        self.widths.closed = line.closed;
        self.widths.samples.clear();
        (self.widths.samples).extend(line.samples.iter().map(|sample| Sample {
            at: [0.0; 2],
            width_px: if sample.weight > 0.0 {
                sample.width_px
            } else {
                width_px
            },
            // An unknown width is close to the median.
            weight: sample.weight.max(0.01),
            side: 0.0,
        }));
        self.smoother.smooth(&mut self.widths, reach);
        for (sample, width) in line.samples.iter_mut().zip(&self.widths.samples) {
            sample.width_px = width.width_px.max(0.5);
            sample.weight = 1.0;
        }
    }
}

/// Classifies the samples of a path: in a crossing (weight 0), in an overlap (with a side), or in
/// the open. Moves those in an overlap to half a strand's width inside its edge on their side.
fn set_apart(line: &mut Line, mask: &BitPlane, half_px: f32) {
    for i in 0..line.samples.len() {
        let across = vec2::unit_or(vec2::normal(line.slope(i, 2)), [1.0, 0.0]);
        let sample = &mut line.samples[i];
        if sample.weight >= 1.0 || sample.weight == 0.0 {
            sample.side = 0.0;
            continue;
        }
        let sides = [1.0, -1.0].map(|way| {
            side_px(
                mask,
                sample.at,
                vec2::scale(across, way),
                MOST_OVERLAP * half_px,
            ) - half_px
        });
        let share = 0.5 * (sample.side + 1.0);
        let aside_px = share * sides[0].max(0.0) - (1.0 - share) * sides[1].max(0.0);
        sample.at = vec2::along(sample.at, across, aside_px);
        sample.weight = OVERLAP;
        // A sample that changes sides is still in an overlap.
        sample.side = sample.side.abs().max(f32::MIN_POSITIVE);
    }
}

fn reach_px(half_px: f32) -> f32 {
    (SMOOTH_WIDTHS * 2.0 * half_px).max(SMOOTH_PX)
}

/// Index of the sample nearest to a place, if it is within `most_px`. Samples are about `step_px`
/// apart.
fn nearest(samples: &[Sample], at: Vec2, step_px: f32, most_px: f32) -> Option<usize> {
    let (mut best, mut least_px, mut i) = (None, most_px, 0);
    while i < samples.len() {
        let apart_px = vec2::distance(samples[i].at, at);
        if apart_px < least_px {
            (best, least_px) = (Some(i), apart_px);
        }
        // One step along the line comes nearer by at most its length. Steps vary a little.
        i += ((apart_px - least_px) / (1.5 * step_px)).max(1.0) as usize;
    }
    best
}

/// Distance from a place in the mask to the mask's end in direction `way`, between pixels; at most
/// `most_px`.
fn side_px(mask: &BitPlane, at: Vec2, way: Vec2, most_px: f32) -> f32 {
    let (mut far, mut before) = (0.0, level(mask, at));
    if before < 0.5 {
        return 0.0;
    }
    while far < most_px {
        let value = level(mask, vec2::along(at, way, far + SIDE_STEP_PX));
        if value < 0.5 {
            return far + SIDE_STEP_PX * (before - 0.5) / (before - value);
        }
        (far, before) = (far + SIDE_STEP_PX, value);
    }
    most_px
}

/// The mask between pixels, bilinear, from 0 to 1. Past the edge, the edge's pixels continue.
fn level(mask: &BitPlane, [x, y]: Vec2) -> f32 {
    let (right, bottom) = (mask.width() as f32 - 1.0, mask.height() as f32 - 1.0);
    let (x, y) = (x.clamp(0.0, right), y.clamp(0.0, bottom));
    let (fx, fy) = (x.fract(), y.fract());
    let (x, y) = (x as i32, y as i32);
    let (x1, y1) = ((x + 1).min(right as i32), (y + 1).min(bottom as i32));
    let value = |x, y| f32::from(u8::from(mask.get(x, y)));
    let above = value(x, y) + fx * (value(x1, y) - value(x, y));
    let below = value(x, y1) + fx * (value(x1, y1) - value(x, y1));
    above + fy * (below - above)
}
