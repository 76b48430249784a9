//! Whether two ends of lines are of one rope, whose rest between them is hidden.

use super::way::{cubic, share};
use crate::bitmap::bits::BitPlane;
use crate::graph::pairing::bending;
use crate::image::gray::GrayPlane;
use crate::image::{Image, color};
use crate::past::{FormerPlace, FormerPlaces, Past, Rope};
use crate::vec2::{self, Vec2};

/// Without a past: the widest gap that shows the table, in widths, and the most bending over it (a
/// turn by 20°). It is a flaw of the mask, such as shine, not a thing that lies on the rope.
pub(super) const FLAW: (f32, f32) = (2.5, 0.03);
/// Without a past: the same where something else than the table shows in the gap (a turn by 57°).
const COVERED: (f32, f32) = (16.0, 0.25);
/// Share of a gap that must differ from the table for something to lie there.
const SHOWN: f32 = 0.6;
/// The same where the mask says nothing of it: of the picture, and levels by which it must differ from the ground beside both ends.
const UNLIKE: (f32, f32) = (0.85, 24.0);
/// And the widest gap then, and the most bending (a turn by 81°): nothing but ropes has ends in such a mask.
const HIDDEN: (f32, f32) = (16.0, 0.5);
/// Levels of color, and factor of width, by which the two sides may differ.
pub(crate) const ALIKE: (f32, f32) = (40.0, 1.35);
/// The same of a mask that was made elsewhere: it thins before it breaks.
const ALIKE_ELSEWHERE: (f32, f32) = (60.0, 2.5);
/// And the widest gap there in which the rope, or another one over it, is seen, and the most bending (a turn by 44°).
const SEEN: (f32, f32) = (24.0, 0.15);
/// Levels of such a mask that are not just its background's: a network gives this to what it knows a little.
const TRACE: f32 = 6.0;
/// How much nearer to the ropes' color than what lies on both sides of it the picture is where a rope shows, and how near
/// in levels.
const RIDGE: (f32, f32) = (0.6, 48.0);
/// Where the rope leaves the picture and comes back: the widest gap, in widths, and the most bending (a turn by 99°).
const OUTSIDE: (f32, f32) = (16.0, 0.75);
/// Pixels by which the way between may come into the picture.
const INTO_PX: f32 = 1.5;
/// With a past: widths, and share of its way, that a gap may be shorter or longer than the rope was.
const STRETCH: (f32, f32) = (4.0, 0.35);
/// With a past: the way that counts as much as ends that lie a width off.
const WAY_WIDTHS: f32 = 5.0;
/// With a past: the sharpest turn of an end against its gap, in radians.
const SHARPEST: f32 = 1.6;
/// The largest share of a rope that may be hidden at one place.
const LONGEST_SHARE: f32 = 0.7;

/// An end of a line.
#[derive(Clone, Copy, Debug)]
pub(crate) struct End {
    pub(crate) line: usize,
    /// Whether it is the line's last sample.
    pub(crate) last: bool,
    pub(crate) at: Vec2,
    /// The direction out of the line.
    pub(crate) out: Vec2,
    pub(crate) width_px: f32,
    pub(crate) color: [f32; 3],
    /// Whether the line leaves the picture there.
    pub(crate) leaves: bool,
    pub(crate) past: FormerPlaces,
    pub(crate) used: bool,
}

/// What the ends are judged by.
pub(crate) struct Scenery<'a> {
    pub(crate) past: &'a Past,
    /// How unlike the table each pixel is.
    pub(crate) difference: &'a GrayPlane,
    /// From this difference on something lies there.
    pub(crate) level: f32,
    /// What was found to be no rope.
    pub(crate) occluder: &'a BitPlane,
    pub(crate) yuv: bool,
    /// The image, where the mask was made elsewhere: what the mask has missed may be seen in it.
    pub(crate) elsewhere: Option<&'a Image<'a>>,
    /// The image, where the mask is of the ropes alone, whoever made it: what lies over them is not in it.
    pub(crate) picked: Option<&'a Image<'a>>,
}

impl Scenery<'_> {
    /// Levels of color, and factor of width, by which two ends of one rope may differ.
    pub(crate) fn alike(&self) -> (f32, f32) {
        match self.elsewhere {
            Some(_) => ALIKE_ELSEWHERE,
            None => ALIKE,
        }
    }

    /// Whether anything but the table is seen at a place.
    pub(super) fn is_shown(&self, at: Vec2) -> bool {
        let covered = self.occluder.get(at[0] as i32, at[1] as i32);
        covered || self.difference.sample(at) >= self.level
    }

    /// Whether something that is no rope lies within so many pixels of a place.
    pub(crate) fn is_hidden(&self, [x, y]: Vec2, reach_px: f32) -> bool {
        let around = [[0.0, 0.0], [1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]];
        around.iter().any(|[dx, dy]| {
            let at = [x + dx * reach_px, y + dy * reach_px];
            self.occluder.has(at)
        })
    }
}

/// What it costs to join ends between which a rope of the past ran, and the way it took.
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
        // The way in at b is the way out of it, turned around.
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
            // The next piece along the rope comes first: a farther one would leave it out.
            let cost = ta.off + tb.off + miss * miss + way_px.max(0.0) / (WAY_WIDTHS * width_px);
            if best.is_none_or(|(least, _)| cost < least) {
                best = Some((cost, [*ta, *tb]));
            }
        }
    }
    // Ends that point away from where they are to go did not come from there.
    let (out, back) = (vec2::dot(a.out, chord), vec2::dot(b.out, chord));
    let faces = chord_px < width_px
        || a.leaves
        || out > libm::cosf(SHARPEST) * chord_px && -back > libm::cosf(SHARPEST) * chord_px;
    best.filter(|_| faces)
}

/// Whether two ends, `chord_px` apart, lie nearer or farther than the way between them along the rope allows, or that is too
/// long.
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

/// What it costs to join ends of which nothing is known, if they may be one rope.
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
    // Most ends do not face each other, and that is known at once.
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
    // Later than all that the past knows, and the straighter and nearer the earlier.
    (gap_widths <= widest && bend <= most_bent)
        .then_some(100.0 + bend / most_bent + gap_widths / widest)
}

/// Whether the plain way from a to b lies outside of the picture.
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

/// The share of the straight way from a to b, less half a width at each end, that is not table.
pub(super) fn shown(a: Vec2, b: Vec2, scenery: &Scenery) -> f32 {
    share(
        |t| vec2::along(a, vec2::sub(b, a), t),
        |at| scenery.is_shown(at),
    )
}

/// The share of the straight way from a to b, less half a width at each end, that is unlike the ground beside the ropes there.
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

/// The share of the way from a to b on which the mask has a trace of the rope, or lies on another one, or the picture shows a
/// band of the ropes' color: not so on a bare table.
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
