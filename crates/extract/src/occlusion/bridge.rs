//! Joins the fragments of a rope across whatever hides the rest of it: a gripper, a hand, or any
//! other occluder.
//!
//! Candidates are pairs of ends. There are three kinds, in the order of their cost:
//!
//! - consecutive fragments of a rope of the prior, if an occluder covers the way between them or
//!   the rope leaves the image there: `NEIGHBORS.1`;
//! - ends between which a rope of the prior ran: `known_way`. Consecutive fragments whose way is
//!   not covered cost `NEIGHBORS.0`;
//! - ends that the prior leaves open, if they face each other so straight and so near that chance
//!   is unlikely: `plain_cost`, which is 100 or more.
//!
//! `known_way` and `plain_cost` also require similar color and width.
//!
//! The cheapest candidate wins its two ends, then the next one. Two rules then overrule this
//! result: `reassign` exchanges ways, and `split` drops ways over the bare table. Finally,
//! `join_pairs` joins remaining ends at a common occluder.
//!
//! The hidden way is that of the prior, moved along with the two ends. Without a prior, it is the
//! cubic that leaves both ends in their own directions. For small turns, this is the way of least
//! bending.

mod reassign;
#[cfg(test)]
mod tests;
mod under;

use super::ends::{End, Scenery, is_stretched, known_way, plain_cost, shown};
use super::pieces::{self, Fragment};
use super::way;
use crate::centerline::line::{Line, MOST_PIECES, Sample};
use crate::graph::bending::bending;
use crate::image::color;
use crate::past::{FormerPlace, Move, Rope};
use crate::vec2::{self, Vec2};

/// A hidden stretch of a joined line, as arc length from the line's first sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Gap {
    pub(crate) line: usize,
    pub(crate) from_px: f32,
    pub(crate) to_px: f32,
}

/// Maximum distance between two lines of one rope that run past each other, in widths.
const BESIDE: f32 = 0.75;
/// Maximum share of either line that runs along the other one.
const DOUBLED: f32 = 0.7;
/// Maximum cosine between the directions in which they end, which must be opposed.
const OPPOSED: f32 = -0.7;
/// Length cut off each line, from the middle of the doubled part, in widths.
const BACK: f32 = 2.0;

/// Cost of joining consecutive fragments of a known rope, if nothing covers the way between them,
/// and if an occluder does. The first cost is above that of any `known_way` and below that of any
/// join without a prior. The second cost is the lowest of all, because ends under a hand may point
/// along any strand.
const NEIGHBORS: (f32, f32) = (50.0, -1.0);
/// Minimum share of a way that must be under an occluder for it to be covered.
const COVERED: f32 = 0.75;

/// Maximum distance from an end to the occluder that it runs into, in widths, and number of places
/// sampled up to there.
const INTO: (f32, usize) = (1.5, 6);

/// Minimum gap, in widths, at which a known rope can be found to be two. Maximum share of the way
/// across it, straight and along the prior, that may show anything but the bare table.
const SPLIT: (f32, f32) = (3.0, 0.5);
/// Minimum length of such a rope, if it were joined by a straight line, relative to its usual
/// length.
const TOO_LONG: f32 = 1.02;

/// For several ends at one occluder: maximum bending between two that are joined (a turn by 99°),
/// and minimum ratio of the next larger bending to it.
const BENT: (f32, f32) = (0.75, 2.0);

/// Two ends that may be joined.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    cost: f32,
    ends: [usize; 2],
    /// Places of both ends on a rope of the prior.
    way: Option<[FormerPlace; 2]>,
}

/// Buffers and result of the step.
#[derive(Debug, Default)]
pub(crate) struct Bridger {
    ends: Vec<End>,
    candidates: Vec<Candidate>,
    pieces: Vec<Fragment>,
    /// Movement of the prior's ropes, where fragments of them are visible: rope by rope, in order
    /// along each.
    pub(crate) moves: Vec<Move>,
    pub(crate) gaps: Vec<Gap>,
    /// True if the prior's hidden ways were found to be wrong. The refit is then skipped.
    pub(crate) is_reassigned: bool,
    /// True if a rope of the prior was found to be several.
    pub(crate) is_split: bool,
    spaced: Vec<Sample>,
}

impl Bridger {
    /// Allocates buffers for lines of up to `samples` samples.
    pub(crate) fn reserve(&mut self, samples: usize) {
        self.ends.reserve(256);
        self.candidates.reserve(256);
        self.pieces.reserve(MOST_PIECES);
        self.moves.reserve(16 * MOST_PIECES);
        self.gaps.reserve(64);
        self.spaced.reserve(samples);
    }

    /// Joins those of `lines` that are fragments of one rope, and sorts the lines by length.
    /// `colors` are their mean colors. Returns the number of lines left.
    pub(crate) fn join(
        &mut self,
        lines: &mut [Line],
        colors: &mut [[f32; 3]],
        scenery: &Scenery,
    ) -> usize {
        self.gaps.clear();
        (self.is_reassigned, self.is_split) = (false, false);
        self.list_ends(lines, colors, scenery);
        if scenery.elsewhere.is_some() && self.part(lines, scenery) {
            self.list_ends(lines, colors, scenery);
        }
        self.list_candidates(lines, scenery);
        self.keep_cheapest();
        self.reassign(scenery);
        self.split(lines, scenery);
        for i in 0..self.candidates.len() {
            let candidate = self.candidates[i];
            self.bridge(&candidate, lines, scenery);
        }
        self.join_pairs(lines, scenery);
        self.sort(lines, colors)
    }

    /// Keeps the cheapest candidates, in order of cost, with at most one for each end.
    fn keep_cheapest(&mut self) {
        self.candidates
            .sort_unstable_by(|a, b| a.cost.total_cmp(&b.cost));
        let ends = &mut self.ends;
        self.candidates.retain(|candidate| {
            let is_free = candidate.ends.iter().all(|&e| !ends[e].used);
            if is_free {
                candidate.ends.iter().for_each(|&e| ends[e].used = true);
            }
            is_free
        });
    }

    fn list_ends(&mut self, lines: &[Line], colors: &[[f32; 3]], scenery: &Scenery) {
        self.ends.clear();
        for (l, (line, &color)) in lines.iter().zip(colors).enumerate() {
            if line.closed || line.samples.len() < 4 {
                continue;
            }
            for last in [false, true] {
                let n = line.samples.len();
                let width_px = line.samples[n / 2].width_px.max(1.0);
                let step_px = (line.length_px() / (n - 1) as f32).max(0.1);
                let back = |widths: f32| ((widths * width_px / step_px) as usize).clamp(1, n - 1);
                let at = |back: usize| line.samples[if last { n - 1 - back } else { back }].at;
                let from = |widths| vec2::unit_or(vec2::sub(at(0), at(back(widths))), [1.0, 0.0]);
                let leaves = line.border[usize::from(last)];
                // Takes the direction over two widths, since the occluder may fray the tip itself.
                // At the image's border, the direction at the tip itself is extrapolated, as if the
                // rope were an arc.
                let out = match leaves {
                    true => vec2::unit_or(
                        vec2::sub(vec2::scale(from(1.0), 2.0), from(2.0)),
                        [1.0, 0.0],
                    ),
                    false => from(2.0),
                };
                let at = at(0);
                self.ends.push(End {
                    line: l,
                    last,
                    at,
                    out,
                    width_px,
                    color,
                    leaves,
                    past: scenery.past.recall(at, out),
                    used: false,
                });
            }
        }
    }

    /// Cuts back fragments that run past each other side by side, to where they face each other.
    /// This occurs in a mask that is an estimate. Returns whether there were any.
    fn part(&self, lines: &mut [Line], scenery: &Scenery) -> bool {
        let mut is_any = false;
        for (i, a) in self.ends.iter().enumerate() {
            for b in &self.ends[i + 1..] {
                if a.line != b.line
                    && !(a.leaves || b.leaves)
                    && vec2::dot(a.out, b.out) < OPPOSED
                    && color::distance(a.color, b.color, scenery.yuv) <= scenery.alike().0
                    && let Some(kept) = kept(a, b, lines)
                {
                    for (end, count) in [a, b].into_iter().zip(kept) {
                        let samples = &mut lines[end.line].samples;
                        let from = samples.len() - count;
                        match end.last {
                            true => samples.truncate(count),
                            false => drop(samples.drain(..from)),
                        }
                    }
                    is_any = true;
                }
            }
        }
        is_any
    }

    fn list_candidates(&mut self, lines: &[Line], scenery: &Scenery) {
        self.candidates.clear();
        self.moves.clear();
        self.list_neighbors(lines, scenery);
        for (i, a) in self.ends.iter().enumerate() {
            for (j, b) in self.ends.iter().enumerate().skip(i + 1) {
                let same = a.line == b.line;
                if a.leaves != b.leaves || !same && !is_like(a, b, scenery) {
                    continue;
                }
                let ends = [i, j];
                if let Some((cost, way)) = known_way(a, b, scenery.past, same) {
                    let way = Some(way);
                    self.candidates.push(Candidate { cost, ends, way });
                } else if !same && are_open(a, b, scenery) {
                    let length_px = lines[a.line].length_px().min(lines[b.line].length_px());
                    if let Some(cost) = plain_cost(a, b, length_px, scenery) {
                        let way = None;
                        self.candidates.push(Candidate { cost, ends, way });
                    }
                }
            }
        }
    }

    /// Drops joins along a rope of the prior if the bare table shows on the way and the rope would
    /// become longer than usual. The visible fragments then leave too little length for the way.
    fn split(&mut self, lines: &[Line], scenery: &Scenery) {
        // A mask that contains ropes only cannot show occluders.
        if scenery.elsewhere.is_some() || scenery.picked.is_some() {
            return;
        }
        let (ends, count) = (&mut self.ends, self.candidates.len());
        let seen_px = |rope: u32| -> f32 {
            let pieces = self.pieces.iter().filter(|piece| piece.rope == rope);
            pieces.map(|piece| lines[piece.line].length_px()).sum()
        };
        self.candidates.retain(|candidate| {
            let [a, b] = candidate.ends.map(|end| &ends[end]);
            let is_split = candidate.way.is_some_and(|way| {
                let number = way[0].rope;
                let rope = &scenery.past.ropes()[number as usize];
                let way = Some((way, scenery.past));
                let chord_px = vec2::distance(a.at, b.at);
                !a.leaves
                    && seen_px(number) + chord_px > TOO_LONG * rope.usual_px
                    && chord_px > SPLIT.0 * a.width_px
                    && shown(a.at, b.at, scenery) < SPLIT.1
                    && way::share(way::between(a, b, way), |at| scenery.is_shown(at)) < SPLIT.1
            });
            if is_split {
                candidate
                    .ends
                    .iter()
                    .for_each(|&end| ends[end].used = false);
            }
            !is_split
        });
        self.is_split = self.candidates.len() < count;
        self.is_reassigned |= self.is_split;
    }

    /// Joins remaining ends that run into the same occluder, if they look alike, the prior leaves
    /// them open, and each is the partner of the other.
    fn join_pairs(&mut self, lines: &mut [Line], scenery: &Scenery) {
        self.candidates.clear();
        for i in 0..self.ends.len() {
            let Some(j) = self.partner(i, scenery).filter(|&j| j > i) else {
                continue;
            };
            let (a, b) = (&self.ends[i], &self.ends[j]);
            if self.partner(j, scenery) == Some(i)
                && is_like(a, b, scenery)
                && are_open(a, b, scenery)
            {
                self.candidates.push(Candidate {
                    cost: 0.0,
                    ends: [i, j],
                    way: None,
                });
            }
        }
        for i in 0..self.candidates.len() {
            let candidate = self.candidates[i];
            let [a, b] = candidate.ends.map(|end| &self.ends[end]);
            if a.line != b.line {
                // The prior knew them only as fragments, so the refit must not separate them again.
                self.is_reassigned |= scenery.past.are_pieces([&a.past, &b.past]);
                self.bridge(&candidate, lines, scenery);
            }
        }
    }

    /// Returns the end at which the rope leaves the occluder that end `i` runs into: the only other
    /// end there, whatever its bending, or the end that needs far less bending than all others.
    fn partner(&self, i: usize, scenery: &Scenery) -> Option<usize> {
        let a = &self.ends[i];
        let (mut first, mut second) = ((f32::INFINITY, None), f32::INFINITY);
        for j in (0..self.ends.len()).filter(|&j| self.is_pair(i, j, scenery)) {
            let b = &self.ends[j];
            let bend = bending(a.at, a.out, b.at, vec2::scale(b.out, -1.0));
            if bend < first.0 {
                (first, second) = ((bend, Some(j)), first.0);
            } else {
                second = second.min(bend);
            }
        }
        let is_plain = first.0 <= BENT.0 && second >= BENT.1 * first.0;
        first.1.filter(|_| second == f32::INFINITY || is_plain)
    }

    /// Returns whether two free ends run into the same occluder.
    fn is_pair(&self, i: usize, j: usize, scenery: &Scenery) -> bool {
        let (a, b) = (&self.ends[i], &self.ends[j]);
        i != j && !a.used && !b.used && !a.leaves && !b.leaves && runs_into(a, b, scenery)
    }

    /// Lists consecutive fragments of each known rope as candidates.
    fn list_neighbors(&mut self, lines: &[Line], scenery: &Scenery) {
        let past = scenery.past;
        pieces::list(lines, past, &mut self.pieces);
        for piece in &self.pieces {
            piece.list_moves(&lines[piece.line], past, &mut self.moves);
        }
        let end = |piece: &Fragment, is_last: bool| {
            let ends = self.ends.iter();
            let mut own = ends.map(|end| end.line == piece.line && end.last == is_last);
            own.position(|is_own| is_own)
        };
        for pair in self.pieces.windows(2) {
            let [from, piece] = [pair[0], pair[1]];
            if from.rope != piece.rope {
                continue;
            }
            let rope = &past.ropes()[piece.rope as usize];
            let way_px = piece.from_px - from.to_px;
            let (Some(i), Some(j)) = (end(&from, !from.reversed), end(&piece, piece.reversed))
            else {
                continue;
            };
            if self.ends[i].leaves != self.ends[j].leaves {
                continue;
            }
            let place = |piece: &Fragment, along_px, ahead| FormerPlace {
                rope: piece.rope,
                along_px,
                ahead,
                off: piece.off,
            };
            let way = [
                place(&from, from.to_px, true),
                place(&piece, piece.from_px, false),
            ];
            let chord_px = vec2::distance(self.ends[i].at, self.ends[j].at);
            if !is_stretched(rope, &way, way_px, chord_px) {
                let is_covered = self.ends[i].leaves
                    || covered(rope, [from.to_px, piece.from_px], scenery) >= COVERED;
                self.candidates.push(Candidate {
                    cost: if is_covered { NEIGHBORS.1 } else { NEIGHBORS.0 },
                    ends: [i, j],
                    way: Some(way),
                });
            }
        }
    }

    /// Joins the lines of two ends into the first one's, or closes the line that both belong to.
    fn bridge(&mut self, candidate: &Candidate, lines: &mut [Line], scenery: &Scenery) {
        let [i, j] = candidate.ends;
        (self.ends[i].used, self.ends[j].used) = (true, true);
        let (a, b) = (self.ends[i].line, self.ends[j].line);
        if !self.ends[i].last {
            self.reverse(a, lines);
        }
        if a != b && self.ends[j].last {
            self.reverse(b, lines);
        }
        let (from, to) = (self.ends[i], self.ends[j]);
        let from_px = lines[a].length_px();
        let way = candidate.way.map(|way| (way, scenery.past));
        // A way that shows the table is not the hidden one.
        let way = way.filter(|_| {
            !runs_into(&from, &to, scenery) || way::covered(&from, &to, way, scenery) >= COVERED
        });
        way::lay(&mut lines[a].samples, &from, &to, way);
        // The gap ends at the first sample of the second line, which is not yet appended.
        let last = lines[a].samples.len() - 1;
        let to_px = lines[a].length_px() + vec2::distance(lines[a].samples[last].at, to.at);
        if a == b {
            lines[a].closed = true;
        } else {
            let taken = std::mem::take(&mut lines[b].samples);
            lines[a].samples.extend_from_slice(&taken);
            lines[a].border[1] = lines[b].border[1];
            lines[b].samples = taken;
            lines[b].samples.clear();
            for gap in self.gaps.iter_mut().filter(|gap| gap.line == b) {
                *gap = Gap {
                    line: a,
                    from_px: gap.from_px + to_px,
                    to_px: gap.to_px + to_px,
                };
            }
            for end in self.ends.iter_mut().filter(|end| end.line == b) {
                end.line = a;
            }
        }
        self.gaps.push(Gap {
            line: a,
            from_px,
            to_px,
        });
        // Later steps rely on evenly spaced samples.
        let count = lines[a].samples.len();
        lines[a].resample(count, &mut self.spaced);
        std::mem::swap(&mut lines[a].samples, &mut self.spaced);
    }

    fn reverse(&mut self, line: usize, lines: &mut [Line]) {
        let length_px = lines[line].length_px();
        lines[line].samples.reverse();
        lines[line]
            .samples
            .iter_mut()
            .for_each(|s| s.side = -s.side);
        lines[line].border.swap(0, 1);
        for end in self.ends.iter_mut().filter(|end| end.line == line) {
            end.last = !end.last;
        }
        for gap in self.gaps.iter_mut().filter(|gap| gap.line == line) {
            (gap.from_px, gap.to_px) = (length_px - gap.to_px, length_px - gap.from_px);
        }
    }

    /// Sorts lines by length, the longest first. Those that were joined to others come last.
    /// Returns the number of lines left.
    fn sort(&mut self, lines: &mut [Line], colors: &mut [[f32; 3]]) -> usize {
        if self.gaps.is_empty() {
            return lines.len();
        }
        for i in 0..lines.len() {
            let longest = (i..lines.len()).max_by(|&a, &b| {
                lines[a]
                    .length_px()
                    .total_cmp(&lines[b].length_px())
                    .then(b.cmp(&a))
            });
            let Some(longest) = longest else { break };
            lines.swap(i, longest);
            colors.swap(i, longest);
            for gap in &mut self.gaps {
                if gap.line == i {
                    gap.line = longest;
                } else if gap.line == longest {
                    gap.line = i;
                }
            }
        }
        lines
            .iter()
            .take_while(|line| !line.samples.is_empty())
            .count()
    }
}

/// Returns whether two ends are similar in color and width.
fn is_like(a: &End, b: &End, scenery: &Scenery) -> bool {
    let width = (a.width_px / b.width_px).max(b.width_px / a.width_px);
    let (like_levels, like_width) = scenery.alike();
    color::distance(a.color, b.color, scenery.yuv) <= like_levels && width <= like_width
}

/// Returns whether the prior leaves open whether two ends are of one rope. It does, unless both
/// ends are on known ropes that were not lost under an occluder there.
fn are_open(a: &End, b: &End, scenery: &Scenery) -> bool {
    let known = |end: &End| !scenery.past.was_covered(&end.past);
    !(known(a) && known(b))
}

/// Returns whether two ends run into an occluder that reaches from one to the other.
fn runs_into(a: &End, b: &End, scenery: &Scenery) -> bool {
    const ASKED: usize = 16;
    let is_thing = |at: Vec2| scenery.occluder.has(at);
    let entry = |end: &End| {
        let ahead = (1..=INTO.1).map(|k| {
            vec2::along(
                end.at,
                end.out,
                INTO.0 * k as f32 * end.width_px / INTO.1 as f32,
            )
        });
        ahead.into_iter().find(|&at| is_thing(at))
    };
    let (Some(from), Some(to)) = (entry(a), entry(b)) else {
        return false;
    };
    let hits = (0..=ASKED).filter(|&k| {
        is_thing(vec2::along(
            from,
            vec2::sub(to, from),
            k as f32 / ASKED as f32,
        ))
    });
    hits.count() as f32 >= COVERED * ASKED as f32
}

/// Share of a rope's stretch, given in arc length, that is under an occluder or within half a width
/// of one.
fn covered(rope: &Rope, [from_px, to_px]: [f32; 2], scenery: &Scenery) -> f32 {
    const ASKED: usize = 16;
    let hits = (0..ASKED).filter(|&k| {
        let along_px = from_px + (to_px - from_px) * (k as f32 + 0.5) / ASKED as f32;
        scenery.is_hidden(rope.at(along_px), 0.5 * rope.width_px)
    });
    hits.count() as f32 / ASKED as f32
}

/// Number of samples to keep of each of two lines that run past each other at these ends. `None` if
/// they do not, or too little of either would be left.
fn kept(a: &End, b: &End, lines: &[Line]) -> Option<[usize; 2]> {
    let width_px = a.width_px.max(b.width_px);
    // Number of samples of an end's line before the one nearest to a place. `None` if that is too
    // far away.
    let nearest = |end: &End, at: Vec2| {
        let samples = &lines[end.line].samples;
        let off = |sample: &Sample| vec2::distance(sample.at, at);
        let (k, nearest) =
            (samples.iter().enumerate()).min_by(|a, b| off(a.1).total_cmp(&off(b.1)))?;
        let before = if end.last { k } else { samples.len() - 1 - k };
        (off(nearest) <= BESIDE * width_px).then_some(before)
    };
    let last = |end: &End| lines[end.line].samples.len() - 1;
    let (ka, kb) = (nearest(a, b.at)?, nearest(b, a.at)?);
    let step_px = |end: &End| lines[end.line].length_px() / last(end) as f32;
    let (doubled, all) = (last(a) - ka, last(a));
    let middle_a = ka + doubled / 2;
    let place = if a.last { middle_a } else { all - middle_a };
    let middle_b = nearest(b, lines[a.line].samples[place].at)?;
    let is_part = |end: &End, k: usize| (last(end) - k) as f32 <= DOUBLED * last(end) as f32;
    if (doubled as f32) * step_px(a) < width_px || !is_part(a, ka) || !is_part(b, kb) {
        return None;
    }
    let back = |end: &End, middle: usize| {
        let count = middle as f32 + 1.0 - BACK * width_px / step_px(end).max(0.1);
        (count >= 4.0).then_some(count as usize)
    };
    Some([back(a, middle_a)?, back(b, middle_b)?])
}
