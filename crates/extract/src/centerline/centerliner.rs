//! Turns a strand of skeleton pixels into a smooth line through the middle of the rope, from tip to
//! tip.
//!
//! - The pixels outside of crossings are spaced evenly and smoothed.
//! - Thinning has bent and shortened the ends. They are cut and extended along their arc to where
//!   the rope's difference from the table falls to half.
//! - Every sample is moved to the middle of its cross-section. This is done twice, the second time
//!   with better normals. The tips are then measured once more at their new place.
//! - Nothing is measured inside of crossings: the line bridges them as the curve of least bending
//!   between the measured parts.

use super::extender::Extender;
use super::line::{Line, Sample};
use super::path;
use super::section::{Measure, Sections};
use super::shading::Shading;
use super::smooth::Smoother;
use super::source::{Source, mean_half};
use crate::graph::strands::Strand;
use crate::image::gray::GrayPlane;
use crate::statistics::quantile_of_positive;

/// Distance from a tip, in half-widths, within which samples are measured again after the tip was
/// extended.
const TIP_HALVES: f32 = 2.0;

/// Distance from a tip, in half-widths, within which no sample is measured again. A section that is
/// 20° oblique reaches this far.
const CUT_HALVES: f32 = 0.35;

/// Distance from a tip, in half-widths, within which samples are measured again even if the first
/// measurement failed.
const RETRACE_HALF_WIDTHS: f32 = 1.6;

/// Minimum length of an unmeasurable stretch before a tip, in half-widths, for it to be held in
/// place. It stays where the skeleton had it, with weight `HELD`.
const HELD_HALVES: f32 = 1.5;
const HELD: f32 = 0.05;

/// Maximum factor between a section's width and the rope's: at first, and once the rope's width is
/// well known.
const COARSE: f32 = 1.6;
const FINE: f32 = 1.25;

/// Maximum excess of a rope's half-width over that of its mask. Most of a rope two pixels wide can
/// be missing from the mask.
const MISSED_PX: f32 = 0.8;

/// Distance between samples, in half-widths, and its limits in pixels. At twice this distance,
/// noise would show in the line.
const STEP_HALVES: f32 = 0.25;
const STEPS_PX: [f32; 2] = [0.75, 4.0];

/// Smoothing reach of measured positions, in half-widths, and its minimum in pixels.
const SMOOTH_HALVES: f32 = 0.35;
const SMOOTH_PX: f32 = 2.5;

/// Memory of the step.
#[derive(Debug, Default)]
pub(crate) struct Centerliner {
    sections: Sections,
    smoother: Smoother,
    extender: Extender,
    spaced: Vec<Sample>,
    widths: Vec<f32>,
}

impl Centerliner {
    /// Makes room for lines of this many samples.
    pub(crate) fn reserve(&mut self, samples: usize) {
        self.spaced.reserve(samples);
        self.widths.reserve(samples);
        self.extender.reserve(samples);
        self.sections.reserve(samples);
    }

    /// Fills `line` with the centerline of `strand`. Returns false if too little of the strand is
    /// left.
    pub(crate) fn build(&mut self, source: &Source, strand: &Strand, line: &mut Line) -> bool {
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
        self.smoother.smooth(line, (half_px).max(2.5) / step_px);
        self.extender
            .extend(source.difference, line, half_px, step_px, 0.0);
        let thin = (half_px + MISSED_PX) / half_px;
        let coarse = Measure {
            half_px,
            step_px,
            tolerance: f32::max(COARSE, thin),
            shading: Shading::FLAT,
        };
        if let Some(width_px) = self.sections.center(line, source.difference, coarse) {
            half_px = 0.5 * width_px;
        }
        let shading = Shading::measure(line, source.difference, Measure { half_px, ..coarse });
        self.extender
            .extend(source.difference, line, half_px, step_px, 0.7 * half_px);
        let fine = Measure {
            half_px,
            step_px,
            tolerance: FINE,
            shading,
        };
        self.sections.measure(line, source.difference, fine);
        let width_px = self.fill_widths(line, 2.0 * half_px);
        let held = self.hold_ends(line, (HELD_HALVES * half_px / step_px) as usize);
        self.smoother.smooth(line, reach(half_px, step_px));
        // The held samples may be measurable the next time.
        weigh_ends(line, held, 1.0);
        half_px = 0.5 * width_px;
        self.extender
            .extend(source.difference, line, half_px, step_px, 0.7 * half_px);
        if line.closed {
            line.space(step_px, &mut self.spaced);
        } else {
            self.measure_tips(source, line, Measure { half_px, ..fine });
            line.cut_to(source.difference);
        }
        line.samples.len() >= 2
    }

    /// Rebuilds a line along a rope of this half-width, from a line that follows its middle
    /// roughly.
    pub(crate) fn retrace(&mut self, line: &mut Line, difference: &GrayPlane, half_px: f32) {
        let step_px = (STEP_HALVES * half_px).clamp(STEPS_PX[0], STEPS_PX[1]);
        if line.samples.len() < 3 || line.length_px() < 3.0 * step_px {
            return;
        }
        line.space(step_px, &mut self.spaced);
        for sample in &mut line.samples {
            (sample.weight, sample.width_px) = (1.0, 2.0 * half_px);
        }
        let coarse = Measure {
            half_px,
            step_px,
            tolerance: COARSE,
            shading: Shading::FLAT,
        };
        self.sections.center(line, difference, coarse);
        let fine = Measure {
            tolerance: FINE,
            shading: Shading::measure(line, difference, coarse),
            ..coarse
        };
        self.sections.measure(line, difference, fine);
        self.fill_widths(line, 2.0 * half_px);
        // Samples on other strands stay where they are.
        for sample in line.samples.iter_mut().filter(|s| s.weight == 0.0) {
            sample.weight = HELD;
        }
        self.smoother.smooth(line, reach(half_px, step_px));
    }

    /// Measures the tips, which were extended in their apparent direction, and extends them again.
    fn measure_tips(&mut self, source: &Source, line: &mut Line, how: Measure) {
        let Measure {
            half_px, step_px, ..
        } = how;
        let n = line.samples.len();
        let within = |halves: f32| (halves * half_px / step_px) as usize + 2;
        // Tries again to measure what was not measured while the tip was off the middle. No strand
        // crosses this close to a tip.
        let again = within(RETRACE_HALF_WIDTHS).min(n / 4);
        weigh_ends(
            line,
            self.extender
                .is_free()
                .map(|free| if free { again } else { 0 }),
            1.0,
        );
        let count = within(TIP_HALVES);
        self.sections
            .measure_ends(line, source.difference, how, count);
        // A slightly oblique section runs into the cut end itself.
        let cut_px = CUT_HALVES * half_px + 1.0;
        let skip = ((cut_px / step_px) as usize + 1).min(count / 2).min(n / 4);
        weigh_ends(line, [skip; 2], 0.0);
        self.fill_widths(line, 2.0 * half_px);
        self.smoother
            .smooth_ends(line, reach(half_px, step_px), count);
        self.extender
            .extend(source.difference, line, half_px, step_px, cut_px);
    }

    /// Holds samples before a free end in place, with a small weight, if more than `most` of them
    /// could not be measured. The line would otherwise run straight past a bend. Returns the number
    /// of held samples at each end.
    fn hold_ends(&self, line: &mut Line, most: usize) -> [usize; 2] {
        if line.closed {
            return [0; 2];
        }
        let unmeasured = |s: &&Sample| s.weight == 0.0;
        let counts = [
            line.samples.iter().take_while(unmeasured).count(),
            line.samples.iter().rev().take_while(unmeasured).count(),
        ];
        let held = [0, 1].map(|end| {
            let held = counts[end] > most && self.extender.is_free()[end];
            if held { counts[end] } else { 0 }
        });
        weigh_ends(line, held, HELD);
        held
    }

    /// Gives samples without a measured width the last measured one, so that nothing depends on the
    /// old value. Returns the median of the measured widths.
    fn fill_widths(&mut self, line: &mut Line, otherwise: f32) -> f32 {
        let median_px = self.median_width(line).unwrap_or(otherwise);
        let mut last = median_px;
        for sample in &mut line.samples {
            if sample.weight > 0.0 {
                last = sample.width_px;
            } else {
                sample.width_px = last;
            }
        }
        median_px
    }

    fn median_width(&mut self, line: &Line) -> Option<f32> {
        self.widths.clear();
        let seen = line.samples.iter().filter(|s| s.weight >= 1.0);
        self.widths.extend(seen.map(|s| s.width_px));
        (!self.widths.is_empty()).then(|| quantile_of_positive(&mut self.widths, 0.5))
    }
}

/// Smoothing reach of measured positions, in samples. It is a fraction of the rope's width.
fn reach(half_px: f32, step_px: f32) -> f32 {
    (SMOOTH_HALVES * half_px).max(SMOOTH_PX) / step_px
}

/// Sets the weight of `counts` samples at the two ends.
fn weigh_ends(line: &mut Line, counts: [usize; 2], weight: f32) {
    let n = line.samples.len();
    for sample in &mut line.samples[..counts[0]] {
        sample.weight = weight;
    }
    for sample in &mut line.samples[n - counts[1]..] {
        sample.weight = weight;
    }
}
