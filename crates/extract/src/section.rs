//! Cross-sections: where across a rope its two edges lie, between pixels.
//!
//! A rope's edge is where the difference from the table is half of the rope's own there: the lens spreads
//! an edge evenly to both sides, so that point stays in place, whatever the sharpness and however
//! bright the rope is. The own difference is the median of the sections around, so that one speck of
//! shine does not move an edge, times what [`Shading`] says is left of it at the rim.

use std::ops::Range;

use crate::line::{Line, Sample};
use crate::plane::Plane;
use crate::ray::Ray;
use crate::shading::Shading;
use crate::vec2::{self, Vec2};

/// Half-widths to each side, beyond 3 px, that an edge is looked for.
const REACH: f32 = 1.6;
/// The same in an overlap, where the other strand may lie in between.
const BESIDE: f32 = 3.4;
/// The part of a half-width around the center where no edge is looked for: shine lies there.
const CORE: f32 = 0.35;
/// How much a section's width may differ from the median one that moves a line, as a factor.
const ALIKE: f32 = 1.25;
/// The least distance between places that are read: over a whole pixel a sharp edge is no straight line, and 0.01 px would
/// be lost.
const STEP_PX: f32 = 0.5;

/// Memory of the measuring.
#[derive(Debug, Default)]
pub(crate) struct Sections {
    /// The rope's own difference from the table at every so-many-th sample.
    contrast: Vec<f32>,
    window: Vec<f32>,
    /// What was found at which sample.
    found: Vec<(usize, Option<Found>)>,
}

/// The middle and the width of one section.
#[derive(Clone, Copy, Debug)]
struct Found {
    center: Vec2,
    width_px: f32,
}

/// How the sections of one line are taken.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Measure {
    /// Half the rope's width, as known so far.
    pub(crate) half_px: f32,
    /// Distance between the line's samples.
    pub(crate) step_px: f32,
    /// How much a section's width may differ from the rope's, as a factor.
    pub(crate) tolerance: f32,
    /// At which share of the rope's contrast its edges lie.
    pub(crate) shading: Shading,
}

impl Measure {
    /// Samples to either side that a tangent is taken over.
    fn tangent_reach(&self) -> usize {
        ((self.half_px / self.step_px) as usize).max(2)
    }

    /// Samples to either side whose contrast counts at a place, and from one of these to the next.
    fn contrast_reach(&self) -> (usize, usize) {
        let reach = ((6.0 * self.half_px / self.step_px) as usize).max(4);
        (reach, (reach / 6).max(1))
    }

    /// Whether the width is that of one rope.
    fn is_plausible(&self, width_px: f32) -> bool {
        let expected = 2.0 * self.half_px;
        (expected / self.tolerance..expected * self.tolerance).contains(&width_px)
    }
}

impl Sections {
    /// Moves each sample of `line` that lies outside of crossings to the middle of its section and
    /// gives it its width; weights 0 are left alone, and set where a section makes no sense.
    pub(crate) fn measure(&mut self, line: &mut Line, difference: &Plane, how: Measure) {
        self.measure_part(line, difference, how, 0..line.samples.len());
    }

    /// As [`measure`](Self::measure), only for the `count` samples at either end.
    pub(crate) fn measure_ends(
        &mut self,
        line: &mut Line,
        difference: &Plane,
        how: Measure,
        count: usize,
    ) {
        let n = line.samples.len();
        if 2 * count >= n {
            return self.measure(line, difference, how);
        }
        self.measure_part(line, difference, how, 0..count);
        self.measure_part(line, difference, how, n - count..n);
    }

    fn measure_part(
        &mut self,
        line: &mut Line,
        difference: &Plane,
        how: Measure,
        part: Range<usize>,
    ) {
        self.find(line, difference, how, part, 1);
        for &(i, found) in &self.found {
            let sample = &mut line.samples[i];
            match found {
                Some(found) => (sample.at, sample.width_px) = (found.center, found.width_px),
                None => sample.weight = 0.0,
            }
        }
    }

    /// Moves `line` roughly to the middle of the rope: by a section every half-width, those between moved along. Returns
    /// the median of the widths, if there are any.
    pub(crate) fn center(
        &mut self,
        line: &mut Line,
        difference: &Plane,
        how: Measure,
    ) -> Option<f32> {
        let (_, every) = how.contrast_reach();
        self.find(line, difference, how, 0..line.samples.len(), every);
        self.window.clear();
        let sure = self
            .found
            .iter()
            .filter(|(i, _)| line.samples[*i].weight >= 1.0);
        self.window
            .extend(sure.filter_map(|(_, found)| found.map(|f| f.width_px)));
        if self.window.is_empty() {
            return None;
        }
        let median_px = crate::background::median(&mut self.window);
        // What differs from the others is no section of the rope alone.
        let alike = Measure {
            half_px: 0.5 * median_px,
            tolerance: ALIKE,
            ..how
        };
        let mut before: Option<(usize, Vec2, f32)> = None;
        for &(i, found) in &self.found {
            let Some(found) = found.filter(|found| alike.is_plausible(found.width_px)) else {
                continue;
            };
            let (shift, width_px) = (vec2::sub(found.center, line.samples[i].at), found.width_px);
            let (from, old, old_px) = before.unwrap_or((0, shift, width_px));
            let share = 1.0 / (i - from).max(1) as f32;
            for (k, sample) in line.samples[from..i].iter_mut().enumerate() {
                let t = share * k as f32;
                let here = vec2::along(old, vec2::sub(shift, old), t);
                sample.at = vec2::add(sample.at, here);
                sample.width_px = old_px + t * (width_px - old_px);
            }
            before = Some((i, shift, width_px));
        }
        if let Some((from, shift, width_px)) = before {
            for sample in &mut line.samples[from..] {
                (sample.at, sample.width_px) = (vec2::add(sample.at, shift), width_px);
            }
        }
        Some(median_px)
    }

    /// Fills `found` with the plausible sections of every `every`-th sample of a part of the line.
    fn find(
        &mut self,
        line: &Line,
        difference: &Plane,
        how: Measure,
        part: Range<usize>,
        every: usize,
    ) {
        self.measure_contrast(line, difference, how, &part);
        let (_, stride) = how.contrast_reach();
        let reach = how.tangent_reach();
        let (mut block, mut contrast) = (usize::MAX, 0.0);
        self.found.clear();
        for i in part.step_by(every) {
            let sample = &line.samples[i];
            if sample.weight <= 0.0 {
                self.found.push((i, None));
                continue;
            }
            let nearest = ((i + stride / 2) / stride).min(self.contrast.len() - 1);
            if nearest != block {
                (block, contrast) = (nearest, self.contrast_near(nearest, line, how));
            }
            let levels = how.shading.shares.map(|share| share * contrast);
            let normal = vec2::normal(line.tangent(i, reach));
            let found = section(difference, sample, normal, levels, how.half_px);
            self.found
                .push((i, found.filter(|found| how.is_plausible(found.width_px))));
        }
    }

    /// The rope's own difference from the table at every so-many-th sample that counts for `part`.
    fn measure_contrast(
        &mut self,
        line: &Line,
        difference: &Plane,
        how: Measure,
        part: &Range<usize>,
    ) {
        let (reach, stride) = how.contrast_reach();
        let tangent_reach = how.tangent_reach();
        let counts = part.start.saturating_sub(reach + stride)..part.end + reach + stride;
        self.contrast.clear();
        for (i, sample) in line.samples.iter().enumerate().step_by(stride) {
            if !counts.contains(&i) {
                self.contrast.push(0.0);
                continue;
            }
            let normal = vec2::normal(line.tangent(i, tangent_reach));
            let places = [-0.5, -0.25, 0.0, 0.25, 0.5].map(|k| k * how.half_px);
            let values = match Ray::new(difference, sample.at, normal, how.half_px) {
                Some(ray) => places.map(|far| ray.at(far)),
                None => places.map(|far| difference.sample(vec2::along(sample.at, normal, far))),
            };
            self.contrast.push(values.iter().sum::<f32>() / 5.0);
        }
    }

    /// The median contrast of the visible samples within three widths of the one whose contrast stands at `k`.
    fn contrast_near(&mut self, k: usize, line: &Line, how: Measure) -> f32 {
        let (reach, stride) = how.contrast_reach();
        let around = reach / stride;
        let last = (k + around + 1).min(self.contrast.len());
        self.window.clear();
        for j in k.saturating_sub(around)..last {
            if line.samples[j * stride].weight > 0.0 {
                self.window.push(self.contrast[j]);
            }
        }
        if self.window.is_empty() {
            return self.contrast[k].max(2.0);
        }
        crate::background::median(&mut self.window).max(2.0)
    }
}

/// The section at a sample.
#[inline(always)]
fn section(
    difference: &Plane,
    sample: &Sample,
    normal: Vec2,
    levels: [f32; 2],
    half_px: f32,
) -> Option<Found> {
    let overlap = sample.weight < 1.0;
    let reach_px = if overlap { BESIDE } else { REACH } * half_px + 3.0;
    let [left, right] = edges(difference, sample.at, normal, levels, half_px, reach_px)?;
    // Of two strands side by side, this one lies half the rest of the width aside.
    let rest = (left + right - 2.0 * half_px).max(0.0);
    let (aside, width_px) = if overlap {
        (0.5 * sample.side * rest, (left + right - rest).max(0.1))
    } else {
        (0.0, left + right)
    };
    let far = rest > 2.4 * half_px;
    Some(Found {
        center: vec2::along(sample.at, normal, 0.5 * (right - left) + aside),
        width_px: if overlap && far { 0.0 } else { width_px },
    })
}

/// The distances along −`normal` and +`normal` at which the difference falls below each level. Where the image ends
/// before one edge, the other and the rope's width tell.
#[inline(always)]
fn edges(
    difference: &Plane,
    center: Vec2,
    normal: Vec2,
    levels: [f32; 2],
    half_px: f32,
    reach_px: f32,
) -> Option<[f32; 2]> {
    let found = match Ray::new(difference, center, normal, reach_px + step_px(half_px)) {
        Some(ray) => [-1.0, 1.0].map(|side| {
            let level = levels[usize::from(side > 0.0)];
            edge(|far| Some(ray.at(side * far)), level, half_px, reach_px)
        }),
        None => [-1.0, 1.0].map(|side| {
            let level = levels[usize::from(side > 0.0)];
            let read = |far| {
                let place = vec2::along(center, normal, side * far);
                difference.holds(place).then(|| difference.sample(place))
            };
            edge(read, level, half_px, reach_px)
        }),
    };
    match found {
        [Edge::At(left), Edge::At(right)] => Some([left, right]),
        [Edge::At(left), Edge::OutOfImage] => Some([left, 2.0 * half_px - left]),
        [Edge::OutOfImage, Edge::At(right)] => Some([2.0 * half_px - right, right]),
        _ => None,
    }
}

/// One edge of a section, at a distance from its center.
#[derive(Clone, Copy, Debug)]
enum Edge {
    At(f32),
    OutOfImage,
    OutOfReach,
}

/// Distance between the places of a section that are read.
fn step_px(half_px: f32) -> f32 {
    (half_px / 12.0).max(STEP_PX)
}

/// Where the difference, which `read` tells for a distance as long as it lies in the image, falls below `level`: sought
/// from where the rope's width says that it does, inward or outward, whichever way it lies.
#[inline(always)]
fn edge(read: impl Fn(f32) -> Option<f32>, level: f32, half_px: f32, reach_px: f32) -> Edge {
    let (core, step) = (CORE * half_px, step_px(half_px));
    let between = |(inner, high): (f32, f32), (outer, low): (f32, f32)| {
        inner + (outer - inner) * (high - level) / (high - low)
    };
    let start = (half_px - 0.5 * step).max(core);
    let (mut at, mut value) = (start, read(start));
    match value {
        Some(mut inside) if inside >= level => {
            while at < reach_px {
                let next = at + step;
                match read(next) {
                    None => return Edge::OutOfImage,
                    Some(low) if low < level => {
                        return Edge::At(between((at, inside), (next, low)));
                    }
                    Some(value) => (at, inside) = (next, value),
                }
            }
            Edge::OutOfReach
        }
        _ => {
            while at > core {
                let inner = (at - step).max(core);
                let found = read(inner);
                if let Some(high) = found.filter(|&high| high >= level) {
                    return value.map_or(Edge::OutOfImage, |low| {
                        Edge::At(between((inner, high), (at, low)))
                    });
                }
                (at, value) = (inner, found);
            }
            value.map_or(Edge::OutOfImage, |_| Edge::At(core))
        }
    }
}

/// How far the rope goes on along the path `at` (a position for each distance), at most `limit_px`:
/// the distance of the tip, and whether the image's border cuts it.
pub(crate) fn tip(
    difference: &Plane,
    at: impl Fn(f32) -> Vec2,
    level: f32,
    limit_px: f32,
) -> (f32, bool) {
    const STEP: f32 = 0.5;
    let mut before = difference.sample(at(0.0));
    let mut far = 0.0;
    while far < limit_px {
        let p = at(far + STEP);
        let value = difference.sample(p);
        if value < level {
            let fall = before - value;
            let part = if fall > 0.0 {
                ((before - level) / fall).clamp(0.0, 1.0)
            } else {
                0.0
            };
            return (far + STEP * part, false);
        }
        if !difference.holds(p) {
            return (far + STEP, true);
        }
        (far, before) = (far + STEP, value);
    }
    (far, false)
}
