//! Strands of a mask that was cut at its seams: joins the fragments of those that pass under
//! others.

use super::{Bridger, Candidate};
use crate::bitmap::bits::BitPlane;
use crate::centerline::line::{Line, Sample};
use crate::graph::bending::{bending, cubic};
use crate::image::color;
use crate::occlusion::ends::{End, Scenery};
use crate::occlusion::way::share;
use crate::vec2;

/// Look-ahead distance past an end, in widths. If the mask is empty there, the rope ends.
const AHEAD: f32 = 0.56;
/// Length cut off an end that runs under another strand, where the line bends: in widths, and the
/// maximum share of the line.
const TRIMMED: (f32, f32) = (0.4, 0.33);
/// Maximum gap under other strands, in widths.
const WIDEST: f32 = 7.9;
/// Maximum bending in such a gap (a turn by 145°).
const MOST_BENT: f32 = 1.6;
/// Minimum share of the way in the gap that must be in the mask.
const WITHIN: f32 = 0.7;
/// Gap that costs as much as a turn by 57°, in widths.
const FAR: f32 = 3.4;
/// Bending energy of a turn by 57°, the unit of the cost.
const TURNED: f32 = 0.25;
/// Length added to a rope that ends under a strand, in widths: what was cut off, and the way to the
/// middle of the strand.
const HIDDEN: f32 = 0.8;

impl Bridger {
    /// Joins those of `lines` that pass under others. `colors` are the lines' mean colors, `mask`
    /// is the whole mask, and `width_px` is the ropes' width. Returns the number of lines left,
    /// sorted by length.
    ///
    /// A pair of ends costs its bending in units of `TURNED`, plus its gap in units of `FAR`. The
    /// cheapest pairs are joined first. An end that is joined to nothing is extended, as it ends
    /// under the strand.
    pub(crate) fn join_under(
        &mut self,
        lines: &mut [Line],
        colors: &mut [[f32; 3]],
        scenery: &Scenery,
        (mask, width_px): (&BitPlane, f32),
    ) -> usize {
        self.gaps.clear();
        for line in lines.iter_mut().filter(|line| !line.closed) {
            for last in [false, true] {
                trim(line, last, width_px, mask);
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
            // Earlier joins may have made them one line.
            if a != b {
                self.bridge(&candidate, lines, scenery);
            }
        }
        for end in self.ends.iter().filter(|end| !end.used && !end.leaves) {
            let line = &mut lines[end.line];
            if mask.has(line.ahead(end.last, AHEAD * width_px)) {
                extend(line, end, HIDDEN * width_px);
            }
        }
        self.sort(lines, colors)
    }
}

/// Extends a line straight ahead at one of its ends.
fn extend(line: &mut Line, end: &End, by_px: f32) {
    let count = line.samples.len();
    let step_px = (line.length_px() / (count - 1) as f32).max(0.3);
    let more = (by_px / step_px) as usize;
    let from = line.samples[if end.last { count - 1 } else { 0 }];
    let beyond = |k: usize| Sample {
        at: vec2::along(end.at, end.out, by_px * k as f32 / more as f32),
        ..from
    };
    match end.last {
        true => line.samples.extend((1..=more).map(beyond)),
        false => drop(line.samples.splice(..0, (1..=more).rev().map(beyond))),
    }
}

/// Cuts a line back at an end, if the mask continues there.
fn trim(line: &mut Line, last: bool, width_px: f32, mask: &BitPlane) {
    let count = line.samples.len();
    if count < 2 || !mask.has(line.ahead(last, AHEAD * width_px)) {
        return;
    }
    let step_px = (line.length_px() / (count - 1) as f32).max(0.1);
    let off = ((TRIMMED.0 * width_px / step_px) as usize).min((TRIMMED.1 * count as f32) as usize);
    match last {
        true => line.samples.truncate(count - off),
        false => drop(line.samples.drain(..off)),
    }
}
