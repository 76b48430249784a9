//! Finds a rope along the rays of some of its points, and rejects results that do not belong to it.

use super::floats::{Floats, LANES, Lanes};
use super::places::Places;
use super::{Axis, RopeDepth, STEEPEST, SeenRope, length};
use crate::depth::image::DepthImage;
use crate::depth::pair::DepthCamera;
use lariat_portable::{Simd, WithSimd};

/// Interval, in points, between searches along a whole ray.
const ANCHOR_STEP: usize = 6;
/// Maximum distance, ahead or back, from one section to the next where the rope points at the
/// camera. In radii.
const REACH: f64 = 6.0;
/// Maximum slope of a rope where it points at the camera. The image shows almost nothing of the
/// rope there, between two of its parts. The smaller part must have more than `END_ON_ANCHORS`
/// anchors, or `END_ON_SECTIONS` sections. Otherwise it is treated as something behind or in front
/// of the rope.
const END_ON_STEEPEST: f64 = 16.0;
const END_ON_ANCHORS: usize = 2;
const END_ON_SECTIONS: usize = 4;
/// A single anchor was seen through a hole in the rope's depth if it is too far behind the line
/// between its two neighbors. The limit is this many mm for each mm of lateral distance to the
/// nearer neighbor. The sections next to it find the rope again if the rope itself is that steep.
const BEHIND: f64 = 1.0;
/// Maximum number of sections that are cut off at an end. They are cut off if the mean slope to
/// them would exceed `TIP_STEEPEST`.
const TIP: usize = 3;
const TIP_STEEPEST: f64 = 1.0;

/// Numbers of the steps in a walk along a ray, and a number greater than all of these.
const STEPS: Lanes = [
    0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.0,
];
const NONE: f32 = 1e3;

impl RopeDepth {
    /// Walks some of the rays, and keeps the best chain of results that can be one rope.
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

    /// Drops single anchors that were seen through a hole, where the ray passes the rope.
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

    /// Distance between the rays of two points, in mm per mm of depth.
    fn apart(&self, i: usize, j: usize) -> f64 {
        let [a, b] = [self.sights[i].ray, self.sights[j].ray];
        length(a[0] - b[0], a[1] - b[1])
    }

    /// Marks a section as not measured if the rope cannot reach it from the other sections. An
    /// example is the table beyond an end that the color image puts too far out.
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

    /// Cuts off the last anchors if they are too far from the others for an end.
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

    /// Keeps the best chain of anchors. In a chain, the rope can reach each anchor from the
    /// previous one, within `slack_mm`. The best chain has the most anchors, minus `end_on_cost`
    /// for each place at which the rope points at the camera.
    fn keep_chain(&mut self, slack_mm: f64, end_on_cost: usize) {
        let mut pairs = self.anchors.windows(2);
        if pairs.all(|pair| self.can_follow(pair[0], pair[1], STEEPEST, slack_mm)) {
            return;
        }
        self.chain.clear();
        for k in 0..self.anchors.len() {
            let mut best = (1, usize::MAX);
            for j in (0..k).rev() {
                // A chain up to anchor j has at most j + 1 anchors, so no earlier one is better.
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
        // Marks the anchors of the chain, from its last one back.
        let mut at = (0..self.chain.len()).max_by_key(|&k| self.chain[k].0);
        while let Some(link) = at.and_then(|k| self.chain.get_mut(k)) {
            link.0 = 0;
            at = Some(link.1);
        }
        let mut links = self.chain.iter();
        self.anchors
            .retain(|_| links.next().is_some_and(|link| link.0 == 0));
    }

    /// Returns whether the rope can reach one place from the other, with this slope and slack.
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

    /// Finds the first place along a ray where the measured depth agrees with the ray. Returns the
    /// color camera's depth of the rope's axis.
    fn walk(&self, image: &DepthImage, axis: &Axis) -> Option<f64> {
        let [near, far] = self.camera.range_mm;
        let first = self.camera.pixel(self.place(axis, near))?;
        let last = self.camera.pixel(self.place(axis, far))?;
        let steps = length(first[0] - last[0], first[1] - last[1])
            .ceil()
            .max(1.0);
        let walk = Walk {
            image,
            camera: &self.camera,
            turned: axis.turned,
            nearest: 1.0 / near,
            step: (1.0 / near - 1.0 / far) / steps,
            last: steps as usize,
        };
        let measured = self.arch.dispatch(walk)?;
        Some(self.depth(axis, f64::from(measured)) * (1.0 + axis.slim))
    }
}

/// A walk along a ray, from near to far.
struct Walk<'a> {
    image: &'a DepthImage<'a>,
    camera: &'a DepthCamera,
    /// The ray in the depth camera's frame.
    turned: [f64; 3],
    /// Inverse depth at the start, its decrease per step, 1/mm, and the number of steps.
    nearest: f64,
    step: f64,
    last: usize,
}

impl WithSimd for Walk<'_> {
    type Output = Option<f32>;

    /// Returns the depth measured at the first place where it agrees with the ray.
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Option<f32> {
        let camera = self.camera;
        let (focal, center) = (camera.depth.focal_px(), camera.depth.center_px());
        let ([x, y, z], [right, down, ahead]) = (self.turned, camera.translation);
        let (x, right) = (
            Floats::splat(simd, x as f32),
            Floats::splat(simd, right as f32),
        );
        let (y, down) = (
            Floats::splat(simd, y as f32),
            Floats::splat(simd, down as f32),
        );
        let (z, ahead) = (
            Floats::splat(simd, z as f32),
            Floats::splat(simd, ahead as f32),
        );
        let (zero, step) = (
            Floats::splat(simd, 0.0),
            Floats::splat(simd, self.step as f32),
        );
        let noise = Floats::splat(simd, 3.0 * camera.noise as f32);
        let far = Floats::splat(simd, camera.range_mm[1] as f32);
        let lanes = Floats::of(simd, &STEPS);
        let none = Floats::splat(simd, NONE);
        let places = Places::new(simd, self.image);
        for from in (0..=self.last).step_by(LANES) {
            // The places and the measured depths, multiplied by the inverse depth.
            let begin = self.nearest - from as f64 * self.step;
            let inverse = Floats::splat(simd, begin as f32) - lanes * step;
            let z = z + inverse * ahead;
            let per_z = Floats::splat(simd, 1.0) / z;
            let column = Floats::splat(simd, focal[0] as f32) * (x + inverse * right) * per_z;
            let row = Floats::splat(simd, focal[1] as f32) * (y + inverse * down) * per_z;
            let mut columns = (column + Floats::splat(simd, center[0] as f32)).lanes();
            let mut rows = (row + Floats::splat(simd, center[1] as f32)).lanes();
            camera.distort(&mut columns, &mut rows);
            let columns = Floats::of(simd, &columns).rounded();
            let rows = Floats::of(simd, &rows).rounded();
            let measured = places.read(places.starts(columns, rows));
            let there = measured * inverse;
            // With a single step, the ray is a point in the image, which covers all of its depths.
            let reach = match self.last {
                1 => far * inverse * inverse,
                _ => Floats::splat(simd, 0.75) * step,
            };
            let off = (there - z).abs() * inverse;
            let hit = lanes.where_less(off, reach + noise * there * there, none);
            let hit = hit.where_less(zero, there, none);
            let hit = none.where_less(z, inverse, hit).least() as usize;
            if hit <= (self.last - from).min(LANES - 1) {
                return Some(measured.lanes()[hit]);
            }
        }
        None
    }
}
