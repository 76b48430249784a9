//! Ropes that leave the image.

use super::layout::{Layout, finish, refined, room, tops};
use super::line::{Line, Vec2, dot, minus, norm};
use super::rules::{Rules, bends_enough, crossings_as_asked};
use super::shape::{self, Room};
use lariat_portable::SplitMix64;

/// Makes a rope with one or both ends outside the image. It leaves the image once at each of these
/// ends.
pub(super) fn leaving(
    rules: &Rules,
    random: &mut SplitMix64,
    size_px: Vec2,
    width_px: f64,
) -> Option<Layout> {
    let outside = Room {
        size_px,
        margin_px: -random.uniform(0.1, 0.3) * size_px[0].min(size_px[1]),
    };
    let swing = random.uniform(0.0, 0.6);
    let line = shape::open(random, outside, swing);
    let layout = cut_off(&line, rules, random, size_px, width_px)?;
    (layout.border != [[false; 2]]).then_some(layout)
}

/// Makes a rope that is pulled tight through the image.
pub(super) fn taut(
    rules: &Rules,
    random: &mut SplitMix64,
    size_px: Vec2,
    width_px: f64,
) -> Option<Layout> {
    let line = shape::taut(random, size_px);
    let layout = cut_off(&line, rules, random, size_px, width_px)?;
    (layout.border == [[true; 2]]).then_some(layout)
}

/// Makes a rope with a bend up to three and a half widths outside the image. Its visible parts
/// point to the bend.
pub(super) fn returning(
    rules: &Rules,
    random: &mut SplitMix64,
    size_px: Vec2,
    width_px: f64,
) -> Option<Layout> {
    let swing = random.uniform(rules.swing[0], rules.swing[1]);
    let room = room(size_px, width_px);
    let mut line = shape::open(random, room, swing);
    let axis = usize::from(random.sign() > 0.0);
    let is_far = random.sign() > 0.0;
    let over_px = width_px * random.uniform(1.0, 3.5);
    let along = line.points.iter().map(|p| p[axis]);
    let shift_px = match is_far {
        true => size_px[axis] - 1.0 + over_px - along.fold(f64::MIN, f64::max),
        false => -over_px - along.fold(f64::MAX, f64::min),
    };
    line.points.iter_mut().for_each(|p| p[axis] += shift_px);
    let line = refined(&line);
    let is_out = |p: &Vec2| p[axis] < 0.0 || p[axis] > size_px[axis] - 1.0;
    let first = line.points.iter().position(is_out)?;
    let last = line.points.iter().rposition(is_out)?;
    let [from_px, to_px] = [first, last].map(|i| i as f64 * line.step_px);
    let is_one = line.points[first..=last].iter().all(is_out);
    let chord_px = norm(minus(line.points[last], line.points[first]));
    let facing = dot(line.tangent(from_px), line.tangent(to_px));
    if !is_one || chord_px > 14.0 * width_px || facing < 0.0 || !bends_enough(&line, width_px) {
        return None;
    }
    // Elsewhere the rope stays away from the border, and so do its tips and crossings.
    let clear_px = 6.0 * width_px;
    let is_clear = |along_px: f64, at: Vec2| {
        let near_exit = along_px > from_px - clear_px && along_px < to_px + clear_px;
        near_exit || (0..2).all(|k| at[k].min(size_px[k] - 1.0 - at[k]) > room.margin_px)
    };
    let mut places = line.points.iter().enumerate();
    if from_px < clear_px
        || to_px > line.length_px() - clear_px
        || !places.all(|(i, &at)| is_clear(i as f64 * line.step_px, at))
    {
        return None;
    }
    let layout = finish(vec![line], width_px, rules, random)?;
    let is_off = |&along_px: &f64| along_px < from_px - clear_px || along_px > to_px + clear_px;
    let mut tops = layout.tops.iter();
    (tops.all(|top| top.along_px.iter().all(is_off))).then_some(layout)
}

/// Cuts a line to its part within the image, plus a margin.
fn cut_off(
    line: &Line,
    rules: &Rules,
    random: &mut SplitMix64,
    size_px: Vec2,
    width_px: f64,
) -> Option<Layout> {
    if !bends_enough(line, width_px) {
        return None;
    }
    // The image ends at the centers of its outermost pixels, because nothing is known beyond them.
    let is_in = |p: Vec2| (0..2).all(|k| p[k] >= 0.0 && p[k] <= size_px[k] - 1.0);
    let first = line.points.iter().position(|&p| is_in(p))?;
    let last = line.points.iter().rposition(|&p| is_in(p))?;
    let whole = line.points.len() - 1;
    let border = [first > 0, last < whole];
    let stays = line.points[first..=last].iter().all(|&p| is_in(p));
    if !stays {
        return None;
    }
    let clear_px = 4.0 * width_px;
    let [from_px, to_px] = [first, last].map(|i| i as f64 * line.step_px);
    let has_room = |is_out: bool, tail_px: f64| !is_out || tail_px > clear_px;
    if !has_room(border[0], from_px) || !has_room(border[1], line.length_px() - to_px) {
        return None;
    }
    let line = refined(&line.cut(
        if border[0] { from_px - clear_px } else { 0.0 },
        if border[1] {
            to_px + clear_px
        } else {
            line.length_px()
        },
    ));
    let seen_px = [seen_part(&line, is_in)?];
    let lines = [line];
    if !leaves_steeply(&lines[0], seen_px[0], border, size_px, width_px) {
        return None;
    }
    let found = crossings_as_asked(&lines, &seen_px, rules, width_px)?;
    Some(Layout {
        border: vec![border],
        tops: tops(&found, random),
        touches: Vec::new(),
        covering: None,
        lines: lines.to_vec(),
        width_px,
        seen_px: seen_px.to_vec(),
    })
}

/// Arc lengths at which a drawn line enters and leaves, to a hundredth of a step.
fn seen_part(line: &Line, is_in: impl Fn(Vec2) -> bool) -> Option<[f64; 2]> {
    let first = line.points.iter().position(|&p| is_in(p))?;
    let last = line.points.iter().rposition(|&p| is_in(p))?;
    let bisect = |mut inner_px: f64, mut outer_px: f64| {
        for _ in 0..8 {
            let middle_px = 0.5 * (inner_px + outer_px);
            if is_in(line.at(middle_px)) {
                inner_px = middle_px;
            } else {
                outer_px = middle_px;
            }
        }
        inner_px
    };
    let px = |i: usize| i as f64 * line.step_px;
    Some([
        if first > 0 {
            bisect(px(first), px(first - 1))
        } else {
            0.0
        },
        if last + 1 < line.points.len() {
            bisect(px(last), px(last + 1))
        } else {
            line.length_px()
        },
    ])
}

/// Returns whether the rope leaves at 40° or more and away from the corners, with its inner tips
/// away from the border.
fn leaves_steeply(
    line: &Line,
    seen_px: [f64; 2],
    border: [bool; 2],
    size_px: Vec2,
    width_px: f64,
) -> bool {
    let room = room(size_px, width_px);
    // Distances from the borders, and the axis of the nearest one.
    let nearest = |p: Vec2| {
        let to = [0, 1].map(|k| p[k].min(size_px[k] - 1.0 - p[k]));
        if to[0] < to[1] { (to, 0) } else { (to, 1) }
    };
    for end in 0..2 {
        let at = line.at(seen_px[end]);
        let (to, axis) = nearest(at);
        let fits = if border[end] {
            line.tangent(seen_px[end])[axis].abs() > 0.64 && to[1 - axis] > 2.5 * width_px
        } else {
            to[axis] > room.margin_px
        };
        if !fits {
            return false;
        }
    }
    // Elsewhere the rope stays away from the border.
    let clear_px = 3.0 * width_px;
    (0..line.points.len()).all(|i| {
        let along_px = i as f64 * line.step_px;
        let near_exit = (border[0] && along_px < seen_px[0] + clear_px)
            || (border[1] && along_px > seen_px[1] - clear_px);
        let (to, axis) = nearest(line.points[i]);
        near_exit || to[axis] > room.margin_px
    })
}
