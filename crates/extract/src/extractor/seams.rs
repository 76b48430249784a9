//! Further readings of strands that lie on each other: the mask hides what the picture shows, the seams between them.

use super::{Extractor, Step};
use crate::image::Image;
use crate::occlusion::ends::Scenery;
use crate::options::Method;

/// What a reading lacks: squares of the ropes' width that no line runs through, or that a line has beside the mask, and so many for each end
/// that lies within it.
const OPEN_END: f32 = 0.5;
/// How far ahead of it, in widths, the mask must end.
const AHEAD: f32 = 1.0;
/// Narrower ropes show no seams.
const NARROWEST_PX: f32 = 6.0;
/// From what it lacks on a reading is doubted, and what another one may lack at most to be taken.
const DOUBTED: f32 = 0.5;
const MOST: f32 = 1.25;
/// By how much less another one must lack, and how much the sharpest bend, as width by radius, weighs beside that: a rope has no kinks.
const BETTER: f32 = 0.25;
const KINK: f32 = 2.0;
/// And by which factor its ropes may be shorter: one far darker than the others is a seam all over.
const SHORTER: f32 = 0.9;
/// How far the light bends upward in a seam, in standard deviations of the ropes' light, in one reading after the other: the sharper a
/// shadow is asked for, the fewer seams there are, and all of them true.
const BENT: [f32; 3] = [0.17, 0.12, 0.25];
/// How far to either side of a place a bend is measured, in widths.
const BEND_REACH: f32 = 0.75;

/// What speaks against a reading.
#[derive(Clone, Copy)]
struct Doubt {
    lacking: f32,
    /// The sharpest bend of its lines, as width by radius.
    kink: f32,
}

impl Doubt {
    fn all(self) -> f32 {
        self.lacking + KINK * self.kink
    }
}

impl Extractor {
    /// The steps from the mask to this image's own curves. As long as the best reading leaves out some of it, it is read once more, cut
    /// at its seams.
    pub(super) fn read(&mut self, image: &Image, after: &mut dyn FnMut(Step)) {
        self.trace(image, after);
        let is_open = self.zones.has_meeting() && !self.has_wide && !self.occluder.any();
        if !is_open || self.masker.is_sought || self.options.method != Method::Skeleton {
            return;
        }
        let width_px = self.widest_px();
        if width_px < NARROWEST_PX {
            return;
        }
        let least_px = SHORTER * self.length_px();
        let mut least = self.doubt_of(width_px);
        // Which of them had that, and which was the last: none is the whole mask.
        let (mut best, mut last) = (None, None);
        for bent in BENT {
            if least.lacking < DOUBTED {
                break;
            }
            self.trace_cut(image, (width_px, bent), after);
            last = Some(bent);
            let doubt = self.doubt_of(width_px);
            let most = f32::min(least.lacking - BETTER, MOST);
            let is_better = doubt.lacking <= most && doubt.all() < least.all();
            if is_better && !self.has_wide && self.length_px() >= least_px {
                (least, best) = (doubt, last);
            }
        }
        if best != last {
            match best {
                Some(bent) => self.trace_cut(image, (width_px, bent), after),
                None => self.trace(image, after),
            }
        }
    }

    /// The same steps, of a mask that is cut at its seams.
    fn trace_cut(
        &mut self,
        image: &Image,
        (width_px, bent): (f32, f32),
        after: &mut dyn FnMut(Step),
    ) {
        self.masker.cut_seams(image, width_px, bent);
        self.trace_mask(image, Some(width_px), after);
    }

    fn doubt_of(&self, width_px: f32) -> Doubt {
        let reach_px = BEND_REACH * width_px;
        let mask = &self.masker.mask;
        let lines = self.lines[..self.count].iter();
        let bends = lines.map(|line| line.sharpest(reach_px, |at| mask.has(at)));
        let bend = bends.fold(0.0, f32::max);
        Doubt {
            lacking: self.lacking(width_px),
            kink: width_px * bend,
        }
    }

    /// How wide the widest of this image's curves is.
    pub(super) fn widest_px(&self) -> f32 {
        let curves = self.curves[..self.count].iter();
        curves.map(|curve| curve.width_px).fold(0.0, f32::max)
    }

    /// How long this image's lines are together.
    fn length_px(&self) -> f32 {
        let curves = self.curves[..self.count].iter();
        curves.map(|curve| curve.length_px).sum()
    }

    /// What this image's lines lack, and have beside the mask.
    fn lacking(&self, width_px: f32) -> f32 {
        let mask = &self.masker.mask;
        let (mut open, mut beside) = (0, 0.0);
        for line in &self.lines[..self.count] {
            let stray = line.samples.iter().filter(|sample| {
                let is_in_picture = self.masker.difference.holds(sample.at);
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

    /// Joins the first `count` lines, of a mask that was cut, where they pass under each other, and lays them anew in the whole one.
    pub(super) fn join_strands(&mut self, count: usize, width_px: f32, yuv: bool) -> usize {
        let scenery = Scenery {
            past: &self.zones.past,
            difference: &self.masker.whole.0,
            level: super::SOMETHING,
            occluder: &self.occluder.plane,
            yuv,
            elsewhere: None,
            picked: None,
        };
        let (lines, colors) = (&mut self.lines[..count], &mut self.colors[..]);
        let mask = (&self.masker.whole.1, width_px);
        let joined = self.bridger.join_under(lines, colors, &scenery, mask);
        self.masker.uncut();
        for line in &mut self.lines[..joined] {
            let difference = &self.masker.difference;
            self.centerliner.lay_anew(line, difference, 0.5 * width_px);
        }
        joined
    }
}
