//! Ropes that leave the image.

use super::layout::{Layout, refined, room, tops};
use super::line::{Line, Vec2};
use super::rules::{Rules, bends_enough, crossings_as_asked};
use super::shape::{self, Room};
use lariat_portable::SplitMix64;

/// A rope of which one end or both lie outside of the image; it goes out once at each.
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

/// A rope that is pulled tight through the image.
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

/// What of a line lies within the image, and a little more.
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
    // The image ends where its outermost pixels' centres are: beyond them nothing is known.
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

/// Where a drawn line enters and leaves, to a hundredth of a step.
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

/// Whether a rope leaves at 40° or more, off the corners, and whether its tips inside keep off the border.
fn leaves_steeply(
    line: &Line,
    seen_px: [f64; 2],
    border: [bool; 2],
    size_px: Vec2,
    width_px: f64,
) -> bool {
    let room = room(size_px, width_px);
    // Distance from the nearest border, and across which axis that is.
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
    // Elsewhere it keeps off.
    let clear_px = 3.0 * width_px;
    (0..line.points.len()).all(|i| {
        let along_px = i as f64 * line.step_px;
        let near_exit = (border[0] && along_px < seen_px[0] + clear_px)
            || (border[1] && along_px > seen_px[1] - clear_px);
        let (to, axis) = nearest(line.points[i]);
        near_exit || to[axis] > room.margin_px
    })
}
