//! From strands to curves: the lines along the strands, corrections from the last image, and the
//! curves' points.

use lariat_portable::{Arch, NullaryFnOnce};

use super::hypothesis::Hypothesis;
use super::tracer::{Observation, Tracer};
use crate::centerline::line::{Line, MOST_PIECES};
use crate::centerline::source::Source;
use crate::image::ray::LANES;
use crate::image::{Image, color};
use crate::judge::Evidence;
use crate::mask::RopeMask;
use crate::occlusion::bridge::Gap;
use crate::options::Method;
use crate::scene::Curve;
use crate::statistics::median;
use crate::tracking::refit::{self, Refitter};
use crate::tracking::tips;
use crate::tracking::track::Appearance;

/// Minimum length of a rope, in widths.
const SHORTEST: f32 = 4.0;
/// Minimum length, in widths, of a rope whose omission is reported.
const LONG: f32 = 8.0;
/// Minimum length of a fragment of a rope, in half-widths of the skeleton. A shorter one cannot be
/// recognized.
const PIECE: f32 = 4.0;
/// Approximate number of samples of all lines together. Eight ropes from side to side of 640×480
/// pixels, or one that crosses itself ten times, need half as many. Longer ropes get wider spacing,
/// and further fragments are ignored.
const MOST_SAMPLES: usize = 6144;
/// Number of places along a line whose mean color is the rope's.
const COLORS_ASKED: usize = 64;

impl Tracer {
    /// Lays a line for each strand that is long enough to be a fragment of a rope, longest first.
    /// Returns their number.
    pub(super) fn lay_lines(
        &mut self,
        of: &Observation,
        mask: &RopeMask,
        found: &mut Hypothesis,
    ) -> usize {
        let &Observation { image, options, .. } = of;
        self.colors.clear();
        (found.is_crowded, found.has_dropped) = (false, false);
        let (mut count, mut samples) = (0, 0);
        let ropes = self.assigner.strands().iter().take(options.ropes);
        let ropes_px: f32 = ropes.map(|strand| strand.length_px).sum();
        for strand in self.assigner.strands() {
            let enough = count >= options.ropes && samples >= MOST_SAMPLES;
            let piece = strand.length_px >= PIECE * self.zones.half_px;
            if count == MOST_PIECES || enough || !piece {
                found.is_crowded = piece && strand.length_px > 2.0 * LONG * self.zones.half_px;
                break;
            }
            if self.lines.len() <= count {
                self.lines.push(Line::default());
            }
            let line = &mut self.lines[count];
            let source = Source {
                difference: &mask.difference,
                skeleton: &self.skeleton,
                graph: &self.graph,
                zones: &self.zones,
                legs: self.assigner.legs(),
                shared: self.assigner.shared(),
                least_step_px: ropes_px / MOST_SAMPLES as f32,
            };
            let is_laid = match options.method {
                Method::Skeleton => self.centerliner.build(&source, strand, line),
                _ => {
                    let centers = (&self.clustering.clusterer.centers[..], &mask.bits);
                    self.clustering
                        .orderer
                        .build(&source, strand, centers, line)
                }
            };
            if is_laid {
                count += 1;
            }
            samples += line.samples.len();
        }
        let lines = self.lines[..count].iter();
        self.colors
            .extend(lines.map(|line| mean_color(image, line)));
        count
    }

    /// Drops those of the first `count` lines that are not ropes. Returns how many remain, in their
    /// order.
    pub(super) fn drop_noise(&mut self, mask: &RopeMask, count: usize) -> usize {
        let levels = &mask.difference;
        self.noise_filter.find(&self.lines[..count], levels);
        let mut kept = 0;
        for l in 0..count {
            if self.noise_filter.is_noise(l) {
                self.bridger.gaps.retain(|gap| gap.line != l);
                continue;
            }
            self.lines.swap(kept, l);
            self.colors.swap(kept, l);
            for gap in self.bridger.gaps.iter_mut().filter(|gap| gap.line == l) {
                gap.line = kept;
            }
            kept += 1;
        }
        kept
    }

    /// Extends those of the first `count` lines with a tip on another strand or under an occluder
    /// to their rope's length.
    pub(super) fn lengthen(&mut self, mask: &RopeMask, count: usize) {
        let occluder = &self.occluder.plane;
        for (l, line) in self.lines[..count].iter_mut().enumerate() {
            let planes = [&mask.bits, occluder];
            let [before_px, after_px] = tips::lengthen(line, &self.zones.past, planes);
            let gaps = &mut self.bridger.gaps;
            if before_px + after_px == 0.0 {
                if gaps.iter().all(|gap| gap.line != l) {
                    tips::shorten(line, &self.zones.past, planes);
                }
                continue;
            }
            for gap in gaps.iter_mut().filter(|gap| gap.line == l) {
                gap.from_px += before_px;
                gap.to_px += before_px;
            }
            let length_px = line.length_px();
            Refitter::covered(line, occluder, |from_px, to_px| {
                if from_px < before_px || to_px > length_px - after_px {
                    gaps.push(Gap {
                        line: l,
                        from_px,
                        to_px,
                    });
                }
            });
        }
    }

    /// Cuts the connectors off the first `count` lines.
    pub(super) fn cut_connectors(&mut self, image: &Image, count: usize) {
        for (l, line) in self.lines[..count].iter_mut().enumerate() {
            let [before_px, _] = self.connector_cutter.cut(line, image);
            for gap in self.bridger.gaps.iter_mut().filter(|gap| gap.line == l) {
                gap.from_px -= before_px;
                gap.to_px -= before_px;
            }
        }
    }

    /// Replaces the first `count` lines by the ropes of the last image, refitted to this one, if
    /// the lines contradict those ropes. Returns the new number of lines.
    pub(super) fn refit(&mut self, image: &Image, mask: &RopeMask, count: usize) -> usize {
        let scene = refit::Scene {
            past: &self.zones.past,
            moves: &self.bridger.moves,
            difference: &mask.difference,
            mask: &mask.bits,
            occluder: &self.occluder.plane,
            skeleton: &self.skeleton,
        };
        // Without meeting strands or occluders, one image is unambiguous.
        let ring = self.assigner.strands().iter().any(|strand| strand.closed);
        let open = self.zones.has_meeting() || self.occluder.any() || ring;
        if !open || self.bridger.is_reassigned || !self.refitter.refit(&self.lines[..count], &scene)
        {
            return count;
        }
        let count = self.refitter.take(&mut self.lines, count);
        self.colors.clear();
        self.bridger.gaps.clear();
        for (l, line) in self.lines[..count].iter().enumerate() {
            self.colors.push(mean_color(image, line));
            Refitter::covered(line, &self.occluder.plane, |from_px, to_px| {
                self.bridger.gaps.push(Gap {
                    line: l,
                    from_px,
                    to_px,
                });
            });
        }
        count
    }

    /// Makes a curve of each of the first `count` lines that is long enough to be a rope.
    pub(super) fn points(
        &mut self,
        of: &Observation,
        count: usize,
        mask: &RopeMask,
        found: &mut Hypothesis,
    ) {
        found.count = 0;
        found.appearances.clear();
        for l in 0..count {
            self.fill_curve(of, l, found);
            let curve = &found.curves[found.count];
            if curve.length_px < SHORTEST * curve.width_px {
                continue;
            }
            let reach_px = 0.7 * curve.width_px + 3.0;
            let is_covered = |end: usize, at: Option<&[f32; 2]>| {
                let free = !curve.closed && !curve.border[end];
                free && at.is_some_and(|&at| self.occluder.is_near(at, reach_px))
            };
            let covered = [
                is_covered(0, curve.points.first()),
                is_covered(1, curve.points.last()),
            ];
            found.appearances.push(Appearance {
                color: self.colors[l],
                covered,
                is_plain: !self.occluder.any(),
                is_split: self.bridger.is_split,
                free: covered == [false; 2] && tips::are_free(curve, &mask.bits),
                evidence: Evidence::default(),
            });
            // Lines and curves have the same index from here on.
            self.lines.swap(found.count, l);
            found.count += 1;
        }
    }

    /// Leaves out the curves with the least confidence × length, if there are more than `most`.
    pub(super) fn leave_out(&mut self, most: usize, found: &mut Hypothesis) {
        while found.count > most {
            let weight = |curve: &Curve| curve.confidence * curve.length_px;
            let curves = found.seen().iter().enumerate();
            let weights = curves.map(|(c, curve)| (weight(curve), c));
            // Among equal weights, takes the last, which is that of the shortest curve.
            let least = weights.min_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
            let c = least.map_or(found.count - 1, |(_, c)| c);
            let left_out = &found.curves[c];
            found.is_crowded |= left_out.length_px > LONG * left_out.width_px;
            // The order stays the same, because lines and curves share their index.
            found.curves[c..found.count].rotate_left(1);
            self.lines[c..found.count].rotate_left(1);
            found.appearances.remove(c);
            found.count -= 1;
        }
    }

    /// Fills the next curve with the points of line `l`.
    fn fill_curve(&mut self, of: &Observation, l: usize, found: &mut Hypothesis) {
        let line = &self.lines[l];
        line.resample(of.options.points, &mut self.spaced);
        if found.curves.len() <= found.count {
            found.curves.push(Curve::default());
        }
        let curve = &mut found.curves[found.count];
        curve.closed = line.closed;
        curve.border = line.border;
        curve.length_px = line.length_px();
        let widths = || self.spaced.iter().map(|s| s.width_px);
        curve.widths_px.clear();
        curve.widths_px.extend(widths());
        curve.width_px = median(&mut curve.widths_px);
        curve.widths_px.clear();
        curve.widths_px.extend(widths());
        let intervals = self.spaced.len() - usize::from(!curve.closed);
        let step_px = curve.length_px / intervals.max(1) as f32;
        let gaps = || self.bridger.gaps.iter().filter(|gap| gap.line == l);
        curve.hidden.clear();
        curve.hidden.extend((0..self.spaced.len()).map(|i| {
            let along_px = i as f32 * step_px;
            gaps().any(|gap| gap.from_px < along_px && along_px < gap.to_px)
        }));
        // Smoothing may move a tip at the image's border slightly outside.
        let last = [of.image.width(), of.image.height()].map(|side| side as f32 - 1.0);
        let places = self.spaced.iter().zip(&curve.hidden);
        curve.points.clear();
        curve.points.extend(places.map(|(sample, &is_hidden)| {
            let within = |c: usize| sample.at[c].clamp(0.0, last[c]);
            if is_hidden {
                sample.at
            } else {
                [within(0), within(1)]
            }
        }));
    }
}

/// Mean native color along a line.
fn mean_color(image: &Image, line: &Line) -> [f32; 3] {
    Arch::new().dispatch(Asking { image, line })
}

/// Reads colors, for the widest registers.
struct Asking<'a> {
    image: &'a Image<'a>,
    line: &'a Line,
}

impl NullaryFnOnce for Asking<'_> {
    type Output = [f32; 3];

    #[inline(always)]
    fn call(self) -> [f32; 3] {
        let samples = &self.line.samples;
        let stride = (samples.len() / COLORS_ASKED).max(1);
        let asked = samples.len().div_ceil(stride);
        let mut sums = [[0.0; LANES]; 3];
        for first in (0..asked).step_by(LANES) {
            let (mut at, mut counts) = ([[0.0; LANES]; 2], [0.0; LANES]);
            for l in 0..LANES.min(asked - first) {
                let sample = &samples[stride * (first + l)];
                (at[0][l], at[1][l], counts[l]) = (sample.at[0], sample.at[1], 1.0);
            }
            let colors = color::between_each(self.image, &at);
            for (sums, colors) in sums.iter_mut().zip(&colors) {
                for l in 0..LANES {
                    sums[l] += counts[l] * colors[l];
                }
            }
        }
        let share = 1.0 / asked.max(1) as f32;
        let mut mean = [0.0; 3];
        for (mean, sums) in mean.iter_mut().zip(&sums) {
            *mean = share * sums.iter().sum::<f32>();
        }
        mean
    }
}
