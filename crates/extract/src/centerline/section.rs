//! Cross-sections: the subpixel positions of the rope's two edges across it.
//!
//! A rope's edge is where the difference from the table is half of the rope's own difference there.
//! The lens spreads an edge evenly to both sides, so this point stays in place, whatever the
//! sharpness and the rope's brightness. The rope's own difference is the median over neighboring
//! sections, so that a single speck of shine does not move an edge. It is multiplied by the share
//! of contrast that [`Shading`] finds at the rim.

mod own;

use std::ops::Range;

use lariat_portable::{Arch, Simd, WithSimd};

use super::contrast::Contrast;
use super::edge::{self, Seek, Sought};
use super::line::{Line, Sample};
use super::shading::Shading;
use crate::image::gray::GrayPlane;
use crate::image::ray::{LANES, Lanes, Rays};
use crate::statistics::median;
use crate::vec2::{self, Vec2};

/// Reach of the search for an edge to each side, in half-widths, in addition to 3 px.
const REACH: f32 = 1.6;
/// Same in an overlap, where the other strand may be in between.
const BESIDE: f32 = 3.4;
/// Distance from an end, in half-widths, within which a section may run through a tip's corners.
const TIP: f32 = 1.5;
/// Maximum factor between a section's width and the median, for the section to move a line.
const ALIKE: f32 = 1.25;

/// Maximum distance between a tip and a crossing that separates it from the rope, in half-widths.
const TIP_HALVES: f32 = 2.0;

/// Memory of the measuring.
#[derive(Debug, Default)]
pub(crate) struct Sections {
    contrast: Contrast,
    widths: Vec<f32>,
    found: Vec<Section>,
    /// The normal and the edges of each.
    looks: Vec<Edges>,
    /// Edges that are sought step by step.
    sought: Vec<Asked>,
}

/// A section's normal, and the distances of its edges to either side of its sample. They are NaN
/// until known.
#[derive(Clone, Copy, Debug)]
struct Edges {
    normal: Vec2,
    edges: [f32; 2],
}

/// An edge to seek, on one side (0: that of the −normal) of one of the sections.
#[derive(Clone, Copy, Debug)]
struct Asked {
    slot: usize,
    side: usize,
    level: f32,
    from_px: f32,
    reach_px: f32,
}

/// A sample's index, and the section found there.
type Section = (usize, Option<Found>);

/// The middle and the width of one section.
#[derive(Clone, Copy, Debug)]
struct Found {
    center: Vec2,
    width_px: f32,
    /// True if it is as wide as the rope is there.
    is_own: bool,
}

/// Parameters for the sections of one line.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Measure {
    /// Half the rope's width, as known at this stage.
    pub(crate) half_px: f32,
    /// Distance between the line's samples.
    pub(crate) step_px: f32,
    /// Maximum factor between a section's width and the rope's.
    pub(crate) tolerance: f32,
    /// Tells the share of the rope's contrast at which its edges are.
    pub(crate) shading: Shading,
}

/// The sections of a line to take.
#[derive(Clone, Debug)]
struct Part {
    range: Range<usize>,
    /// Only every `every`-th sample is taken.
    every: usize,
    /// This many samples at either end of the line may be next to a tip's corners.
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

/// Finds sections, for the widest registers.
struct Finding<'a> {
    sections: &'a mut Sections,
    line: &'a Line,
    difference: &'a GrayPlane,
    how: Measure,
    part: Part,
}

impl WithSimd for Finding<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.sections
            .find_in(simd, self.line, self.difference, self.how, self.part);
    }
}

impl Measure {
    /// Number of samples to either side over which a tangent is taken.
    pub(crate) fn tangent_reach(&self) -> usize {
        ((self.half_px / self.step_px) as usize).max(2)
    }

    /// Returns whether the width is that of one rope.
    fn is_plausible(&self, width_px: f32) -> bool {
        let expected = 2.0 * self.half_px;
        (expected / self.tolerance..expected * self.tolerance).contains(&width_px)
    }
}

impl Sections {
    /// Makes room for lines of this many samples.
    pub(crate) fn reserve(&mut self, samples: usize) {
        self.contrast.reserve(samples);
        self.widths.reserve(samples);
        self.found.reserve(samples);
        self.looks.reserve(samples);
        self.sought.reserve(2 * samples);
    }

    /// Moves each sample of `line` outside of crossings to the middle of its section, and gives it
    /// the section's width. Samples of weight 0 are skipped. The weight becomes 0 if the section is
    /// implausible.
    pub(crate) fn measure(&mut self, line: &mut Line, difference: &GrayPlane, how: Measure) {
        let tip = (TIP * how.half_px / how.step_px) as usize + 1;
        let all = Part::all(0..line.samples.len(), if line.closed { 0 } else { tip });
        self.measure_part(line, difference, how, all);
    }

    /// Like [`measure`](Self::measure), but only for the `count` samples at either end.
    pub(crate) fn measure_ends(
        &mut self,
        line: &mut Line,
        difference: &GrayPlane,
        how: Measure,
        count: usize,
    ) {
        let n = line.samples.len();
        let count = count.min(n);
        for end in [0..count, (n - count).max(count)..n] {
            self.measure_part(line, difference, how, Part::all(end, n));
        }
    }

    fn measure_part(&mut self, line: &mut Line, difference: &GrayPlane, how: Measure, part: Part) {
        if part.range.is_empty() {
            return;
        }
        let [first, last] = [part.range.start, part.range.end - 1];
        let tolerance = how.tolerance.max(own::MOST);
        self.find(line, difference, Measure { tolerance, ..how }, part);
        // At a tip, the rope's usual width is the best guess.
        let [from, to] = [first, last].map(|i| match i == 0 || i + 1 == line.samples.len() {
            true => 2.0 * how.half_px,
            false => line.samples[i].width_px,
        });
        own::judge(&line.samples, how, [from, to], &mut self.found);
        for &(i, found) in &self.found {
            let sample = &mut line.samples[i];
            match found.filter(|found| found.is_own) {
                Some(found) => (sample.at, sample.width_px) = (found.center, found.width_px),
                None => sample.weight = 0.0,
            }
        }
    }

    /// Moves `line` roughly to the middle of the rope. One section is taken every half-width, and
    /// the samples in between are shifted with it. Returns the median of the widths, if there are
    /// any.
    pub(crate) fn center(
        &mut self,
        line: &mut Line,
        difference: &GrayPlane,
        how: Measure,
    ) -> Option<f32> {
        let (_, every) = Contrast::reach(how);
        let all = Part::all(0..line.samples.len(), 0);
        self.find(line, difference, how, Part { every, ..all });
        self.widths.clear();
        let sure = self
            .found
            .iter()
            .filter(|(i, _)| line.samples[*i].weight >= 1.0);
        self.widths
            .extend(sure.filter_map(|(_, found)| found.map(|f| f.width_px)));
        if self.widths.is_empty() {
            return None;
        }
        let median_px = median(&mut self.widths);
        // A section that differs from the others shows more than the rope.
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
    fn find(&mut self, line: &Line, difference: &GrayPlane, how: Measure, part: Part) {
        Arch::new().dispatch(Finding {
            sections: self,
            line,
            difference,
            how,
            part,
        });
    }

    #[inline(always)]
    fn find_in<S: Simd>(
        &mut self,
        simd: S,
        line: &Line,
        difference: &GrayPlane,
        how: Measure,
        part: Part,
    ) {
        self.contrast
            .measure(simd, line, difference, how, &part.range);
        let reach = how.tangent_reach();
        self.found.clear();
        self.looks.clear();
        self.sought.clear();
        let mut group = Group::default();
        for i in part.range.clone().step_by(part.every) {
            let sample = &line.samples[i];
            self.found.push((i, None));
            self.looks.push(Edges {
                normal: [0.0; 2],
                edges: [f32::NAN; 2],
            });
            if sample.weight <= 0.0 {
                continue;
            }
            let l = group.count;
            group.rays.lay(l, sample.at, line.slope(i, reach));
            group.contrasts[l] = self.contrast.at(i);
            group.slots[l] = self.found.len() - 1;
            group.count += 1;
            if group.count == LANES {
                self.look(&mut group, line, difference, how, part.tip);
            }
        }
        self.look(&mut group, line, difference, how, part.tip);
        self.seek(line, difference, how.half_px);
        for ((i, found), look) in self.found.iter_mut().zip(&self.looks) {
            let here = look.found(&line.samples[*i], how.half_px);
            *found = here.filter(|here| how.is_plausible(here.width_px));
        }
    }

    /// Looks for the edges of the group's sections where they are expected. Records those that must
    /// be sought step by step, and empties the group.
    #[inline(always)]
    fn look(
        &mut self,
        group: &mut Group,
        line: &Line,
        difference: &GrayPlane,
        how: Measure,
        tip: usize,
    ) {
        let half_px = how.half_px;
        let far = edge::places(half_px).map(|far| [far; LANES]);
        let mut values = [[0.0; LANES]; edge::PLACES];
        group.rays.unify();
        group.rays.read(difference, &far, &mut values);
        let levels = how.shading.levels(&group.rays.along, &group.contrasts);
        let edges = edge::near(&values, &levels, half_px);
        let inside = group.rays.are_inside(difference, edge::reach_px(half_px));
        let reaches_px = [BESIDE * half_px + 3.0, REACH * half_px + 3.0];
        let step_px = edge::step_px(half_px);
        let alone = group.rays.are_inside(difference, reaches_px[1] + step_px);
        let beside = group.rays.are_inside(difference, reaches_px[0] + step_px);
        for l in 0..std::mem::take(&mut group.count) {
            let slot = group.slots[l];
            let i = self.found[slot].0;
            let is_tip = i < tip || i + tip >= line.samples.len();
            let (from, normal) = group.rays.line(l);
            let is_known = inside[l] && !is_tip;
            let mut known = [f32::NAN; 2];
            if is_known {
                known = [edges[0][l], edges[1][l]];
            }
            let look = &mut self.looks[slot];
            (look.normal, look.edges) = (normal, known);
            if !known[0].is_nan() && !known[1].is_nan() {
                continue;
            }
            let seek = if is_tip { Seek::Inside } else { Seek::Near };
            let is_alone = line.samples[i].weight >= 1.0;
            let reach_px = reaches_px[usize::from(is_alone)];
            let levels = [levels[0][l], levels[1][l]];
            if if is_alone { alone[l] } else { beside[l] } {
                for side in 0..2 {
                    if known[side].is_nan() {
                        self.sought.push(Asked {
                            slot,
                            side,
                            level: levels[side],
                            from_px: seek.start_px(half_px),
                            reach_px,
                        });
                    }
                }
            } else {
                let reach = [half_px, reach_px];
                let edges = edge::edges(difference, (from, normal), levels, known, seek, reach);
                look.edges = edges.unwrap_or([f32::NAN; 2]);
            }
        }
    }

    /// Seeks the edges that were not where they were expected.
    #[inline(always)]
    fn seek(&mut self, line: &Line, difference: &GrayPlane, half_px: f32) {
        for group in self.sought.chunks(LANES) {
            let mut sought = Sought::default();
            for l in 0..LANES {
                // The last edge fills the unused lanes.
                let asked = &group[l.min(group.len() - 1)];
                let normal = self.looks[asked.slot].normal;
                let sign = if asked.side == 0 { -1.0 } else { 1.0 };
                let from = line.samples[self.found[asked.slot].0].at;
                for c in 0..2 {
                    sought.rays.from[c][l] = from[c];
                    sought.rays.along[c][l] = sign * normal[c];
                }
                sought.levels[l] = asked.level;
                sought.from_px[l] = asked.from_px;
                sought.reach_px[l] = asked.reach_px;
            }
            let found = sought.find(difference, half_px);
            for (asked, found) in group.iter().zip(found) {
                self.looks[asked.slot].edges[asked.side] = found;
            }
        }
    }
}

/// Sections that are taken at once, one in each lane.
#[derive(Debug, Default)]
struct Group {
    rays: Rays,
    /// The rope's contrast at each.
    contrasts: Lanes,
    /// Index of each among all sections.
    slots: [usize; LANES],
    count: usize,
}

impl Edges {
    /// The middle and the width of the section at a sample, if both of its edges were found.
    #[inline(always)]
    fn found(&self, sample: &Sample, half_px: f32) -> Option<Found> {
        let [left, right] = self.edges;
        if left.is_nan() || right.is_nan() {
            return None;
        }
        // In an overlap, the rest of the width is the other strand's. This strand is off the middle
        // by half of that rest.
        let rest = (left + right - 2.0 * half_px).max(0.0);
        let overlap = sample.weight < 1.0;
        let (aside, width_px) = if overlap {
            let aside = 0.5 * sample.side * rest;
            (aside, (left + right - rest).max(0.1))
        } else {
            (0.0, left + right)
        };
        let far = rest > 2.4 * half_px;
        Some(Found {
            center: vec2::along(sample.at, self.normal, 0.5 * (right - left) + aside),
            width_px: if overlap && far { 0.0 } else { width_px },
            is_own: false,
        })
    }
}

/// The samples between the tips. A tip that a crossing separates from the rope may be on another
/// strand, and its sections may measure that strand. Such a tip moves with the rope before it.
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
