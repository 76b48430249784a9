//! A second reading of strands that lie on each other: the mask hides what the picture shows, the seams between them.

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
/// From what it lacks on a reading is doubted; and by how much less another one must lack to be taken.
const DOUBTED: f32 = 0.5;
const BETTER: f32 = 0.25;
/// And what it may lack at most, and by which factor its ropes may be shorter: one far darker than the others is a seam all over.
const MOST: f32 = 1.25;
const SHORTER: f32 = 0.9;

impl Extractor {
    /// The steps from the mask to this image's own curves. Where they leave out some of it, it is read once more, cut at its seams.
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
        let lacking = self.lacking(width_px);
        if lacking < DOUBTED {
            return;
        }
        let length_px = self.length_px();
        self.masker.cut_seams(image, width_px);
        self.trace_mask(image, Some(width_px), after);
        let otherwise = self.lacking(width_px);
        let is_better = otherwise <= f32::min(lacking - BETTER, MOST);
        if self.has_wide || !is_better || self.length_px() < SHORTER * length_px {
            self.trace(image, after);
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
            let stray = line.samples.iter().filter(|sample| !mask.has(sample.at));
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
