//! The hidden way between two ends: that of the prior, or nearly an arc.

use super::ends::{End, Scenery};
use crate::centerline::line::Sample;
use crate::graph::bending::cubic;
use crate::past::{FormerPlace, Past};
use crate::vec2::{self, Vec2};

/// Share of the way between two ends that is under an occluder.
pub(super) fn covered(
    from: &End,
    to: &End,
    way: Option<([FormerPlace; 2], &Past)>,
    scenery: &Scenery,
) -> f32 {
    let reach_px = 0.25 * (from.width_px + to.width_px);
    share(between(from, to, way), |at| scenery.is_hidden(at, reach_px))
}

/// Share of the places on a way for which `is_so` holds, from 0 to 1, without its ends.
pub(super) fn share(way: impl Fn(f32) -> Vec2, is_so: impl Fn(Vec2) -> bool) -> f32 {
    const ASKED: usize = 16;
    let hits = (1..ASKED).filter(|&k| is_so(way(k as f32 / ASKED as f32)));
    hits.count() as f32 / (ASKED - 1) as f32
}

/// The way between two ends, as a function from 0 to 1. With `way`, it is the prior's, moved along
/// with both ends. Otherwise it is the cubic that leaves both ends in their own directions.
///
/// The prior's way is corrected toward the rope's usual length. If the rope was longer than usual,
/// the hidden way is drawn in toward the cubic. If it was shorter and leaves the image here, the
/// way outside bends farther from the chord.
pub(super) fn between(
    from: &End,
    to: &End,
    way: Option<([FormerPlace; 2], &Past)>,
) -> impl Fn(f32) -> Vec2 {
    let plain = cubic([from.at, from.out], [to.at, to.out]);
    let chord = vec2::sub(to.at, from.at);
    let known = move |t: f32| {
        let Some(([a, b], past)) = way else {
            return from.at;
        };
        let rope = &past.ropes()[a.rope as usize];
        let way = rope.way_px(&a, &b, a.ahead);
        let along = |t: f32| a.along_px + if a.ahead { way * t } else { -way * t };
        let moved = [
            vec2::sub(from.at, rope.at(along(0.0))),
            vec2::sub(to.at, rope.at(along(1.0))),
        ];
        let shift = vec2::along(moved[0], vec2::sub(moved[1], moved[0]), t);
        vec2::add(rope.at(along(t)), shift)
    };
    let stretched = move |times: f32| {
        move |t: f32| {
            let straight = vec2::along(from.at, chord, t);
            vec2::along(straight, vec2::sub(known(t), straight), times)
        }
    };
    let spare_px = way.map_or(0.0, |([a, _], past)| {
        let rope = &past.ropes()[a.rope as usize];
        rope.length_px - rope.usual_px
    });
    let times = match from.leaves && spare_px < 0.0 {
        true => stretching(length_px(known) - spare_px, |times| {
            length_px(stretched(times))
        }),
        false => 1.0,
    };
    let share = match way {
        Some(_) => drawn_in(spare_px, length_px(known), length_px(&plain)),
        None => 1.0,
    };
    move |t| {
        let known = if times > 1.0 {
            stretched(times)(t)
        } else {
            known(t)
        };
        vec2::along(known, vec2::sub(plain(t), known), share)
    }
}

/// Factor, from 1 to `MOST`, to apply to a way's distance from its chord for it to become
/// `wanted_px` long. `length_px` is its length for a given factor.
pub(crate) fn stretching(wanted_px: f32, length_px: impl Fn(f32) -> f32) -> f32 {
    const MOST: f32 = 2.0;
    const HALVINGS: usize = 6;
    let (mut least, mut most) = (1.0, MOST);
    for _ in 0..HALVINGS {
        let times = 0.5 * (least + most);
        match length_px(times) < wanted_px {
            true => least = times,
            false => most = times,
        }
    }
    least
}

/// Appends samples along the way between two ends to those of the first end's line.
pub(super) fn lay(
    samples: &mut Vec<Sample>,
    from: &End,
    to: &End,
    way: Option<([FormerPlace; 2], &Past)>,
) {
    let chord_px = vec2::distance(from.at, to.at);
    let width_px = [from, to].map(|end| end.width_px);
    let way_px = way.map_or(chord_px, |([a, b], past)| {
        past.ropes()[a.rope as usize]
            .way_px(&a, &b, a.ahead)
            .max(chord_px)
    });
    let step_px = (0.125 * (width_px[0] + width_px[1])).clamp(0.75, 4.0);
    let count = (way_px / step_px).ceil().max(1.0) as usize;
    let at = between(from, to, way);
    for k in 1..count {
        let t = k as f32 / count as f32;
        samples.push(Sample {
            at: at(t),
            weight: 0.0,
            width_px: width_px[0] + t * (width_px[1] - width_px[0]),
            side: 0.0,
        });
    }
}

/// Length of a way from 0 to 1.
pub(crate) fn length_px(at: impl Fn(f32) -> Vec2) -> f32 {
    const PIECES: usize = 12;
    let at = |k: usize| at(k as f32 / PIECES as f32);
    (0..PIECES).map(|k| vec2::distance(at(k), at(k + 1))).sum()
}

/// Fraction, from 0 to 1, by which a hidden way must move toward a plain way to become `spare_px`
/// shorter.
pub(crate) fn drawn_in(spare_px: f32, way_px: f32, plain_px: f32) -> f32 {
    match way_px - plain_px {
        longer_px if spare_px > 0.0 && longer_px > 0.0 => (spare_px / longer_px).min(1.0),
        _ => 0.0,
    }
}
