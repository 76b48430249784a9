//! Strands that were parted by their seams: those that pass under others are in pieces, which are joined again.

use super::{Bridger, Candidate};
use crate::bitmap::bits::BitPlane;
use crate::centerline::line::{Line, Sample};
use crate::graph::pairing::bending;
use crate::image::color;
use crate::occlusion::ends::{End, Scenery};
use crate::occlusion::way::{cubic, share};
use crate::vec2::{self, Vec2};

/// How far ahead of an end, in widths, the mask is looked at: where it has nothing, the rope ends there.
const AHEAD: f32 = 0.56;
/// A line bends where it runs under another strand: so much of its end is cut off, in widths, and at most this share of the line.
const FRAYED: (f32, f32) = (0.4, 0.33);
/// The widest gap, in widths, under strands that run along; and the most bending in it (a turn by 145°).
const WIDEST: f32 = 7.9;
const MOST_BENT: f32 = 1.6;
/// The share of the way between that must lie within the mask.
const WITHIN: f32 = 0.7;
/// The gap that costs as much as a turn by 57°, in widths.
const FAR: f32 = 3.4;
const TURNED: f32 = 0.25;

/// How far behind an end, in widths, a tip may show on the other side of what the rope runs under, and how far aside of the way the end
/// points, by the cosine. It shows from so many squares of the width on, so far aside of its middle.
const BEHIND: f32 = 4.0;
const ASIDE: f32 = 0.7;
const TIP: (f32, f32) = (0.15, 0.6);
/// Where none shows, so many widths of the rope are taken to be hidden: from the seam to beyond the middle of a strand.
const HIDDEN: f32 = 1.2;

impl Bridger {
    /// Joins those of `lines`, of these mean colors, that pass under others in `mask`, the whole of it, whose ropes are so wide. The
    /// straightest and nearest first. Lines that were taken into others are empty then.
    pub(crate) fn join_under(
        &mut self,
        lines: &mut [Line],
        colors: &mut [[f32; 3]],
        scenery: &Scenery,
        (mask, width_px): (&BitPlane, f32),
    ) {
        self.gaps.clear();
        for line in lines.iter_mut().filter(|line| !line.closed) {
            for last in [false, true] {
                fray(line, last, width_px, mask);
            }
        }
        self.list_ends(lines, colors, scenery);
        self.candidates.clear();
        for (i, a) in self.ends.iter().enumerate() {
            for (j, b) in self.ends.iter().enumerate().skip(i + 1) {
                let chord_px = vec2::distance(a.at, b.at);
                let is_like = color::distance(a.color, b.color, scenery.yuv) <= scenery.alike().0;
                let are_free = a.line != b.line && !a.leaves && !b.leaves;
                if !are_free || !is_like || chord_px > WIDEST * width_px {
                    continue;
                }
                let bend = bending(a.at, a.out, b.at, vec2::scale(b.out, -1.0));
                let way = cubic([a.at, a.out], [b.at, b.out]);
                if bend <= MOST_BENT && share(way, |at| mask.has(at)) >= WITHIN {
                    self.candidates.push(Candidate {
                        cost: bend / TURNED + chord_px / (FAR * width_px),
                        ends: [i, j],
                        way: None,
                    });
                }
            }
        }
        self.keep_cheapest();
        for i in 0..self.candidates.len() {
            let candidate = self.candidates[i];
            let [a, b] = candidate.ends.map(|end| self.ends[end].line);
            // Others may have made them one line's.
            if a != b {
                self.bridge(&candidate, lines, scenery);
            }
        }
    }

    /// Runs on those ends of the lines that were [joined under others](Self::join_under) to which nothing was joined: through the strand
    /// that they lie at, to where `left`, what no line runs through, shows the tip of the rope behind it, or no tip, into it. Returns
    /// how many lines are left, sorted by length.
    pub(crate) fn run_on(
        &mut self,
        lines: &mut [Line],
        colors: &mut [[f32; 3]],
        (mask, width_px): (&BitPlane, f32),
        left: &BitPlane,
    ) -> usize {
        for end in self.ends.iter().filter(|end| !end.used && !end.leaves) {
            let line = &mut lines[end.line];
            let ends_within = |line: &Line| mask.has(line.ahead(end.last, AHEAD * width_px));
            if line.samples.len() >= 2 && !line.closed && ends_within(line) {
                let tip = tip_behind(end, width_px, mask, left);
                let into = vec2::along(end.at, end.out, HIDDEN * width_px);
                lay_on(line, end.last, tip.unwrap_or(into));
            }
        }
        self.sort(lines, colors)
    }
}

/// Where the rope ends on the other side of a strand that it runs under.
fn tip_behind(end: &End, width_px: f32, mask: &BitPlane, left: &BitPlane) -> Option<Vec2> {
    let reach_px = BEHIND * width_px;
    let [columns, rows] =
        [0, 1].map(|c| (end.at[c] - reach_px) as i32..=(end.at[c] + reach_px) as i32);
    let pixels = || {
        let all = (rows.clone()).flat_map(|y| columns.clone().map(move |x| (x, y)));
        let ways = all.filter(|&(x, y)| left.get(x, y));
        let ways = ways.map(|(x, y)| vec2::sub([x as f32, y as f32], end.at));
        ways.filter(|&way| {
            let off_px = vec2::norm(way);
            off_px < reach_px && vec2::dot(way, end.out) > ASIDE * off_px
        })
    };
    let sum = pixels().fold([0.0; 2], vec2::add);
    let out = vec2::unit_or(sum, end.out);
    let is_ahead = |&way: &Vec2| vec2::cross(way, out).abs() < TIP.1 * width_px;
    let far = pixels().filter(is_ahead).map(|way| vec2::dot(way, out));
    let far_px = far.fold(0.0, f32::max);
    let is_tip = pixels().count() as f32 >= TIP.0 * width_px * width_px;
    let is_within = |k: usize| mask.has(vec2::along(end.at, out, far_px * k as f32 / 8.0));
    (is_tip && far_px > 0.0 && (0..8).all(is_within)).then(|| vec2::along(end.at, out, far_px))
}

/// Lays a line of two samples or more on from one of its ends, straight to a place.
fn lay_on(line: &mut Line, last: bool, to: Vec2) {
    let count = line.samples.len();
    let step_px = (line.length_px() / (count - 1) as f32).max(0.3);
    if !last {
        line.samples.reverse();
    }
    let from = line.samples[count - 1];
    let way = vec2::sub(to, from.at);
    let more = (vec2::norm(way) / step_px) as usize;
    line.samples.extend((1..=more).map(|k| Sample {
        at: vec2::along(from.at, way, k as f32 / more as f32),
        ..from
    }));
    if !last {
        line.samples.reverse();
    }
}

/// Cuts a line back at an end before which the mask goes on.
fn fray(line: &mut Line, last: bool, width_px: f32, mask: &BitPlane) {
    let count = line.samples.len();
    if count < 2 || !mask.has(line.ahead(last, AHEAD * width_px)) {
        return;
    }
    let step_px = (line.length_px() / (count - 1) as f32).max(0.1);
    let off = ((FRAYED.0 * width_px / step_px) as usize).min((FRAYED.1 * count as f32) as usize);
    match last {
        true => line.samples.truncate(count - off),
        false => drop(line.samples.drain(..off)),
    }
}
