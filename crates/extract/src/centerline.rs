//! From a strand of skeleton pixels to a smooth line through the middle of the rope, tip to tip.
//!
//! The pixels outside of crossings are spaced evenly and smoothed; the ends, which thinning has bent
//! and shortened, are cut and run on straight to where the rope's difference from the table falls
//! to half; then every sample is moved to the middle of its cross-section, twice, the second time
//! with the better normals, and the tips once more where they then lie. Inside of crossings nothing is measured: the line bridges them as the
//! curve of least bending between the parts that are.

use crate::abut::Body;
use crate::graph::Graph;
use crate::line::{Line, Sample};
use crate::onward;
use crate::path;
use crate::plane::Plane;
use crate::section::{Measure, Sections};
use crate::shading::Shading;
use crate::skeleton::Skeleton;
use crate::smooth::Smoother;
use crate::strands::{Leg, Strand};
use crate::zones::{Zones, quantile_of_positive};

/// Half-widths from a tip that are measured once more when it has been run on.
const TIP_HALVES: f32 = 2.0;

/// Half-widths from a tip that are not: as far as a section reaches that is 20° aslant.
const CUT_HALVES: f32 = 0.35;

/// Half-widths from a tip that are measured even if they could not be before.
const ANEW_HALVES: f32 = 1.6;

/// Longer stretches before a tip, in half-widths, that cannot be measured are held where the skeleton had them, with
/// this weight.
const HELD_HALVES: f32 = 1.5;
const HELD: f32 = 0.05;

/// How much a section's width may differ from the rope's, as a factor: at first, and when that is known well.
const COARSE: f32 = 1.6;
const FINE: f32 = 1.25;

/// Distance between samples, in half-widths, and its limits in pixels: at twice the distance, noise shows.
const STEP_HALVES: f32 = 0.25;
const STEPS_PX: [f32; 2] = [0.75, 4.0];

/// What was measured is smoothed over so many half-widths, and at least so many pixels.
const SMOOTH_HALVES: f32 = 0.35;
const SMOOTH_PX: f32 = 2.5;

/// Memory of the step.
#[derive(Debug, Default)]
pub(crate) struct Centerliner {
    sections: Sections,
    smoother: Smoother,
    spaced: Vec<Sample>,
    widths: Vec<f32>,
    /// What is laid beyond the first end.
    tip: Vec<Sample>,
    /// The strands that the line's ends lie against.
    bodies: [Option<Body>; 2],
}

/// What a strand is made of.
pub(crate) struct Source<'a> {
    pub(crate) difference: &'a Plane,
    pub(crate) skeleton: &'a Skeleton,
    pub(crate) graph: &'a Graph,
    pub(crate) zones: &'a Zones,
    pub(crate) legs: &'a [Leg],
    /// Samples along a line lie at least so far apart.
    pub(crate) least_step_px: f32,
}

impl Centerliner {
    /// Makes room for lines of so many samples.
    pub(crate) fn reserve(&mut self, samples: usize) {
        self.spaced.reserve(samples);
        self.tip.reserve(samples);
        self.sections.reserve(samples);
    }

    /// Fills `line` with the centerline of `strand`; false when too little of it is left.
    pub(crate) fn build(&mut self, source: &Source, strand: &Strand, line: &mut Line) -> bool {
        let legs = &source.legs[strand.from as usize..strand.to as usize];
        let mut half_px = mean_half(source, legs);
        let step_px = (STEP_HALVES * half_px).clamp(STEPS_PX[0], STEPS_PX[1]);
        let step_px = step_px.max(source.least_step_px);
        path::lay(source, legs, strand.closed, half_px, line);
        let body = |leg: Option<&Leg>, end| Body::at(leg?, end, source.graph, source.zones);
        self.bodies = [body(legs.first(), 0), body(legs.last(), 1)];
        if line.samples.len() < 3 || line.length_px() < step_px {
            return false;
        }
        self.space(line, step_px);
        self.smoother.smooth(line, (half_px).max(2.5) / step_px);
        self.extend(source, line, half_px, step_px, 0.0);
        let coarse = Measure {
            half_px,
            step_px,
            tolerance: COARSE,
            shading: Shading::FLAT,
        };
        if let Some(width_px) = self.sections.center(line, source.difference, coarse) {
            half_px = 0.5 * width_px;
        }
        let shading = Shading::measure(line, source.difference, Measure { half_px, ..coarse });
        self.extend(source, line, half_px, step_px, 0.7 * half_px);
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
        // They may be measured the next time.
        weigh_ends(line, held, 1.0);
        half_px = 0.5 * width_px;
        self.extend(source, line, half_px, step_px, 0.7 * half_px);
        if line.closed {
            self.space(line, step_px);
        } else {
            self.measure_tips(source, line, Measure { half_px, ..fine });
            line.cut_to(source.difference);
        }
        line.samples.len() >= 2
    }

    /// Measures the tips too, which were run on along the way they seemed to go, and lays them anew.
    fn measure_tips(&mut self, source: &Source, line: &mut Line, how: Measure) {
        let Measure {
            half_px, step_px, ..
        } = how;
        let n = line.samples.len();
        let within = |halves: f32| (halves * half_px / step_px) as usize + 2;
        // What was not measured while the tip lay aside is asked once more; no strand crosses so near to a tip.
        let anew = within(ANEW_HALVES).min(n / 4);
        weigh_ends(
            line,
            self.bodies.map(|b| if b.is_none() { anew } else { 0 }),
            1.0,
        );
        let count = within(TIP_HALVES);
        self.sections
            .measure_ends(line, source.difference, how, count);
        // A section a little aslant runs into the cut itself.
        let cut_px = CUT_HALVES * half_px + 1.0;
        let skip = ((cut_px / step_px) as usize + 1).min(count / 2).min(n / 4);
        weigh_ends(line, [skip; 2], 0.0);
        self.fill_widths(line, 2.0 * half_px);
        self.smoother
            .smooth_ends(line, reach(half_px, step_px), count);
        self.extend(source, line, half_px, step_px, cut_px);
    }

    /// Spaces the line's samples evenly, about `step_px` apart.
    fn space(&mut self, line: &mut Line, step_px: f32) {
        let steps = (line.length_px() / step_px).ceil().max(2.0) as usize;
        let count = if line.closed { steps } else { steps + 1 };
        line.resample(count, &mut self.spaced);
        std::mem::swap(&mut line.samples, &mut self.spaced);
    }

    /// Cuts `cut_px` from each visible end and runs on to the tip.
    fn extend(
        &mut self,
        source: &Source,
        line: &mut Line,
        half_px: f32,
        step_px: f32,
        cut_px: f32,
    ) {
        if !line.closed {
            for end in [1, 0] {
                self.extend_end(source, line, end, [half_px, step_px, cut_px]);
            }
        }
    }

    /// Works on the first (0) or the last (1) end of the line.
    fn extend_end(
        &mut self,
        source: &Source,
        line: &mut Line,
        end: usize,
        [half_px, step_px, cut_px]: [f32; 3],
    ) {
        let n = line.samples.len();
        let cut = ((cut_px / step_px) as usize).min(n / 4);
        let last = n - cut - 1;
        // Counted from the other end.
        let sample = |i: usize| &line.samples[if end == 1 { i } else { n - 1 - i }];
        let back = ((1.5 * half_px).max(4.0) / step_px) as usize;
        let back = back.clamp(1, (last / 3).max(1)).min(last);
        let places = [last, last - back, last.saturating_sub(2 * back)].map(|i| sample(i).at);
        let path = onward::arc(places, last >= 2 * back);
        // The rope's own contrast: the median along the piece that the direction comes from.
        self.widths.clear();
        let piece = (last - back..=last).map(|i| source.difference.sample(sample(i).at));
        self.widths.extend(piece);
        let level = 0.5 * quantile_of_positive(&mut self.widths, 0.5).max(2.0);
        let limit_px = cut_px + 4.0 * half_px + 4.0;
        let (far, border) = match self.bodies[end] {
            Some(body) => {
                let rope = (half_px, level, limit_px);
                let far = body.tip(source.difference, &path, rope, &mut self.widths);
                (far, false)
            }
            None => onward::tip(source.difference, &path, level, limit_px),
        };
        line.border[end] = border;
        let count = (far / step_px).ceil() as usize;
        let width_px = sample(last).width_px;
        let share = far / count.max(1) as f32;
        let beyond = (1..=count).map(|k| Sample {
            at: path(share * k as f32),
            weight: 1.0,
            width_px,
            side: 0.0,
        });
        if end == 1 {
            line.samples.truncate(n - cut);
            line.samples.extend(beyond);
        } else {
            self.tip.clear();
            self.tip.extend(beyond);
            line.samples.splice(..cut, self.tip.drain(..).rev());
        }
    }

    /// Where more than `most` samples before a free end could not be measured, holds them where they are: a little, lest
    /// the line run out straight past a bend. Returns how many at either end.
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
            let held = counts[end] > most && self.bodies[end].is_none();
            if held { counts[end] } else { 0 }
        });
        weigh_ends(line, held, HELD);
        held
    }

    /// Gives samples without a measured width the last one that was, so that nothing depends on
    /// what stood there before. Returns the median of the measured ones.
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

/// Samples over which what was measured is smoothed: a part of the rope's width.
fn reach(half_px: f32, step_px: f32) -> f32 {
    (SMOOTH_HALVES * half_px).max(SMOOTH_PX) / step_px
}

/// Gives so many samples at either end this weight.
fn weigh_ends(line: &mut Line, counts: [usize; 2], weight: f32) {
    let n = line.samples.len();
    for sample in &mut line.samples[..counts[0]] {
        sample.weight = weight;
    }
    for sample in &mut line.samples[n - counts[1]..] {
        sample.weight = weight;
    }
}

/// Half the rope's width as the skeleton knows it, weighted by the lengths of the legs.
fn mean_half(source: &Source, legs: &[Leg]) -> f32 {
    let (mut sum, mut weight) = (0.0, 0.0);
    for leg in legs {
        let length = source.graph.edges[leg.edge as usize].length_px + 0.1;
        sum += length * source.zones.edge_half_px[leg.edge as usize];
        weight += length;
    }
    (sum / weight).max(0.5)
}
