//! Where a rope is first found, along the rays of some of its points; and what of all that was found is not the rope.

use super::SeenRope;
use super::{Axis, RopeDepth, STEEPEST, length, pixel};
use crate::depth::image::DepthImage;

/// Points between those at which a rope is looked for along the whole ray.
const ANCHOR_STEP: usize = 6;
/// How far ahead of one section, or behind it, the next may be where the rope points at the camera, in radii.
const REACH: f64 = 6.0;
/// How steep a rope may be where it points at the camera, so that next to nothing is seen of the way from one part of it to the next; and how
/// many anchors, or sections, the smaller of the two parts has more than, not to be taken for something else behind or before the rope.
const END_ON_STEEPEST: f64 = 16.0;
const END_ON_ANCHORS: usize = 2;
const END_ON_SECTIONS: usize = 4;
/// One anchor alone is what is behind a hole in the rope's depth if it is farther ahead than the line from the one before to the one after by more
/// than this for each millimetre aside of the nearer of these. Where a rope is as steep, the sections beside it find it again.
const BEHIND: f64 = 1.0;
/// So few sections at an end are the rope only where it rises no more steeply to them, on average, than this.
const TIP: usize = 3;
const TIP_STEEPEST: f64 = 1.0;

impl RopeDepth {
    /// Walks some of the rays, and keeps the best chain of what is found that a rope can be.
    pub(super) fn find(&mut self, image: &DepthImage, rope: &SeenRope) {
        self.anchors.clear();
        for i in (ANCHOR_STEP / 2..self.axes.len()).step_by(ANCHOR_STEP) {
            if !rope.hidden[i]
                && let Some(depth) = self.walk(image, &self.axes[i])
            {
                self.anchors.push((i, depth));
            }
        }
        self.keep_chain(0.0, END_ON_ANCHORS);
        self.drop_behind();
    }

    /// Leaves out single anchors that are what is seen through a hole: where a ray goes on beside the rope.
    fn drop_behind(&mut self) {
        let mut k = 1;
        while k + 1 < self.anchors.len() {
            let [(i, a), (j, b), (l, c)] = [k - 1, k, k + 1].map(|k| self.anchors[k]);
            let between = a + (j - i) as f64 / (l - i) as f64 * (c - a);
            let aside = self.apart(i, j).min(self.apart(j, l)) * between;
            match b - between > BEHIND * aside + 6.0 * self.camera.sigma_mm(b) {
                true => drop(self.anchors.remove(k)),
                false => k += 1,
            }
        }
    }

    /// How far a point's ray is aside of another's, for each millimetre ahead.
    fn apart(&self, i: usize, j: usize) -> f64 {
        let [a, b] = [i, j].map(|k| self.axes[k].ray);
        length(a[0] - b[0], a[1] - b[1])
    }

    /// Takes for not measured whatever the rope does not go on to from the others: the table beyond an end that the colour
    /// image has too far out.
    pub(super) fn drop_strays(&mut self, closed: bool) {
        self.anchors.clear();
        let (mut radius, sections) = (0.0f64, self.sections.iter());
        for (i, axis) in sections.map(|&i| (i, &self.axes[i])) {
            if axis.is_measured {
                self.anchors.push((i, axis.depth));
                radius = radius.max(axis.slim * axis.depth);
            }
        }
        let found = self.anchors.len();
        let slack_mm = REACH * radius;
        self.keep_chain(slack_mm, END_ON_SECTIONS);
        if !closed {
            for _ in 0..2 {
                self.cut_tip(slack_mm);
                self.anchors.reverse();
            }
        }
        if self.anchors.len() == found {
            return;
        }
        let mut kept = self.anchors.iter().peekable();
        for &i in &self.sections {
            self.axes[i].is_measured = kept.next_if(|&&(at, _)| at == i).is_some();
        }
    }

    /// Cuts off the last anchors where they are farther from the others than an end is.
    fn cut_tip(&mut self, slack_mm: f64) {
        let count = self.anchors.len();
        let tip = count.saturating_sub(TIP).max(1)..count;
        let is_off = |&k: &usize| {
            let [a, b] = [self.anchors[k - 1], self.anchors[k]];
            !self.can_follow(a, b, TIP_STEEPEST, slack_mm)
        };
        let off = tip.into_iter().find(is_off);
        self.anchors.truncate(off.unwrap_or(count));
    }

    /// Keeps the best chain of anchors in which the rope can rise from each to the next, give or take so many millimetres: the longest,
    /// where each place at which it points at the camera costs so many anchors.
    fn keep_chain(&mut self, slack_mm: f64, end_on_cost: usize) {
        self.chain.clear();
        for k in 0..self.anchors.len() {
            let mut best = (1, usize::MAX);
            for j in (0..k).rev() {
                // Up to one there are no more than there are.
                if j + 2 <= best.0 {
                    break;
                }
                let [a, b] = [self.anchors[j], self.anchors[k]];
                let through = self.chain[j].0 + 1;
                let end_on = through.saturating_sub(end_on_cost);
                if through > best.0 && self.can_follow(a, b, STEEPEST, slack_mm) {
                    best = (through, j);
                } else if end_on > best.0 && self.can_follow(a, b, END_ON_STEEPEST, slack_mm) {
                    best = (end_on, j);
                }
            }
            self.chain.push(best);
        }
        // From its last one back each that is in it is marked.
        let mut at = (0..self.chain.len()).max_by_key(|&k| self.chain[k].0);
        while let Some(link) = at.and_then(|k| self.chain.get_mut(k)) {
            link.0 = 0;
            at = Some(link.1);
        }
        let mut links = self.chain.iter();
        self.anchors
            .retain(|_| links.next().is_some_and(|link| link.0 == 0));
    }

    /// Whether the rope can rise from one place to the other, that steeply and give or take so much.
    fn can_follow(
        &self,
        (i, a): (usize, f64),
        (j, b): (usize, f64),
        steepest: f64,
        slack_mm: f64,
    ) -> bool {
        let aside = self.apart(i, j) * a.min(b);
        (a - b).abs() < steepest * aside + 6.0 * self.camera.sigma_mm(a.max(b)) + slack_mm
    }

    /// The first place along a ray where what is measured is where the ray is: the colour camera's depth of the rope's axis.
    fn walk(&self, image: &DepthImage, axis: &Axis) -> Option<f64> {
        let [near, far] = self.camera.range_mm;
        let ends = [near, far].map(|depth| self.camera.pixel(self.place(axis, depth)));
        let [Some(first), Some(last)] = ends else {
            return None;
        };
        let steps = length(first[0] - last[0], first[1] - last[1])
            .ceil()
            .max(1.0);
        let nearest = 1.0 / near;
        let step = (nearest - 1.0 / far) / steps;
        for k in 0..=steps as usize {
            // The place and what is measured there, times the inverse depth.
            let inverse = nearest - k as f64 * step;
            let place = [0, 1, 2].map(|k| axis.turned[k] + inverse * self.camera.translation[k]);
            if place[2] < inverse {
                continue;
            }
            let Some([x, y]) = self.camera.pixel_along(place) else {
                continue;
            };
            let Some(measured) = image.at(pixel(x), pixel(y)) else {
                continue;
            };
            // Of one step a ray looks along all its depths where it is a point in the image.
            let reach = match steps as usize {
                1 => far * inverse * inverse,
                _ => 0.75 * step,
            };
            let there = measured * inverse;
            let off = (there - place[2]).abs() * inverse;
            if off < reach + 3.0 * self.camera.sigma_mm(there) {
                let depth = self.depth(axis, measured);
                return Some(depth * (1.0 + axis.slim));
            }
        }
        None
    }
}
