//! How the ropes of a picture lie: random curves, drawn again until they show what their class is about and nothing
//! else that is hard.

use std::ops::RangeInclusive;

use super::Class;
use super::line::{Found, Line, Meeting, Vec2, meetings};
use super::shape::{self, Beside, Room};
use crate::rendered::portable::SplitMix64;

/// Steps of a drawn line: of 2000 px, one a pixel.
const SEGMENTS: usize = 2000;
/// After this many curves that would not do, the rope is made a little thinner, to a least width.
const PATIENCE: u32 = 150;
/// Curves tried in all. The hardest class needs some hundreds in a picture of 640×480.
const TRIES: u32 = 6000;
/// No bend is tighter, however thin the rope: 120 points must be able to say it.
const LEAST_RADIUS_PX: f64 = 16.0;
/// Between the centres of strands that are not meant to be near, in widths.
const CLEAR_WIDTHS: f64 = 2.0;

/// A strand over a strand: lines and arc lengths, the upper one first.
#[derive(Debug, Clone, Copy)]
pub(super) struct Top {
    pub(super) lines: [usize; 2],
    pub(super) along_px: [f64; 2],
    pub(super) at: Vec2,
    pub(super) angle_deg: f64,
}

/// The ropes' places.
#[derive(Debug)]
pub(super) struct Layout {
    pub(super) lines: Vec<Line>,
    pub(super) width_px: f64,
    /// The part of each line within the image, as arc lengths.
    pub(super) seen_px: Vec<[f64; 2]>,
    /// Which ends leave the image.
    pub(super) border: Vec<[bool; 2]>,
    pub(super) tops: Vec<Top>,
}

/// What a class asks of its curves.
struct Rules {
    width_px: [f64; 2],
    crossings: RangeInclusive<usize>,
    /// Sine of the flattest crossing, and of what the flattest one may be at most.
    sin: [f64; 2],
    ropes: usize,
    swing: [f64; 2],
}

impl Rules {
    fn of(class: Class, random: &mut SplitMix64) -> Self {
        let some = random.next_u64() as usize % 3;
        let mut rules = Self {
            width_px: [7.0, 14.0],
            crossings: some..=some,
            sin: [0.574, 1.0],
            ropes: 1,
            swing: [0.1, 0.7],
        };
        // At least 30°.
        let mut crossings = |count: usize, swing| {
            rules.crossings = count..=count;
            rules.sin[0] = 0.5;
            rules.swing = swing;
        };
        match class {
            Class::Crossings0 => crossings(0, [0.0, 0.4]),
            Class::Crossings1 => crossings(1, [0.2, 0.7]),
            Class::Crossings2 => crossings(2, [0.3, 0.9]),
            Class::Crossings3 => crossings(3, [0.4, 1.0]),
            Class::Crossings4 => crossings(4, [0.5, 1.0]),
            Class::Crossings5 => crossings(5, [0.6, 1.0]),
            Class::FlatCrossings => {
                rules.crossings = 1..=2;
                rules.sin = [0.342, 0.5];
                rules.swing = [0.2, 0.8];
            }
            Class::Thin => rules.width_px = [4.0, 6.0],
            Class::Medium => rules.width_px = [7.0, 15.0],
            Class::Thick => rules.width_px = [16.0, 30.0],
            Class::SeveralColors => {
                rules.crossings = 0..=3;
                rules.ropes = 2 + (random.next_u64() % 3) as usize;
                rules.swing = [0.0, 0.3];
            }
            _ => {}
        }
        rules
    }
}

/// Ropes for a picture of this class; nothing if none that fits was found.
pub(super) fn lay(class: Class, random: &mut SplitMix64, size_px: Vec2) -> Option<Layout> {
    let rules = Rules::of(class, random);
    // As drawn for 640×480; in smaller pictures ropes are thinner, down to the class's least width.
    let scale = (size_px[0].min(size_px[1]) / 480.0).min(1.0);
    let [least, most] = rules.width_px;
    let mut width_px = random.uniform(least, most);
    width_px = (width_px * scale).max(least);
    for trial in 1..=TRIES {
        if trial.is_multiple_of(PATIENCE) {
            width_px = (0.94 * width_px).max(least);
        }
        let laid = match class {
            Class::Touch => touching(random, size_px, width_px),
            Class::EndsNear | Class::EndsTouching => ending(class, random, size_px, width_px),
            Class::Border => leaving(&rules, random, size_px, width_px),
            _ => free(class, &rules, random, size_px, width_px),
        };
        if laid.is_some() {
            return laid;
        }
    }
    None
}

fn room(size_px: Vec2, width_px: f64) -> Room {
    Room {
        size_px,
        margin_px: width_px + 6.0,
    }
}

fn bends_enough(line: &Line, width_px: f64) -> bool {
    line.least_radius_px() >= (1.5 * width_px).max(LEAST_RADIUS_PX)
}

fn refined(line: &Line) -> Line {
    Line::through(&line.points, line.closed, SEGMENTS)
}

/// Ropes anywhere within the image.
fn free(
    class: Class,
    rules: &Rules,
    random: &mut SplitMix64,
    size_px: Vec2,
    width_px: f64,
) -> Option<Layout> {
    let room = room(size_px, width_px);
    let mut lines = Vec::new();
    for _ in 0..rules.ropes {
        let swing = random.uniform(rules.swing[0], rules.swing[1]);
        let mut line = if class == Class::Closed {
            shape::closed(random, room)
        } else {
            shape::open(random, room, swing)
        };
        if rules.ropes > 1 {
            // A part of it, so that several find room.
            let length_px = line.length_px() * random.uniform(0.45, 0.8);
            let from_px = random.uniform(0.0, line.length_px() - length_px);
            line = line.cut(from_px, from_px + length_px);
        }
        if !bends_enough(&line, width_px) || line.length_px() < 12.0 * width_px {
            return None;
        }
        lines.push(line);
    }
    let seen_px: Vec<[f64; 2]> = lines.iter().map(|line| [0.0, line.length_px()]).collect();
    crossings_as_asked(&lines, &seen_px, rules, width_px)?;
    let lines: Vec<Line> = lines.iter().map(refined).collect();
    finish(lines, width_px, rules, random)
}

/// The layout of drawn lines that lie within the image.
fn finish(
    lines: Vec<Line>,
    width_px: f64,
    rules: &Rules,
    random: &mut SplitMix64,
) -> Option<Layout> {
    let seen_px: Vec<[f64; 2]> = lines.iter().map(|line| [0.0, line.length_px()]).collect();
    let found = crossings_as_asked(&lines, &seen_px, rules, width_px)?;
    Some(Layout {
        border: vec![[false; 2]; lines.len()],
        tops: tops(&found, random),
        lines,
        width_px,
        seen_px,
    })
}

/// The crossings, each with a random strand on top.
fn tops(found: &Found, random: &mut SplitMix64) -> Vec<Top> {
    let top = |meeting: &Meeting| {
        let [a, b] = meeting.along_px;
        let [l, m] = meeting.lines;
        let (lines, along_px) = if random.sign() > 0.0 {
            ([l, m], [a, b])
        } else {
            ([m, l], [b, a])
        };
        Top {
            lines,
            along_px,
            at: meeting.at,
            angle_deg: 2.0 * meeting.sin_half.asin().to_degrees(),
        }
    };
    found.meetings.iter().map(top).collect()
}

/// The lines' crossings if they are as the rules ask: their number, angles, distances from each other and from the
/// tips, and no two strands near each other elsewhere.
fn crossings_as_asked(
    lines: &[Line],
    seen_px: &[[f64; 2]],
    rules: &Rules,
    width_px: f64,
) -> Option<Found> {
    let found = meetings(lines, CLEAR_WIDTHS * width_px);
    let [least, flattest] = rules.sin;
    let flat = found.meetings.iter().map(|m| m.sin).fold(1.0, f64::min);
    let is_asked = rules.crossings.contains(&found.meetings.len())
        && flat >= least
        && (found.meetings.is_empty() || flat <= flattest);
    if !is_asked {
        return None;
    }
    // Along a strand, half of what the crossing covers: w/2 (1/sin θ + 1/tan θ).
    let covered_px = |m: &Meeting| {
        0.5 * width_px * (1.0 + (1.0 - m.sin * m.sin).max(0.0).sqrt()) / m.sin.max(1e-6)
    };
    let mut places: Vec<(usize, f64, f64)> = Vec::new();
    for meeting in &found.meetings {
        for side in 0..2 {
            let line = meeting.lines[side];
            let along_px = meeting.along_px[side];
            let covered_px = covered_px(meeting);
            let keeps_off = |other_px: f64, other_covered_px: f64| {
                let mut apart_px = (along_px - other_px).abs();
                if lines[line].closed {
                    apart_px = apart_px.min(lines[line].length_px() - apart_px);
                }
                apart_px > covered_px + other_covered_px + width_px
            };
            let is_clear = places
                .iter()
                .all(|&(l, at_px, covered_px)| l != line || keeps_off(at_px, covered_px));
            let [from_px, to_px] = seen_px[line];
            let tips_clear =
                lines[line].closed || (keeps_off(from_px, width_px) && keeps_off(to_px, width_px));
            if !is_clear || !tips_clear {
                return None;
            }
            places.push((line, along_px, covered_px));
        }
    }
    let is_near_a_crossing = |of: [usize; 2], along_px: [f64; 2]| {
        found.meetings.iter().any(|m| {
            // Straight strands are 2w apart at w / sin(θ/2) from their crossing; bent ones farther on.
            let reach_px = 1.6 * width_px / m.sin_half.max(1e-6);
            m.lines == of && (0..2).all(|k| (m.along_px[k] - along_px[k]).abs() < reach_px)
        })
    };
    let near = &found.near;
    let is_clear = near
        .iter()
        .all(|&(of, at_px)| is_near_a_crossing(of, at_px));
    is_clear.then_some(found)
}

/// No crossing at all.
fn uncrossed() -> Rules {
    Rules {
        width_px: [7.0, 14.0],
        crossings: 0..=0,
        sin: [0.5, 1.0],
        ropes: 1,
        swing: [0.0, 0.5],
    }
}

fn touching(random: &mut SplitMix64, size_px: Vec2, width_px: f64) -> Option<Layout> {
    let room = room(size_px, width_px);
    let how = Beside {
        // In contact, or pressed together a little.
        together_px: width_px * random.uniform(0.88, 1.0),
        run_px: width_px * random.uniform(1.0, 4.0),
        apart_px: width_px * random.uniform(4.0, 7.0),
        parting_px: width_px * random.uniform(6.0, 10.0),
    };
    let joined = random.sign() > 0.0;
    let (lines, _) = shape::beside(random, room, how, joined);
    let lines: Vec<Line> = lines.iter().map(refined).collect();
    let fits = |line: &Line| room.holds(line) && bends_enough(line, width_px);
    if !lines.iter().all(fits) || !meetings(&lines, 0.0).meetings.is_empty() {
        return None;
    }
    Some(Layout {
        seen_px: lines.iter().map(|line| [0.0, line.length_px()]).collect(),
        border: vec![[false; 2]; lines.len()],
        tops: Vec::new(),
        lines,
        width_px,
    })
}

/// A tip near a strand: half of the time beside one of another rope, else pointing at one of its own.
fn ending(class: Class, random: &mut SplitMix64, size_px: Vec2, width_px: f64) -> Option<Layout> {
    let gap_px = if class == Class::EndsNear {
        (width_px * random.uniform(0.3, 2.0)).max(1.5)
    } else {
        -width_px * random.uniform(0.0, 0.3)
    };
    let room = room(size_px, width_px);
    if class == Class::EndsNear && random.sign() > 0.0 {
        let how = Beside {
            together_px: width_px + gap_px,
            run_px: width_px * random.uniform(2.0, 6.0),
            apart_px: width_px * random.uniform(4.5, 7.0),
            parting_px: width_px * random.uniform(6.0, 10.0),
        };
        let (mut lines, run_px) = shape::beside(random, room, how, false);
        let end_px = random.uniform(run_px[0] + width_px, run_px[1]);
        lines[1] = lines[1].cut(0.0, end_px);
        let lines: Vec<Line> = lines.iter().map(refined).collect();
        let fits = |line: &Line| room.holds(line) && bends_enough(line, width_px);
        return (lines.iter().all(fits) && meetings(&lines, 0.0).meetings.is_empty())
            .then(|| uncrossed_layout(lines, width_px));
    }
    // A rope with one crossing, cut off shortly before it gets there the second time.
    let rules = Rules {
        crossings: 1..=1,
        sin: [0.5, 1.0],
        ..uncrossed()
    };
    let swing = random.uniform(0.2, 0.6);
    let line = shape::open(random, room, swing);
    if !bends_enough(&line, width_px) {
        return None;
    }
    let seen_px = [[0.0, line.length_px()]];
    let lines = [line];
    let found = crossings_as_asked(&lines, &seen_px, &rules, width_px)?;
    let [line] = lines;
    let crossing = found.meetings.first()?;
    // The tip's nearer corner is ahead of its middle by w/2 / tan θ.
    let lean = (1.0 - crossing.sin * crossing.sin).max(0.0).sqrt() / crossing.sin;
    let back_px = (0.5 * width_px + gap_px) / crossing.sin + 0.5 * width_px * lean;
    let cut = line.cut(0.0, crossing.along_px[1] - back_px);
    (cut.length_px() > 12.0 * width_px).then(|| uncrossed_layout(vec![refined(&cut)], width_px))
}

fn uncrossed_layout(lines: Vec<Line>, width_px: f64) -> Layout {
    Layout {
        seen_px: lines.iter().map(|line| [0.0, line.length_px()]).collect(),
        border: vec![[false; 2]; lines.len()],
        tops: Vec::new(),
        lines,
        width_px,
    }
}

/// A rope of which one end or both lie outside of the image; it goes out once at each.
fn leaving(rules: &Rules, random: &mut SplitMix64, size_px: Vec2, width_px: f64) -> Option<Layout> {
    let outside = Room {
        size_px,
        margin_px: -random.uniform(0.1, 0.3) * size_px[0].min(size_px[1]),
    };
    let swing = random.uniform(0.0, 0.6);
    let line = shape::open(random, outside, swing);
    if !bends_enough(&line, width_px) {
        return None;
    }
    // The image ends where its outermost pixels' centres are: beyond them nothing is known.
    let is_in = |p: Vec2| (0..2).all(|k| p[k] >= 0.0 && p[k] <= size_px[k] - 1.0);
    let first = line.points.iter().position(|&p| is_in(p))?;
    let last = line.points.iter().rposition(|&p| is_in(p))?;
    let whole = line.points.len() - 1;
    let border = [first > 0, last < whole];
    let stays = line.points[first..=last].iter().all(|&p| is_in(p));
    if border == [false; 2] || !stays {
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
