//! Further hypotheses for overlapping strands. The picture shows the seams between them, which the
//! mask hides.

use std::mem::swap;

use super::{Extractor, Step};
use crate::image::Image;
use crate::options::Method;
use crate::scene::Curve;
use crate::vec2;

/// Penalty for each end of a line within the mask, in squares of the ropes' width. It is added to
/// the area of mask without a line, and to the area of lines outside of the mask. The sum is called
/// the lack of a hypothesis.
const OPEN_END: f32 = 0.5;
/// Look-ahead distance past an end, in widths. The end is open if the mask continues there.
const AHEAD: f32 = 1.0;
/// Minimum width, in pixels. Narrower ropes show no seams.
const NARROWEST_PX: f32 = 6.0;
/// Minimum lack of a doubted hypothesis.
const DOUBTED: f32 = 0.5;
/// Maximum lack of another hypothesis that replaces a doubted one.
const MOST: f32 = 2.0;
/// Weight of the sharpest bend (width divided by radius) relative to the lack. Ropes do not kink.
const KINK: f32 = 2.0;
/// Distance to either side of a place over which a bend is measured, in widths.
const BEND_REACH: f32 = 0.75;
/// Minimum length of a rope, as a share of the longest. A shorter curve may be another object,
/// which has kinks.
const ROPE: f32 = 0.25;
/// Minimum improvement of another hypothesis.
const BETTER: f32 = 0.1;
/// Additional improvement for each further rope: a mask that was cut is in pieces.
const MORE: f32 = 1.0;
/// Minimum total length of another hypothesis's ropes, relative to the first. A rope that is far
/// darker than the others looks like a seam everywhere.
const SHORTER: f32 = 0.9;
/// Maximum distance between the points of two curves that are the same, in widths. The curves of
/// the whole mask have finer tips. The second value is for known ropes, as their tips are corrected
/// by the past.
const SAME: (f32, f32) = (1.0, 0.3);
/// Upward curvature of the light in a seam, in standard deviations of the ropes' light, for each
/// hypothesis in turn. The sharper a shadow must be, the fewer seams are found, and the more
/// certain they are.
const BENT: [f32; 2] = [0.17, 0.12];

/// The penalties of a hypothesis.
#[derive(Clone, Copy, Debug)]
struct Doubt {
    lacking: f32,
    /// The sharpest bend of its ropes, as width divided by radius.
    kink: f32,
}

impl Doubt {
    fn all(self) -> f32 {
        self.lacking + KINK * self.kink
    }
}

impl Extractor {
    /// Runs the steps from the mask to this image's own curves. While the best hypothesis is
    /// doubted, the mask is read again, cut at its seams.
    pub(super) fn trace_best(&mut self, image: &Image, after: &mut dyn FnMut(Step)) {
        self.trace(image, None, after);
        let is_open =
            self.tracer.zones.has_meeting() && !self.found.has_wide && !self.found.has_occluder;
        if !is_open
            || self.masker.mask.source.is_network()
            || self.options.method != Method::Skeleton
        {
            return;
        }
        let width_px = self.found.widest_px();
        if width_px < NARROWEST_PX {
            return;
        }
        let least_px = SHORTER * self.found.length_px();
        let mut least = self.doubt_of(width_px);
        if least.lacking < DOUBTED {
            return;
        }
        self.masker.see_seams(image, width_px);
        for bent in BENT {
            swap(&mut self.found, &mut self.other);
            self.masker.cut_seams(width_px, bent);
            self.trace(image, Some(width_px), after);
            let doubt = self.doubt_of(width_px);
            let more = self.found.count.saturating_sub(self.other.count) as f32;
            let most = least.all() - BETTER - MORE * more;
            let is_better = doubt.lacking <= MOST && doubt.all() <= most;
            let is_whole = !self.found.has_wide && self.found.length_px() >= least_px;
            if is_better && is_whole && !self.has_same_ropes(width_px) {
                least = doubt;
                if least.lacking < DOUBTED {
                    return;
                }
            } else {
                swap(&mut self.found, &mut self.other);
            }
        }
    }

    /// Returns whether this hypothesis has the same ropes as the kept one.
    fn has_same_ropes(&self, width_px: f32) -> bool {
        let is_known = self.tracer.zones.past.widest_half_px().is_some();
        let far_px = width_px * if is_known { SAME.1 } else { SAME.0 };
        let kept = self.other.seen();
        let are_near = |(a, b): (&[f32; 2], &[f32; 2])| vec2::distance(*a, *b) < far_px;
        let is_kept = |curve: &Curve| {
            kept.iter().any(|other| {
                let (points, others) = (&curve.points, &other.points);
                let is_along = points.iter().zip(others).all(are_near);
                is_along || points.iter().zip(others.iter().rev()).all(are_near)
            })
        };
        kept.len() == self.found.count && self.found.seen().iter().all(is_kept)
    }

    /// The penalties of this hypothesis, whose ropes have about this width.
    fn doubt_of(&self, width_px: f32) -> Doubt {
        let reach_px = BEND_REACH * width_px;
        let mask = &self.masker.mask.bits;
        let curves = || self.found.seen().iter();
        let longest_px = curves().map(|curve| curve.length_px).fold(0.0, f32::max);
        let ropes = curves().zip(&self.tracer.lines);
        let ropes = ropes.filter(|(curve, _)| curve.length_px >= ROPE * longest_px);
        let bends = ropes.map(|(_, line)| line.sharpest(reach_px, |at| mask.has(at)));
        Doubt {
            lacking: self.lacking(width_px),
            kink: width_px * bends.fold(0.0, f32::max),
        }
    }

    /// The lack of this image's lines, and their area outside of the mask. Parts outside of the
    /// picture do not count.
    fn lacking(&self, width_px: f32) -> f32 {
        let mask = &self.masker.mask.bits;
        let (mut open, mut beside) = (0, 0.0);
        for line in &self.tracer.lines[..self.found.count] {
            let stray = line.samples.iter().filter(|sample| {
                let is_in_picture = self.masker.mask.difference.holds(sample.at);
                is_in_picture && !mask.has(sample.at)
            });
            let step_px = line.length_px() / line.samples.len().max(1) as f32;
            beside += stray.count() as f32 * step_px / width_px;
            let is_open = |end: usize| {
                let is_free = !line.closed && !line.border[end];
                is_free && mask.has(line.ahead(end == 1, AHEAD * width_px))
            };
            open += (0..2).filter(|&end| is_open(end)).count();
        }
        self.found.remainder.squares() + OPEN_END * open as f32 + beside
    }
}
