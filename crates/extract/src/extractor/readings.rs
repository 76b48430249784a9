//! Further hypotheses for overlapping strands. The picture shows the seams between them, which the
//! mask hides.

use std::mem::swap;

use super::{Extractor, Step};
use crate::confidence::remainder::Remainder;
use crate::image::Image;
use crate::options::Method;
use crate::scene::Curve;
use crate::tracking::track::Appearance;
use crate::vec2;

/// Penalty for each end of a line within the mask, in squares of the ropes' width. It is added to
/// the area of mask without a line, and to that of lines outside of the mask. The sum is the lack
/// of a hypothesis.
const OPEN_END: f32 = 0.5;
/// Look-ahead distance past an end, in widths. The end is open if the mask continues there.
const AHEAD: f32 = 1.0;
/// Minimum width, in pixels. Narrower ropes show no seams.
const NARROWEST_PX: f32 = 6.0;
/// Minimum lack of a doubted hypothesis.
const DOUBTED: f32 = 0.5;
/// Maximum lack of another hypothesis that replaces it.
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
/// Minimum total length of another hypothesis's ropes, relative to the first. A rope far darker
/// than the others is a seam all over.
const SHORTER: f32 = 0.9;
/// Maximum distance between the points of two curves that are the same, in widths. The curves of
/// the whole mask have finer tips. The second value is for known ropes, as their tips are corrected
/// by the past.
const SAME: (f32, f32) = (1.0, 0.3);
/// Upward curvature of the light in a seam, in standard deviations of the ropes' light, for each
/// hypothesis in turn. The sharper a shadow must be, the fewer seams there are, and all of them are
/// real.
const BENT: [f32; 3] = [0.17, 0.12, 0.25];

/// A hypothesis. One is kept while another is tried.
#[derive(Debug, Default)]
pub(super) struct Hypothesis {
    curves: Vec<Curve>,
    count: usize,
    appearances: Vec<Appearance>,
    remainder: Remainder,
    has_wide: bool,
    is_crowded: bool,
}

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

impl Hypothesis {
    /// Makes room for a hypothesis with as many curves as these, in a picture of this size.
    pub(super) fn reserve(
        &mut self,
        [width, height]: [usize; 2],
        curves: &[Curve],
        appearances: usize,
    ) {
        self.curves.clear();
        self.curves.extend_from_slice(curves);
        self.appearances.reserve(appearances);
        self.remainder.reserve(width, height);
    }
}

impl Extractor {
    /// Runs the steps from the mask to this image's own curves. While the best hypothesis is
    /// doubted, the mask is read again, cut at its seams.
    pub(super) fn read(&mut self, image: &Image, after: &mut dyn FnMut(Step)) {
        self.trace(image, after);
        let is_open = self.zones.has_meeting() && !self.has_wide && !self.occluder.any();
        if !is_open || self.masker.mask.source.is_network() || self.options.method != Method::Skeleton {
            return;
        }
        let width_px = self.widest_px();
        if width_px < NARROWEST_PX {
            return;
        }
        let least_px = SHORTER * self.length_px();
        let mut least = self.doubt_of(width_px);
        if least.lacking < DOUBTED {
            return;
        }
        self.masker.see_seams(image, width_px);
        for bent in BENT {
            self.swap_readings();
            self.masker.cut_seams(width_px, bent);
            self.trace_mask(image, Some(width_px), after);
            let doubt = self.doubt_of(width_px);
            let more = self.count.saturating_sub(self.kept.count) as f32;
            let most = least.all() - BETTER - MORE * more;
            let is_better = doubt.lacking <= MOST && doubt.all() <= most;
            let is_whole = !self.has_wide && self.length_px() >= least_px;
            if is_better && is_whole && !self.tells_the_same(width_px) {
                least = doubt;
                if least.lacking < DOUBTED {
                    return;
                }
            } else {
                self.swap_readings();
            }
        }
    }

    /// Swaps this hypothesis with the kept one. Lines, their colors and gaps remain those of the
    /// last hypothesis; no later step needs them.
    fn swap_readings(&mut self) {
        let kept = &mut self.kept;
        swap(&mut self.curves, &mut kept.curves);
        swap(&mut self.count, &mut kept.count);
        swap(&mut self.appearances, &mut kept.appearances);
        swap(&mut self.remainder, &mut kept.remainder);
        swap(&mut self.has_wide, &mut kept.has_wide);
        swap(&mut self.is_crowded, &mut kept.is_crowded);
    }

    /// Returns whether this hypothesis has the same ropes as the kept one.
    fn tells_the_same(&self, width_px: f32) -> bool {
        let is_known = self.zones.past.widest_half_px().is_some();
        let far_px = width_px * if is_known { SAME.1 } else { SAME.0 };
        let kept = &self.kept.curves[..self.kept.count];
        let are_near = |(a, b): (&[f32; 2], &[f32; 2])| vec2::distance(*a, *b) < far_px;
        let is_kept = |curve: &Curve| {
            kept.iter().any(|other| {
                let (points, others) = (&curve.points, &other.points);
                let is_along = points.iter().zip(others).all(are_near);
                is_along || points.iter().zip(others.iter().rev()).all(are_near)
            })
        };
        kept.len() == self.count && self.curves[..self.count].iter().all(is_kept)
    }

    /// The penalties of this hypothesis, whose ropes have about this width.
    fn doubt_of(&self, width_px: f32) -> Doubt {
        let reach_px = BEND_REACH * width_px;
        let mask = &self.masker.mask.bits;
        let curves = || self.curves[..self.count].iter();
        let longest_px = curves().map(|curve| curve.length_px).fold(0.0, f32::max);
        let ropes = curves().zip(&self.lines);
        let ropes = ropes.filter(|(curve, _)| curve.length_px >= ROPE * longest_px);
        let bends = ropes.map(|(_, line)| line.sharpest(reach_px, |at| mask.has(at)));
        Doubt {
            lacking: self.lacking(width_px),
            kink: width_px * bends.fold(0.0, f32::max),
        }
    }

    /// Width of the widest of this image's curves.
    pub(super) fn widest_px(&self) -> f32 {
        let curves = self.curves[..self.count].iter();
        curves.map(|curve| curve.width_px).fold(0.0, f32::max)
    }

    /// Total length of this image's curves.
    fn length_px(&self) -> f32 {
        let curves = self.curves[..self.count].iter();
        curves.map(|curve| curve.length_px).sum()
    }

    /// The lack of this image's lines, and their area outside of the mask. Parts outside of the
    /// picture do not count.
    fn lacking(&self, width_px: f32) -> f32 {
        let mask = &self.masker.mask.bits;
        let (mut open, mut beside) = (0, 0.0);
        for line in &self.lines[..self.count] {
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
        self.remainder.squares() + OPEN_END * open as f32 + beside
    }
}
