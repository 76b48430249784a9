//! Cross-sections: where across a rope its two edges lie, between pixels.
//!
//! A rope's edge is where the difference from the table is half of the rope's own there: the lens spreads
//! an edge evenly to both sides, so that point stays in place, whatever the sharpness and however
//! bright the rope is. The own difference is the median of the sections around, so that one speck of
//! shine does not move an edge, times what [`Shading`] says is left of it at the rim.

use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};

use crate::edge::{self, Seek};
use crate::line::{Line, Sample};
use crate::plane::Plane;
use crate::ray::Ray;
use crate::shading::Shading;
use crate::vec2::{self, Vec2};

/// Half-widths to each side, beyond 3 px, that an edge is looked for.
const REACH: f32 = 1.6;
/// The same in an overlap, where the other strand may lie in between.
const BESIDE: f32 = 3.4;
/// Places in half-widths across the rope whose mean is its contrast.
const MIDDLE: [f32; 5] = [-0.5, -0.25, 0.0, 0.25, 0.5];
/// Half-widths from an end within which a section may run through the corners of a tip.
const TIP: f32 = 1.5;
/// How much a section's width may differ from the median one that moves a line, as a factor.
const ALIKE: f32 = 1.25;

/// Half-widths from a tip within which a crossing parts it from the rope.
const TIP_HALVES: f32 = 2.0;

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

/// Which sections of a line are taken.
#[derive(Clone, Debug)]
struct Part {
    range: Range<usize>,
    /// Of so many samples one.
    every: usize,
    /// So many samples at either end of the line may lie beside the corners of a tip.
    tip: usize,
}

impl Part {
    fn all(range: Range<usize>, tip: usize) -> Self {
        Self {
            range,
            every: 1,
            tip,
        }
    }
}

/// What finds sections, for the widest registers.
struct Finding<'a> {
    sections: &'a mut Sections,
    line: &'a Line,
    difference: &'a Plane,
    how: Measure,
    part: Part,
}

impl WithSimd for Finding<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.sections
            .find_in(self.line, self.difference, self.how, self.part);
    }
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
        let tip = (TIP * how.half_px / how.step_px) as usize + 1;
        let all = Part::all(0..line.samples.len(), if line.closed { 0 } else { tip });
        self.measure_part(line, difference, how, all);
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
        let count = count.min(n);
        for end in [0..count, (n - count).max(count)..n] {
            self.measure_part(line, difference, how, Part::all(end, n));
        }
    }

    fn measure_part(&mut self, line: &mut Line, difference: &Plane, how: Measure, part: Part) {
        if part.range.is_empty() {
            return;
        }
        self.find(line, difference, how, part);
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
        let all = Part::all(0..line.samples.len(), 0);
        self.find(line, difference, how, Part { every, ..all });
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
        let own = beyond_tips(line, (TIP_HALVES * how.half_px / how.step_px) as usize);
        let mut before: Option<(usize, Vec2, f32)> = None;
        for &(i, found) in &self.found {
            let found = found.filter(|found| alike.is_plausible(found.width_px));
            let Some(found) = found.filter(|_| own.contains(&i)) else {
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

    /// Fills `found` with the plausible sections of a part of the line.
    fn find(&mut self, line: &Line, difference: &Plane, how: Measure, part: Part) {
        Arch::new().dispatch(Finding {
            sections: self,
            line,
            difference,
            how,
            part,
        });
    }

    #[inline(always)]
    fn find_in(&mut self, line: &Line, difference: &Plane, how: Measure, part: Part) {
        self.measure_contrast(line, difference, how, &part.range);
        let (around, stride) = how.contrast_reach();
        let reach = how.tangent_reach();
        let last = self.contrast.len().saturating_sub(1);
        let nearest = |i: usize| ((i + stride / 2) / stride).min(last);
        let first = nearest(part.range.start).saturating_sub(around / stride);
        let mut known = first..first;
        let (mut block, mut contrast) = (usize::MAX, 0.0);
        self.window.clear();
        self.found.clear();
        for i in part.range.step_by(part.every) {
            let sample = &line.samples[i];
            if sample.weight <= 0.0 {
                self.found.push((i, None));
                continue;
            }
            if nearest(i) != block {
                block = nearest(i);
                contrast = self.contrast_near(block, line, how, &mut known);
            }
            let is_tip = i < part.tip || i + part.tip >= line.samples.len();
            let seek = if is_tip { Seek::Inside } else { Seek::Near };
            let levels = how.shading.shares.map(|share| share * contrast);
            let normal = vec2::normal(line.tangent(i, reach));
            let found = section(difference, sample, normal, levels, seek, how.half_px);
            self.found
                .push((i, found.filter(|found| how.is_plausible(found.width_px))));
        }
    }

    /// The rope's own difference from the table at every so-many-th sample that counts for `part`.
    #[inline(always)]
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
        for i in (0..line.samples.len()).step_by(stride) {
            let sample = &line.samples[i];
            if !counts.contains(&i) {
                self.contrast.push(0.0);
                continue;
            }
            let normal = vec2::normal(line.tangent(i, tangent_reach));
            let places = MIDDLE.map(|k| k * how.half_px);
            let values = match Ray::new(difference, sample.at, normal, how.half_px) {
                Some(ray) => ray.at_each(places),
                None => difference.sample_each(sample.at, normal, places),
            };
            self.contrast
                .push(values.iter().sum::<f32>() / MIDDLE.len() as f32);
        }
    }

    /// The median contrast of the visible samples within three widths of the one whose contrast stands at `k`; `k` grows
    /// from call to call, from that of `known`, the range that `window` holds in order.
    #[inline(always)]
    fn contrast_near(
        &mut self,
        k: usize,
        line: &Line,
        how: Measure,
        known: &mut Range<usize>,
    ) -> f32 {
        let (reach, stride) = how.contrast_reach();
        let around = reach / stride;
        let wanted = k.saturating_sub(around)..(k + around + 1).min(self.contrast.len());
        let place = |window: &[f32], value: f32| window.partition_point(|&other| other < value);
        for j in known.start..wanted.start.min(known.end) {
            if line.samples[j * stride].weight > 0.0 {
                let place = place(&self.window, self.contrast[j]);
                self.window.remove(place);
            }
        }
        for j in known.end.max(wanted.start)..wanted.end {
            if line.samples[j * stride].weight > 0.0 {
                let place = place(&self.window, self.contrast[j]);
                self.window.insert(place, self.contrast[j]);
            }
        }
        *known = wanted;
        let median = self.window.get(self.window.len() / 2);
        median.unwrap_or(&self.contrast[k]).max(2.0)
    }
}

/// The section at a sample.
#[inline(always)]
fn section(
    difference: &Plane,
    sample: &Sample,
    normal: Vec2,
    levels: [f32; 2],
    seek: Seek,
    half_px: f32,
) -> Option<Found> {
    let overlap = sample.weight < 1.0;
    let reach_px = if overlap { BESIDE } else { REACH } * half_px + 3.0;
    let [left, right] = edge::edges(
        difference, sample.at, normal, levels, seek, half_px, reach_px,
    )?;
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

/// The samples between the tips: a tip that a crossing parts from the rope may lie upon another strand, and its sections
/// are that one's as much as its own. It goes where the rope before it goes.
fn beyond_tips(line: &Line, within: usize) -> std::ops::Range<usize> {
    let n = line.samples.len();
    if line.closed {
        return 0..n;
    }
    let is_crossed = |sample: &Sample| sample.weight == 0.0;
    let within = within.min(n / 2);
    let first = line.samples[..within].iter().rposition(is_crossed);
    let last = line.samples[n - within..].iter().position(is_crossed);
    first.map_or(0, |i| i + 1)..last.map_or(n, |i| n - within + i)
}
