//! The ropes of the last image as a map: which rope ran through a place, in which direction, and at
//! which arc length.
//!
//! A crossing that opens, closes or is only touched looks the same in one image, whichever strand
//! goes where. Between two images no strand moves far, so the last image resolves the ambiguity:
//! the two arms of a strand are on one rope, one after the other, as far apart along it as in the
//! image. This evidence is weighed with the bends and does not override them, so that a clear image
//! corrects what the last image got wrong.

use crate::vec2::{self, Vec2};

/// No rope.
const NONE: u32 = u32::MAX;
/// Cost of pairing two arms of a crossing against the last image. Two exchanged strands pay it
/// twice, as much as two arcs of 55°, so a crossing that is much clearer than that outweighs it.
const AGAINST: f32 = 0.25;
/// Maximum movement, in widths, at which a strand is still recognized.
const FARTHEST_WIDTHS: f32 = 3.0;
/// Cosine of the maximum turn of a strand.
const TURNED: f32 = 0.6;
/// Slack in widths, in addition to the ropes' movement. A trace this much farther away than the
/// nearest may still be the right one. It covers what smoothing and whole pixels leave open.
const DOUBT: f32 = 0.4;
/// Distance in widths that a rope's end may have moved, in addition to the ropes' movement.
const ENDS_WIDTHS: f32 = 1.5;
/// Minimum share of the skeleton that must be where ropes were, for the past to be trusted. A
/// smaller share means a cut or a jump, and any match is then chance.
const LEAST_SHARE: f32 = 0.5;
/// Number of skeleton pixels sampled for that share.
const ASKED: usize = 64;

/// A place on a rope of the past.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FormerPlace {
    /// Index into `Past::ropes`, or `NONE`.
    pub(crate) rope: u32,
    /// Arc length from the rope's first point.
    pub(crate) along_px: f32,
    /// True if the queried direction is that of growing arc length.
    pub(crate) ahead: bool,
    /// Distance from the queried position to the rope, in its widths.
    pub(crate) off: f32,
}

impl FormerPlace {
    const NONE: Self = Self {
        rope: NONE,
        along_px: 0.0,
        ahead: false,
        off: f32::INFINITY,
    };
}

/// The likeliest traces of a place, nearest first. There are several where strands touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FormerPlaces([FormerPlace; 3]);

impl Default for FormerPlaces {
    fn default() -> Self {
        Self([FormerPlace::NONE; 3])
    }
}

impl FormerPlaces {
    pub(crate) const NONE: Self = Self([FormerPlace::NONE; 3]);

    pub(crate) fn iter(&self) -> impl Iterator<Item = &FormerPlace> {
        self.0.iter().filter(|t| t.rope != NONE)
    }

    /// Returns whether the place is on no rope of the past.
    pub(crate) fn is_empty(&self) -> bool {
        self.iter().next().is_none()
    }

    /// The traces that the ropes' movement leaves open: those hardly farther away than the nearest.
    pub(crate) fn likely(&self, past: &Past) -> impl Iterator<Item = &FormerPlace> {
        let most = self.0[0].off + past.moved + DOUBT;
        self.iter().filter(move |t| t.off <= most)
    }

    fn add(&mut self, new: FormerPlace) {
        if let Some(i) = self.0.iter().position(|t| new.off < t.off)
            && new.rope != NONE
        {
            self.0[i..].rotate_right(1);
            self.0[i] = new;
        }
    }
}

/// Movement of a place on a rope of the past, as shown by a fragment of that rope.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Move {
    /// The rope's index in the past.
    pub(crate) rope: u32,
    pub(crate) along_px: f32,
    pub(crate) by: Vec2,
}

/// The ropes as they were last seen.
#[derive(Debug, Default)]
pub(crate) struct Past {
    ropes: Vec<Rope>,
    count: usize,
    trusted: bool,
    /// Mean movement of the ropes since then, in widths.
    moved: f32,
    /// Half the width of the widest well-known rope.
    widest_half_px: f32,
}

/// Properties of a rope besides its shape.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct State {
    /// True if the rope was seen in the last image, and had been seen for more than a moment.
    pub(crate) live: bool,
    /// True if both of its ends were in the image.
    pub(crate) whole: bool,
    /// True if both of its ends were ever seen free. If not, it may be a fragment of a rope.
    pub(crate) was_free: bool,
}

#[cfg(test)]
impl State {
    pub(crate) const SEEN: Self = Self {
        live: true,
        whole: true,
        was_free: true,
    };
}

/// One rope.
#[derive(Debug, Default)]
pub(crate) struct Rope {
    /// Index in `Past::ropes`.
    pub(crate) index: u32,
    pub(crate) closed: bool,
    /// Arc length at each end of its visible part, where that end was under something.
    covered_px: [Option<f32>; 2],
    pub(crate) state: State,
    pub(crate) length_px: f32,
    pub(crate) width_px: f32,
    /// The length that it has had for a long time.
    pub(crate) usual_px: f32,
    /// Points at equal steps.
    points: Vec<Vec2>,
    /// Minimum and maximum of their coordinates.
    span: [Vec2; 2],
}

impl Rope {
    /// Distance from a place to the rope.
    pub(crate) fn off_px(&self, at: Vec2) -> f32 {
        let apart = |p: &Vec2| vec2::distance(*p, at);
        let nearest_px = self.points.iter().map(apart).fold(f32::INFINITY, f32::min);
        // A place between two points can be half a step from both.
        (nearest_px - 0.35 * self.step_px()).max(0.0)
    }

    /// Arc length between two points.
    fn step_px(&self) -> f32 {
        let intervals = self.points.len() - usize::from(!self.closed);
        self.length_px / intervals.max(1) as f32
    }

    /// The position at an arc length.
    pub(crate) fn at(&self, along_px: f32) -> Vec2 {
        let n = self.points.len();
        let place = along_px / self.step_px().max(1e-6);
        let place = if self.closed {
            place.rem_euclid(n as f32)
        } else {
            place.clamp(0.0, (n - 1) as f32)
        };
        let i = (place as usize).min(n - 1);
        let next = if self.closed {
            (i + 1) % n
        } else {
            (i + 1).min(n - 1)
        };
        let (a, b) = (self.points[i], self.points[next]);
        vec2::along(a, vec2::sub(b, a), place - i as f32)
    }

    /// Returns whether no part of the rope is near enough to a position to be traced to.
    fn is_far_from(&self, at: Vec2) -> bool {
        let [low, high] = self.span;
        // One pixel more, for the rounding of distances.
        let reach_px = FARTHEST_WIDTHS * self.width_px + 1.0;
        (0..2).any(|c| at[c] < low[c] - reach_px || at[c] > high[c] + reach_px)
    }

    /// Arc length from one trace to another, in the direction that `ahead` gives.
    pub(crate) fn way_px(&self, from: &FormerPlace, to: &FormerPlace, ahead: bool) -> f32 {
        let way = if ahead {
            to.along_px - from.along_px
        } else {
            from.along_px - to.along_px
        };
        if self.closed && way < 0.0 {
            way + self.length_px
        } else {
            way
        }
    }
}

impl Past {
    /// Forgets all ropes.
    pub(crate) fn clear(&mut self) {
        self.count = 0;
        self.trusted = false;
        self.widest_half_px = 0.5;
    }

    /// Adds a rope.
    #[cfg(test)]
    pub(crate) fn add(&mut self, closed: bool, sizes_px: [f32; 2], points: &[Vec2]) {
        let sizes_px = [sizes_px[0], sizes_px[1], sizes_px[0]];
        self.add_covered(closed, sizes_px, points, [None; 2], State::SEEN);
    }

    /// Adds a rope that may have been partly covered.
    pub(crate) fn add_covered(
        &mut self,
        closed: bool,
        sizes_px: [f32; 3],
        points: &[Vec2],
        covered_px: [Option<f32>; 2],
        state: State,
    ) {
        if points.len() < 2 {
            return;
        }
        if self.count == self.ropes.len() {
            self.ropes.push(Rope::default());
        }
        let rope = &mut self.ropes[self.count];
        rope.index = self.count as u32;
        (rope.closed, rope.covered_px) = (closed, covered_px);
        rope.state = state;
        [rope.length_px, rope.width_px, rope.usual_px] = sizes_px.map(|size| size.max(1.0));
        rope.points.clear();
        rope.points.extend_from_slice(points);
        let outermost = |least: fn(f32, f32) -> f32| {
            let among = |a: Vec2, b: &Vec2| [0, 1].map(|c| least(a[c], b[c]));
            points.iter().fold(points[0], among)
        };
        rope.span = [outermost(f32::min), outermost(f32::max)];
        self.count += 1;
        self.trusted = true;
    }

    /// Trusts the past only if the ropes of this image, given by its `skeleton`, are about where
    /// they were. Also measures how far they have moved.
    pub(crate) fn check(&mut self, skeleton: impl ExactSizeIterator<Item = Vec2>) {
        let stride = (skeleton.len() / ASKED).max(1);
        let (mut asked, mut known, mut sum) = (0.0f32, 0.0f32, 0.0);
        for at in skeleton.step_by(stride) {
            asked += 1.0;
            let off = self.off(at);
            if off < FARTHEST_WIDTHS {
                (known, sum) = (known + 1.0, sum + off);
            }
        }
        self.trusted = self.count > 0 && known >= LEAST_SHARE * asked;
        self.moved = sum / known.max(1.0);
    }

    /// Distance from a place to the nearest rope, in its widths.
    fn off(&self, at: Vec2) -> f32 {
        let offs = self
            .ropes()
            .iter()
            .map(|rope| rope.off_px(at) / rope.width_px);
        offs.fold(f32::INFINITY, f32::min)
    }

    /// The ends of all open ropes, with the ropes' widths; empty if the past is not trusted.
    pub(crate) fn ends(&self) -> impl Iterator<Item = (Vec2, f32)> {
        let open = self
            .ropes()
            .iter()
            .filter(|rope| self.trusted && !rope.closed);
        open.flat_map(|rope| {
            let ends = [rope.points[0], rope.points[rope.points.len() - 1]];
            ends.map(|end| (end, rope.width_px))
        })
    }

    /// Maximum distance of the end of a rope of this width from its former place.
    pub(crate) fn reach_px(&self, width_px: f32) -> f32 {
        (ENDS_WIDTHS + self.moved) * width_px
    }

    /// The former rope end near a place, and the rope's width.
    pub(crate) fn end_near(&self, at: Vec2) -> Option<(Vec2, f32)> {
        self.ends()
            .filter(|&(end, width_px)| vec2::distance(end, at) < self.reach_px(width_px))
            .min_by(|a, b| vec2::distance(a.0, at).total_cmp(&vec2::distance(b.0, at)))
    }

    /// The ropes that were seen in the last image; empty if the past is not trusted.
    pub(crate) fn live(&self) -> impl Iterator<Item = &Rope> {
        self.ropes()
            .iter()
            .filter(|rope| self.trusted && rope.state.live)
    }

    /// Mean movement of the ropes, in widths.
    pub(crate) fn moved(&self) -> f32 {
        self.moved
    }

    /// Half the width of the widest well-known rope, if the past is trusted.
    pub(crate) fn widest_half_px(&self) -> Option<f32> {
        self.trusted.then_some(self.widest_half_px)
    }

    /// Records that a rope of this width is well known.
    pub(crate) fn know(&mut self, width_px: f32) {
        self.widest_half_px = self.widest_half_px.max(0.5 * width_px);
    }

    pub(crate) fn ropes(&self) -> &[Rope] {
        &self.ropes[..self.count]
    }

    /// The places on ropes of the past where a strand at `at` that runs in direction `toward` was.
    pub(crate) fn recall(&self, at: Vec2, toward: Vec2) -> FormerPlaces {
        let mut traces = FormerPlaces::default();
        let toward = vec2::unit_or(toward, [1.0, 0.0]);
        if !self.trusted {
            return traces;
        }
        for (r, rope) in self.ropes().iter().enumerate() {
            // Each stretch of the rope that comes near counts once, by its nearest place.
            let mut best = FormerPlace::NONE;
            if rope.is_far_from(at) {
                continue;
            }
            let n = rope.points.len();
            for i in 0..n - usize::from(!rope.closed) {
                let (a, b) = (rope.points[i], rope.points[(i + 1) % n]);
                match trace(rope, r as u32, i, [a, b], at, toward) {
                    Some(here) if here.off < best.off => best = here,
                    Some(_) => {}
                    None => {
                        traces.add(std::mem::replace(&mut best, FormerPlace::NONE));
                    }
                }
            }
            traces.add(best);
        }
        traces
    }

    /// Cost that the past assigns to pairing two arms of a crossing as one strand. The arms are
    /// `chord_px` apart, and both were traced in their directions into the crossing.
    pub(crate) fn against(&self, a: &FormerPlaces, b: &FormerPlaces, chord_px: f32) -> f32 {
        if a.is_empty() || b.is_empty() {
            return 0.0;
        }
        let mut least = 1.0f32;
        for ta in a.likely(self) {
            let onward = |tb: &&FormerPlace| tb.rope == ta.rope && tb.ahead != ta.ahead;
            for tb in b.likely(self).filter(onward) {
                let rope = &self.ropes[ta.rope as usize];
                let way = rope.way_px(ta, tb, ta.ahead);
                let miss = (way - chord_px).abs() / (2.0 * rope.width_px + 0.5 * chord_px);
                let doubt = self.moved + DOUBT;
                let off = (ta.off * ta.off + tb.off * tb.off) / (8.0 * doubt * doubt);
                least = least.min(off + miss * miss);
            }
        }
        AGAINST * least
    }

    /// Returns whether an end of a line is where a rope was lost under something, for all likely
    /// traces.
    pub(crate) fn was_covered(&self, end: &FormerPlaces) -> bool {
        end.likely(self).all(|t| {
            let rope = &self.ropes[t.rope as usize];
            let reach = self.reach_px(rope.width_px) + rope.width_px;
            let end_px = rope.covered_px[usize::from(t.ahead)];
            !rope.closed && end_px.is_some_and(|end_px| (end_px - t.along_px).abs() < reach)
        })
    }

    /// Returns whether these ends are on known ropes, none of them ever seen with both ends free.
    pub(crate) fn are_pieces(&self, ends: [&FormerPlaces; 2]) -> bool {
        let places = ends.into_iter().flat_map(|end| end.likely(self));
        let mut ropes = places.map(|t| &self.ropes[t.rope as usize]).peekable();
        ropes.peek().is_some() && ropes.all(|rope| !rope.state.was_free)
    }

    /// Cost that the past assigns to an arm that ends in the crossing it runs into.
    pub(crate) fn against_end(&self, arm: &FormerPlaces) -> f32 {
        let goes_on = |t: &FormerPlace| {
            let rope = &self.ropes[t.rope as usize];
            let left = if t.ahead {
                rope.length_px - t.along_px
            } else {
                t.along_px
            };
            rope.closed || left > 2.0 * FARTHEST_WIDTHS * rope.width_px
        };
        if !arm.is_empty() && arm.likely(self).all(goes_on) {
            AGAINST
        } else {
            0.0
        }
    }
}

/// The place on segment `i`, from point a to point b, that is nearest to `at`, if it is near enough
/// and runs along `toward`. It is on no rope if `at` is more than a width beyond the rope's tip.
fn trace(
    rope: &Rope,
    index: u32,
    i: usize,
    [a, b]: [Vec2; 2],
    at: Vec2,
    toward: Vec2,
) -> Option<FormerPlace> {
    let step = vec2::sub(b, a);
    let length = vec2::norm(step);
    if length < 1e-6 {
        return None;
    }
    let cos = vec2::dot(step, toward) / length;
    let beyond = vec2::dot(vec2::sub(at, a), step) / (length * length);
    let t = beyond.clamp(0.0, 1.0);
    let last = i + 2 == rope.points.len();
    let past_tip = !rope.closed
        && (i == 0 && beyond * length < -rope.width_px
            || last && (beyond - 1.0) * length > rope.width_px);
    let off = vec2::distance(at, vec2::along(a, step, t)) / rope.width_px;
    (off <= FARTHEST_WIDTHS && cos.abs() >= TURNED).then(|| FormerPlace {
        rope: if past_tip { NONE } else { index },
        along_px: (i as f32 + t) * rope.step_px(),
        ahead: cos > 0.0,
        off,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A rope that runs right along y = 0 and comes back along y = 10.
    fn hairpin() -> Past {
        let mut points: Vec<Vec2> = (0..=40).map(|i| [5.0 * i as f32, 0.0]).collect();
        points.extend([[205.0, 5.0]]);
        points.extend((0..=40).map(|i| [200.0 - 5.0 * i as f32, 10.0]));
        let mut past = Past::default();
        past.add(false, [410.0, 4.0], &points);
        past
    }

    #[test]
    fn a_place_between_two_strands_is_traced_to_both() {
        let past = hairpin();
        let traces = past.recall([100.0, 4.0], [1.0, 0.0]);
        let found: Vec<_> = traces
            .iter()
            .map(|t| (t.along_px.round(), t.ahead))
            .collect();
        assert_eq!(found, [(100.0, true), (310.0, false)]);
    }

    #[test]
    fn strands_that_go_on_as_they_did_cost_less_than_strands_exchanged() {
        let past = hairpin();
        let arm = |at, into| past.recall(at, into);
        let (left, right) = (arm([90.0, 1.0], [1.0, 0.0]), arm([110.0, 1.0], [-1.0, 0.0]));
        let upper = arm([110.0, 9.0], [-1.0, 0.0]);
        assert!(past.against(&left, &right, 20.0) < 0.1 * AGAINST);
        assert!(past.against(&left, &upper, 21.5) > 0.15 * AGAINST);
        assert_eq!(past.against_end(&left), AGAINST);
    }

    #[test]
    fn an_end_may_end_and_the_unknown_is_free() {
        let past = hairpin();
        let tip = past.recall([10.0, 0.0], [-1.0, 0.0]);
        assert_eq!(past.against_end(&tip), 0.0);
        let nowhere = past.recall([100.0, 90.0], [1.0, 0.0]);
        assert_eq!(past.against(&nowhere, &tip, 10.0), 0.0);
    }
}
