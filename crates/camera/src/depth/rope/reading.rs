//! What a depth image says of a rope's axis, section by section.
//!
//! A section is the stretch of the rope around every second of its points. Its inner width is read at places of a fixed pattern.

use super::look::{Found, Look};
use super::{Axis, DepthImage, RopeDepth, STEEPEST, SeenRope, between, cross, dot, length, pixel};

/// Of a rope's half width, how much is read; and an edge's pixels, which see both sides of it, px.
const INNER: f64 = 0.8;
const EDGE_PX: f64 = 0.8;
/// Where no more than this is left to each side of the axis, px, pixels are told one by one whether they lie on the rope: by how far they
/// reach to its side, as they lie to it, and by how far its axis may be off.
const NARROW_PX: f64 = 0.5;
const AXIS_OFF_PX: f64 = 0.1;
/// Where less than this is left, next to no pixel lies on the rope as a whole: it is not read.
const LEAST_PX: f64 = 0.1;
/// Points between sections: those between have the depth of their neighbors' curve.
pub(super) const SECTION_STEP: usize = 2;
/// A section is no longer than this to each side of its point, in the rope's half widths: as far as it is straight.
const LONGEST: f64 = 1.5;
/// How closely a depth image is looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Reading {
    /// A few pixels at each section, wherever they are within reach.
    Glance,
    /// All of the rope's inside.
    Whole,
}

/// A section of a rope in the depth image.
pub(super) struct Section {
    /// Where its point is, and how far ahead of the depth camera.
    pub(super) at: [f64; 2],
    pub(super) ahead: f64,
    /// The way along the rope, of length 1; and how much farther ahead it is for each pixel along, and its side for each beside.
    pub(super) along: [f64; 2],
    pub(super) slope: f64,
    pub(super) tilt: f64,
    /// From where to where along it, and how far beside, it is read, px.
    pub(super) ends: [f64; 2],
    pub(super) inner: f64,
    pub(super) mm_per_px: f64,
    /// How far beside its axis a ray passes for each pixel beside.
    pub(super) beside_per_px: f64,
    /// The rope's, mm.
    pub(super) radius: f64,
    /// How far beside the axis a ray gets, for each millimetre ahead.
    pub(super) sine: f64,
    /// The standard deviation of a pixel, mm.
    pub(super) sigma: f64,
}

impl RopeDepth {
    /// Divides a rope of so many points into sections: around every second point, and the last.
    pub(super) fn divide(&mut self) {
        let last = self.axes.len() - 1;
        self.sections.clear();
        self.sections.extend((0..last).step_by(SECTION_STEP));
        self.sections.push(last);
    }

    /// Reads the depth image at each section, where it is known roughly.
    pub(super) fn read(&mut self, image: &DepthImage, rope: &SeenRope, reading: Reading) {
        for k in 0..self.sections.len() {
            self.set_out(k);
        }
        for k in 0..self.sections.len() {
            self.read_section(image, rope, k, reading);
        }
    }

    /// Reads those where nothing was found again, from where the rope goes on to from those beside them.
    pub(super) fn read_again(&mut self, image: &DepthImage, rope: &SeenRope) {
        let count = self.sections.len();
        for k in 2..count {
            self.go_on(image, rope, [k - 2, k - 1, k, (k + 1).min(count - 1)]);
        }
        for k in (0..count.saturating_sub(2)).rev() {
            self.go_on(image, rope, [k + 2, k + 1, k, k.saturating_sub(1)]);
        }
    }

    /// Reads the third of four sections that go on from each other, if the first two are known and it is not.
    fn go_on(&mut self, image: &DepthImage, rope: &SeenRope, four: [usize; 4]) {
        let [first, second, third, fourth] = four.map(|k| self.sections[k]);
        let [is_first, is_second, is_third, is_fourth] =
            [first, second, third, fourth].map(|i| self.axes[i].is_measured);
        if !is_first || !is_second || is_third || rope.hidden[third] {
            return;
        }
        let depth = self.axes[second].depth;
        let step = depth - self.axes[first].depth;
        self.axes[third].depth = depth + step;
        self.set_out(four[2]);
        if fourth != third && !is_fourth {
            self.axes[fourth].depth = depth + 2.0 * step;
            self.set_out(four[3]);
        }
        self.read_section(image, rope, four[2], Reading::Whole);
    }

    /// Where the `k`-th section's point is, as its depth is.
    fn set_out(&mut self, k: usize) {
        let i = self.sections[k];
        let place = self.place(&self.axes[i], self.axes[i].depth);
        let axis = &mut self.axes[i];
        axis.place = place;
        // Outside of its image nothing is read.
        axis.at = self.camera.pixel(place).unwrap_or([-1e6; 2]);
    }

    fn read_section(&mut self, image: &DepthImage, rope: &SeenRope, k: usize, reading: Reading) {
        let i = self.sections[k];
        let section = match rope.hidden[i] {
            true => None,
            false => self.section(image, rope, k),
        };
        let found = section.and_then(|section| match reading {
            Reading::Glance => section.glance(image),
            Reading::Whole => self.arch.dispatch(Look { image, section }),
        });
        let axis = &mut self.axes[i];
        axis.is_measured = found.is_some();
        if let Some(found) = found {
            let turned = axis.turned[2];
            axis.depth = (found.ahead - self.camera.translation[2]) / turned;
            axis.variance = found.variance / (turned * turned);
            axis.beside = found.beside;
        }
    }

    /// The `k`-th section; `None` where it goes nowhere in the depth image, or is too thin there.
    fn section(&self, image: &DepthImage, rope: &SeenRope, k: usize) -> Option<Section> {
        let (count, i) = (self.sections.len(), self.sections[k]);
        let [before, after] = match rope.closed {
            true => [(k + count - 1) % count, (k + 1) % count],
            false => [k.saturating_sub(1), (k + 1).min(count - 1)],
        };
        let [a, b] = [before, after].map(|k| &self.axes[self.sections[k]]);
        let axis = &self.axes[i];
        let way = [b.at[0] - a.at[0], b.at[1] - a.at[1]];
        let far = length(way[0], way[1]);
        if !(far > 1e-3 && far < 1e3) {
            return None;
        }
        let per_far = 1.0 / far;
        let along = way.map(|c| c * per_far);
        let ahead = axis.place[2];
        let mm_per_px = ahead / self.focal_px;
        let radius = axis.slim * axis.depth;
        let half = radius / mm_per_px;
        let mut inner = (INNER * half).min(half - EDGE_PX);
        if inner < NARROW_PX {
            let reach = 0.5 * (along[0].abs() + along[1].abs());
            inner = (half - reach - AXIS_OFF_PX).min(NARROW_PX);
        }
        if inner < LEAST_PX {
            return None;
        }
        let points = rope.hidden.len();
        let reach = |of: &Axis, point: usize| {
            let step = 0.5 * length(of.at[0] - axis.at[0], of.at[1] - axis.at[1]);
            let seen = if rope.hidden[point % points] {
                0.5
            } else {
                1.0
            };
            (seen * step).min(LONGEST * half)
        };
        let ends = match (rope.closed, k) {
            // At a tip only the rope's side is read.
            (false, 0) => [0.5, reach(b, 1) + 1.0],
            (false, _) if k + 1 == count => [-reach(a, i - 1) - 1.0, -0.5],
            _ => [-reach(a, i + points - 1), reach(b, i + 1)],
        };
        // The ray, the rope, and what is square to both; then square to that and the rope.
        let per_ahead = 1.0 / ahead;
        let ray = axis.place.map(|c| c * per_ahead);
        let rope_way = between(b.place, a.place);
        let per_size = 1.0 / dot(rope_way, rope_way).sqrt();
        let rope_way = rope_way.map(|c| c * per_size);
        let normal = cross(ray, rope_way);
        let sine = dot(normal, normal).sqrt();
        let per_sine = 1.0 / sine;
        let normal = normal.map(|c| c * per_sine);
        let up = cross(rope_way, normal);
        let beside = [-along[1], along[0], 0.0];
        Some(Section {
            at: axis.at,
            ahead,
            along,
            slope: (b.place[2] - a.place[2]) * per_far,
            tilt: -mm_per_px * dot(beside, up) * per_sine,
            ends,
            inner,
            mm_per_px,
            beside_per_px: mm_per_px * dot(beside, normal),
            radius,
            sine,
            sigma: length(self.camera.sigma_mm(ahead), image.rounding_mm()),
        })
    }
}

impl Section {
    /// How far beside the axis and along it a pixel of the depth image is, px.
    fn beside(&self, pixel: [isize; 2]) -> [f64; 2] {
        let [x, y] = [0, 1].map(|k| pixel[k] as f64 - self.at[k]);
        let [along_x, along_y] = self.along;
        [y * along_x - x * along_y, x * along_x + y * along_y]
    }

    /// How far ahead the axis is by the median of three pixels across.
    fn glance(&self, image: &DepthImage) -> Option<Found> {
        let [first, last] = self.ends;
        let reach = STEEPEST * 0.75 * (last - first) * self.mm_per_px;
        let gate = 6.0 * self.radius + 5.0 * self.sigma + reach;
        let on = 0.5 * (first + last);
        let (mut read, mut count) = ([0.0; 3], 0);
        for off in [-1.0, 0.0, 1.0] {
            let [x, y] = self.along;
            let pixel = [
                pixel(self.at[0] + on * x - off * y),
                pixel(self.at[1] + on * y + off * x),
            ];
            let [off, on] = self.beside(pixel);
            let Some(measured) = image.at(pixel[0], pixel[1]) else {
                continue;
            };
            let inside = self.radius * self.radius - (off * self.beside_per_px).powi(2);
            let rise = inside.max(0.0).sqrt() / self.sine;
            let ahead = measured + rise - self.slope * on - self.tilt * off;
            if off.abs() <= self.inner && (ahead - self.ahead).abs() < gate {
                read[count] = ahead;
                count += 1;
            }
        }
        let read = &mut read[..count];
        read.sort_unstable_by(f64::total_cmp);
        read.get(count / 2).map(|&ahead| Found {
            ahead,
            variance: 0.0,
            beside: 0.0,
        })
    }
}
