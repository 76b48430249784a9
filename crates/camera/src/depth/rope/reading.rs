//! Reads a rope's axis from a depth image, section by section.
//!
//! A section is the part of the rope around every second of its points. Its inner width is read at
//! a fixed pattern of places.

use super::floats::LANES;
use super::glance::Glance;
use super::inside::{Found, InsideSampler};
use super::sections::{Outline, Sections};
use super::{DepthImage, RopeDepth, SeenRope};
use std::ops::Range;

/// Interval between sections, in points. Points in between get their depth from the curve through
/// their neighbors.
pub(super) const SECTION_STEP: usize = 2;

/// How thoroughly to read a depth image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sampling {
    /// Reads a few pixels of each section. They count at any depth within reach.
    Glance,
    /// Reads the whole inside of the rope.
    Whole,
}

impl RopeDepth {
    /// Divides a rope into sections: around every second point, and around the last.
    pub(super) fn divide(&mut self, rope: &SeenRope) {
        let last = self.axes.len() - 1;
        self.sections.clear();
        self.sections.extend((0..last).step_by(SECTION_STEP));
        self.sections.push(last);
        self.course.begin(self.sections.len(), rope.closed);
        // Next to a hidden point, the cover may extend further.
        let share = |hidden: bool| if hidden { 0.25 } else { 0.5 };
        for (k, &i) in self.sections.iter().enumerate() {
            let before = if i == 0 { last } else { i - 1 };
            let after = if i == last { 0 } else { i + 1 };
            let shares = [before, after].map(|i| share(rope.hidden[i]));
            self.course.share(k, shares);
        }
    }

    /// Reads the depth image at each section, whose depth is roughly known.
    pub(super) fn read(&mut self, image: &DepthImage, rope: &SeenRope, reading: Sampling) {
        let count = self.sections.len();
        for k in 0..count {
            self.set_out(rope, k);
        }
        for first in (0..count).step_by(LANES) {
            self.read_sections(image, rope, first..(first + LANES).min(count), reading);
        }
    }

    /// Reads sections without a result again, at the depth that their neighbors extrapolate to.
    pub(super) fn read_again(&mut self, image: &DepthImage, rope: &SeenRope) {
        let count = self.sections.len();
        for k in 2..count {
            self.go_on(image, rope, [k - 2, k - 1, k, (k + 1).min(count - 1)]);
        }
        for k in (0..count.saturating_sub(2)).rev() {
            self.go_on(image, rope, [k + 2, k + 1, k, k.saturating_sub(1)]);
        }
    }

    /// Reads the third of four consecutive sections, if the first two are measured and the third is
    /// not.
    fn go_on(&mut self, image: &DepthImage, rope: &SeenRope, four: [usize; 4]) {
        let third = self.sections[four[2]];
        if self.axes[third].is_measured || rope.hidden[third] {
            return;
        }
        let [first, second, fourth] = [four[0], four[1], four[3]].map(|k| self.sections[k]);
        let [is_first, is_second, is_fourth] =
            [first, second, fourth].map(|i| self.axes[i].is_measured);
        if !is_first || !is_second {
            return;
        }
        let depth = self.axes[second].depth;
        let step = depth - self.axes[first].depth;
        self.axes[third].depth = depth + step;
        self.set_out(rope, four[2]);
        if fourth != third && !is_fourth {
            self.axes[fourth].depth = depth + 2.0 * step;
            self.set_out(rope, four[3]);
        }
        self.read_sections(image, rope, four[2]..four[2] + 1, Sampling::Whole);
    }

    /// Places the `k`-th section at its depth.
    fn set_out(&mut self, rope: &SeenRope, k: usize) {
        let i = self.sections[k];
        let axis = &self.axes[i];
        let place = self.place(axis, axis.depth);
        // Nothing is read outside of the image.
        let at = self.camera.pixel(place).unwrap_or([-1e6; 2]);
        let radius = if rope.hidden[i] {
            0.0
        } else {
            axis.slim * axis.depth
        };
        self.course.set_out(k, at, place, radius);
    }

    /// Reads up to `LANES` sections.
    fn read_sections(
        &mut self,
        image: &DepthImage,
        rope: &SeenRope,
        which: Range<usize>,
        reading: Sampling,
    ) {
        let sections = &self.lay_out(image, rope, which.clone());
        let found = match reading {
            Sampling::Glance => self.arch.dispatch(Glance { image, sections }),
            Sampling::Whole => self.arch.dispatch(InsideSampler {
                image,
                sections,
                pixels: &mut self.pixels,
            }),
        };
        for (k, found) in which.zip(found) {
            self.take_in(k, found);
        }
    }

    fn take_in(&mut self, k: usize, found: Option<Found>) {
        let axis = &mut self.axes[self.sections[k]];
        axis.is_measured = found.is_some();
        if let Some(found) = found {
            let turned = axis.turned[2];
            axis.depth = (found.ahead - self.camera.translation[2]) / turned;
            axis.variance = found.variance / (turned * turned);
            axis.beside = found.beside;
        }
    }

    /// Determines how to read some sections.
    fn lay_out(&self, image: &DepthImage, rope: &SeenRope, which: Range<usize>) -> Sections {
        let (first, last) = (which.start, which.end - 1);
        let mut sections = self.arch.dispatch(Outline {
            course: &self.course,
            which,
            focal_px: self.focal_px as f32,
            noise: self.camera.noise as f32,
            rounding_mm: image.rounding_mm() as f32,
        });
        // At a tip, only the side toward the rope is read.
        if !rope.closed && first == 0 {
            sections.ends[0][0] = 0.5;
            sections.ends[1][0] += 1.0;
        }
        if !rope.closed && last + 1 == self.sections.len() {
            let lane = last - first;
            sections.ends[0][lane] -= 1.0;
            sections.ends[1][lane] = -0.5;
        }
        sections
    }
}
