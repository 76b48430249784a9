//! Ends of lines, and the cost of joining two of them across a hidden part of the rope.
//!
//! There are two costs. `known_way` applies if a rope of the prior ran between the ends, and
//! `plain_cost` if not. The latter starts at 100, which places it after the former.

use super::way::share;
use crate::bitmap::bits::BitPlane;
use crate::graph::bending::{bending, cubic};
use crate::image::gray::GrayPlane;
use crate::image::{Image, color};
use crate::past::{FormerPlace, FormerPlaces, Past, Rope};
use crate::vec2::{self, Vec2};

/// For a gap of bare table, without a prior: maximum gap in widths, and maximum bending (a turn by
/// 20°). Such a gap is a flaw of the mask, such as shine, not an occluder.
pub(super) const FLAW: (f32, f32) = (2.5, 0.03);
/// Same limits for a gap in which something other than the table shows (a turn by 57°).
const COVERED: (f32, f32) = (16.0, 0.25);
/// Minimum share of a gap that must differ from the table for something to be in it.
const SHOWN: f32 = 0.6;
/// For a mask of ropes only, in which occluders do not show: minimum share of a gap that must
/// differ from the ground in the image, and minimum difference from it, in levels. The ground is
/// sampled on both sides of both ends.
const UNLIKE: (f32, f32) = (0.85, 24.0);
/// Maximum gap and maximum bending (a turn by 81°) of such a gap. In such a mask, only ropes have
/// ends.
const HIDDEN: (f32, f32) = (16.0, 0.5);
/// Maximum difference of two ends of one rope: levels of color, and factor of width.
pub(crate) const ALIKE: (f32, f32) = (40.0, 1.35);
/// Same for a mask made elsewhere, which thins before it breaks.
const ALIKE_ELSEWHERE: (f32, f32) = (60.0, 2.5);
/// For a mask made elsewhere: maximum gap and maximum bending (a turn by 44°) if the gap shows the
/// rope, or another one over it.
const SEEN: (f32, f32) = (24.0, 0.15);
/// Minimum level of such a mask that is more than background. A network outputs it where it is
/// slightly certain of a rope.
const TRACE: f32 = 6.0;
/// Maximum color difference from the rope at a place that shows it: as a share of the difference on
/// either side, and in levels.
const RIDGE: (f32, f32) = (0.6, 48.0);
/// For a rope that leaves the image and returns: maximum gap in widths, and maximum bending (a turn
/// by 99°).
const OUTSIDE: (f32, f32) = (16.0, 0.75);
/// Maximum depth, in pixels, to which the way between such ends may come into the image.
const INTO_PX: f32 = 1.5;
/// With a prior: maximum difference between the gap and the same stretch of the prior's rope, in
/// widths, plus a share of the way along the rope.
const STRETCH: (f32, f32) = (4.0, 0.35);
/// With a prior: length of the way that costs as much as an end that is one width off, in widths.
const WAY_WIDTHS: f32 = 5.0;
/// With a prior: maximum turn of an end against its gap, in radians.
const SHARPEST: f32 = 1.6;
/// Maximum share of a rope that may be hidden in one gap.
const LONGEST_SHARE: f32 = 0.7;

/// An end of a line.
#[derive(Clone, Copy, Debug)]
pub(crate) struct End {
    pub(crate) line: usize,
    /// True if it is the line's last sample.
    pub(crate) last: bool,
    pub(crate) at: Vec2,
    /// Direction out of the line.
    pub(crate) out: Vec2,
    pub(crate) width_px: f32,
    pub(crate) color: [f32; 3],
    /// True if the line leaves the image there.
    pub(crate) leaves: bool,
    pub(crate) past: FormerPlaces,
    pub(crate) used: bool,
}

/// Data for judging ends.
pub(crate) struct Scenery<'a> {
    pub(crate) past: &'a Past,
    /// Difference of each pixel from the table.
    pub(crate) difference: &'a GrayPlane,
    /// Minimum difference at which something is on the table.
    pub(crate) level: f32,
    /// Occluders.
    pub(crate) occluder: &'a BitPlane,
    pub(crate) yuv: bool,
    /// The image, if the mask was made elsewhere. It may show what the mask has missed.
    pub(crate) elsewhere: Option<&'a Image<'a>>,
    /// The image, if the mask contains ropes only, whatever its origin. Such a mask shows no
    /// occluders.
    pub(crate) picked: Option<&'a Image<'a>>,
}

impl Scenery<'_> {
    /// Maximum difference of two ends of one rope: levels of color, and factor of width.
    pub(crate) fn alike(&self) -> (f32, f32) {
        match self.elsewhere {
            Some(_) => ALIKE_ELSEWHERE,
            None => ALIKE,
        }
    }

    /// Returns whether anything but the table shows at a place.
    pub(super) fn is_shown(&self, at: Vec2) -> bool {
        let covered = self.occluder.get(at[0] as i32, at[1] as i32);
        covered || self.difference.sample(at) >= self.level
    }

    /// Returns whether an occluder is at a place, or this distance left, right, above or below it.
    pub(crate) fn is_hidden(&self, [x, y]: Vec2, reach_px: f32) -> bool {
        let around = [[0.0, 0.0], [1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]];
        around.iter().any(|[dx, dy]| {
            let at = [x + dx * reach_px, y + dy * reach_px];
            self.occluder.has(at)
        })
    }
}

/// Cost of joining ends between which a rope of the prior ran, and their places on that rope. If
/// both ends are of one line (`same`), only a closed rope counts.
///
/// The cost is a sum:
///
/// - the distances of both ends from the rope, in widths;
/// - the squared misfit of the gap's length, in units of `STRETCH`;
/// - the way along the rope, in units of `WAY_WIDTHS`.
///
/// The cheapest pair of possible places counts. `None` if no rope fits, or if an end points away
/// from the other one.
pub(crate) fn known_way(
    a: &End,
    b: &End,
    past: &Past,
    same: bool,
) -> Option<(f32, [FormerPlace; 2])> {
    let chord = vec2::sub(b.at, a.at);
    let chord_px = vec2::norm(chord);
    let width_px = 0.5 * (a.width_px + b.width_px);
    let mut best: Option<(f32, [FormerPlace; 2])> = None;
    for ta in a.past.likely(past) {
        // The direction into the line at b is the opposite of the one out of it.
        for tb in b
            .past
            .likely(past)
            .filter(|tb| tb.rope == ta.rope && tb.ahead != ta.ahead)
        {
            let rope = &past.ropes()[ta.rope as usize];
            if same && !rope.closed {
                continue;
            }
            let way_px = rope.way_px(ta, tb, ta.ahead);
            let slack_px = STRETCH.0 * width_px;
            let apart_px = vec2::distance(rope.at(ta.along_px), rope.at(tb.along_px));
            if way_px < -slack_px || is_stretched(rope, &[*ta, *tb], way_px, chord_px) {
                continue;
            }
            let miss = (chord_px - apart_px) / (slack_px + STRETCH.1 * way_px.max(0.0));
            // The next fragment along the rope has priority: joining a farther one would skip it.
            let cost = ta.off + tb.off + miss * miss + way_px.max(0.0) / (WAY_WIDTHS * width_px);
            if best.is_none_or(|(least, _)| cost < least) {
                best = Some((cost, [*ta, *tb]));
            }
        }
    }
    // Ends that point away from each other are not joined.
    let (out, back) = (vec2::dot(a.out, chord), vec2::dot(b.out, chord));
    let faces = chord_px < width_px
        || a.leaves
        || out > libm::cosf(SHARPEST) * chord_px && -back > libm::cosf(SHARPEST) * chord_px;
    best.filter(|_| faces)
}

/// Returns whether the distance between two ends, `chord_px`, differs too much from that of their
/// places on the rope, or whether the way along the rope is too long.
pub(crate) fn is_stretched(
    rope: &Rope,
    way: &[FormerPlace; 2],
    way_px: f32,
    chord_px: f32,
) -> bool {
    let [a, b] = way.map(|place| rope.at(place.along_px));
    let most_px = STRETCH.0 * rope.width_px + STRETCH.1 * way_px.max(0.0);
    way_px > LONGEST_SHARE * rope.length_px || (chord_px - vec2::distance(a, b)).abs() > most_px
}

/// Cost of joining ends without a prior, or `None` if they cannot be of one rope.
///
/// The cost is 100, plus the bending and the gap as shares of their limits. The limits depend on
/// what the gap shows: something other than the table (`COVERED`, or `SEEN` for a mask made
/// elsewhere), an object in the image on a mask of ropes only (`HIDDEN`), or bare table (`FLAW`).
/// For ends that leave the image, they are those of `OUTSIDE`.
pub(crate) fn plain_cost(a: &End, b: &End, length_px: f32, scenery: &Scenery) -> Option<f32> {
    let chord_px = vec2::distance(a.at, b.at);
    let width_px = 0.5 * (a.width_px + b.width_px);
    let gap_widths = chord_px / width_px;
    if a.leaves {
        let bend = bending(a.at, a.out, b.at, vec2::scale(b.out, -1.0));
        let is_one = gap_widths <= OUTSIDE.0 && bend <= OUTSIDE.1 && is_outside(a, b, scenery);
        return is_one.then_some(100.0 + bend / OUTSIDE.1 + gap_widths / OUTSIDE.0);
    }
    let over = if scenery.elsewhere.is_some() {
        SEEN
    } else {
        COVERED
    };
    if gap_widths > over.0 || chord_px > 2.0 * length_px {
        return None;
    }
    let bend = bending(a.at, a.out, b.at, vec2::scale(b.out, -1.0));
    // Most ends do not face each other. This rejects them early.
    let most = scenery.picked.map_or(over.1, |_| HIDDEN.1);
    if bend > most.max(FLAW.1) {
        return None;
    }
    let covered = match scenery.elsewhere {
        Some(image) => seen(a, b, image, scenery),
        None => shown(a.at, b.at, scenery),
    } >= SHOWN;
    let is_within = |(widest, most_bent)| gap_widths <= widest && bend <= most_bent;
    let is_hidden = || {
        let picture = scenery.picked.filter(|_| is_within(HIDDEN));
        picture.is_some_and(|image| unlike_ground(a, b, image, scenery.yuv) >= UNLIKE.0)
    };
    let (widest, most_bent) = match covered {
        true if is_within(over) => over,
        _ if is_hidden() => HIDDEN,
        _ => FLAW,
    };
    // The offset of 100 places them after all joins that the prior knows.
    (gap_widths <= widest && bend <= most_bent)
        .then_some(100.0 + bend / most_bent + gap_widths / widest)
}

/// Returns whether the cubic between a and b is outside of the image, within `INTO_PX`.
fn is_outside(a: &End, b: &End, scenery: &Scenery) -> bool {
    const ASKED: usize = 16;
    let plane = scenery.difference;
    let (right, bottom) = (plane.width() as f32 - 1.0, plane.height() as f32 - 1.0);
    let way = cubic([a.at, a.out], [b.at, b.out]);
    (1..ASKED).all(|k| {
        let [x, y] = way(k as f32 / ASKED as f32);
        x.min(y).min(right - x).min(bottom - y) <= INTO_PX
    })
}

/// Share of the straight way from a to b that is not bare table. It excludes both ends.
pub(super) fn shown(a: Vec2, b: Vec2, scenery: &Scenery) -> f32 {
    share(
        |t| vec2::along(a, vec2::sub(b, a), t),
        |at| scenery.is_shown(at),
    )
}

/// Share of the straight way from a to b that differs from the ground next to the ropes. It
/// excludes an eighth at each end.
fn unlike_ground(a: &End, b: &End, image: &Image, yuv: bool) -> f32 {
    const ASKED: usize = 16;
    let beside = [a, b].map(|end| {
        let back = vec2::along(end.at, end.out, -3.5 * end.width_px);
        [1.25, -1.25].map(|widths| {
            let at = vec2::along(back, vec2::normal(end.out), widths * end.width_px);
            color::between(image, at)
        })
    });
    let hits = (2..ASKED - 1).filter(|&k| {
        let at = vec2::along(a.at, vec2::sub(b.at, a.at), k as f32 / ASKED as f32);
        let own = color::between(image, at);
        let mut grounds = beside.iter().flatten();
        grounds.all(|&ground| color::distance(own, ground, yuv) >= UNLIKE.1)
    });
    hits.count() as f32 / (ASKED - 3) as f32
}

/// Share of the cubic from a to b that shows the rope. A place counts if the mask has a trace of
/// the rope or an occluder is there, or if the image shows a band of the ropes' color. A bare table
/// shows neither.
fn seen(a: &End, b: &End, image: &Image, scenery: &Scenery) -> f32 {
    const ASKED: usize = 24;
    let aside = vec2::normal(vec2::unit_or(vec2::sub(b.at, a.at), a.out));
    let aside_px = 0.75 * (a.width_px + b.width_px);
    let mut color = [0.0; 3];
    for (c, color) in color.iter_mut().enumerate() {
        *color = 0.5 * (a.color[c] + b.color[c]);
    }
    let off = |at: Vec2| color::distance(color::between(image, at), color, scenery.yuv);
    let way = cubic([a.at, a.out], [b.at, b.out]);
    let hits = (1..ASKED).filter(|&k| {
        let at = way(k as f32 / ASKED as f32);
        let covered = scenery.occluder.get(at[0] as i32, at[1] as i32);
        if covered || scenery.difference.sample(at) >= TRACE {
            return true;
        }
        let beside = [aside_px, -aside_px].map(|px| off(vec2::along(at, aside, px)));
        off(at) < RIDGE.1.min(RIDGE.0 * beside[0].min(beside[1]))
    });
    hits.count() as f32 / (ASKED - 1) as f32
}
