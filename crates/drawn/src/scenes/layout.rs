//! Layout of the ropes in a picture: random curves, drawn until they show the difficulty of their
//! class and no other.

use super::Class;
use super::covering::Covering;
use super::leaving::{leaving, returning, taut};
use super::line::{Found, Line, Meeting, Vec2, meetings};
use super::rules::{Rules, bends_enough, crossed, crossings_as_asked};
use super::shape::{self, Beside, Room};
use super::thing;
use super::wound;
use lariat_portable::SplitMix64;

/// Number of segments of a drawn line: one per pixel for 2000 px.
const SEGMENTS: usize = 2000;
/// Number of rejected curves after which the rope becomes slightly thinner, down to a minimum
/// width.
const PATIENCE: u32 = 150;
/// Maximum number of curves tried. The hardest class needs some hundreds in a picture of 640×480.
const TRIES: u32 = 6000;

/// A strand over another strand: lines and arc lengths, the upper one first.
#[derive(Debug, Clone, Copy)]
pub(super) struct Top {
    pub(super) lines: [usize; 2],
    pub(super) along_px: [f64; 2],
    pub(super) at: Vec2,
    pub(super) angle_deg: f64,
}

/// Positions of the ropes.
#[derive(Debug)]
pub(super) struct Layout {
    pub(super) lines: Vec<Line>,
    pub(super) width_px: f64,
    /// Part of each line within the image, as arc lengths.
    pub(super) seen_px: Vec<[f64; 2]>,
    /// True for each end that leaves the image.
    pub(super) border: Vec<[bool; 2]>,
    pub(super) tops: Vec<Top>,
    pub(super) touches: Vec<Touch>,
    /// Object that covers part of a rope.
    pub(super) covering: Option<Covering>,
}

/// Two strands side by side in contact: their lines, and the middle and half the length of the
/// contact on each.
#[derive(Debug, Clone, Copy)]
pub(super) struct Touch {
    pub(super) lines: [usize; 2],
    pub(super) along_px: [f64; 2],
    pub(super) reach_px: [f64; 2],
}

/// Makes ropes for a picture of this class; `None` if none fits.
pub(super) fn lay(class: Class, random: &mut SplitMix64, size_px: Vec2) -> Option<Layout> {
    let rules = Rules::of(class, random);
    // The width is for 640×480. Smaller pictures have thinner ropes, down to the class's minimum
    // width.
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
            Class::Parallel => wound::pair(random, size_px, width_px),
            Class::Eights => wound::eight(random, size_px, width_px),
            Class::Coils => wound::coil(random, size_px, width_px),
            Class::Covered => free(class, &rules, random, size_px, width_px).and_then(|layout| {
                let covering = Covering::over(&layout, random, size_px)?;
                Some(Layout {
                    covering: Some(covering),
                    ..layout
                })
            }),
            Class::EndsNear | Class::EndsTouching => ending(class, random, size_px, width_px),
            Class::Border => leaving(&rules, random, size_px, width_px),
            Class::Returning => returning(&rules, random, size_px, width_px),
            Class::Taut => taut(&rules, random, size_px, width_px),
            Class::Laid => laid_out(&rules, random, size_px, width_px),
            // The object is in the rest of the picture.
            Class::Things => {
                let left_px = [thing::FROM * size_px[0], size_px[1]];
                free(class, &rules, random, left_px, width_px)
            }
            _ => free(class, &rules, random, size_px, width_px),
        };
        if laid.is_some() {
            return laid;
        }
    }
    None
}

pub(super) fn room(size_px: Vec2, width_px: f64) -> Room {
    Room {
        size_px,
        margin_px: width_px + 6.0,
    }
}

pub(super) fn refined(line: &Line) -> Line {
    Line::through(&line.points, line.closed, SEGMENTS)
}

/// Makes ropes anywhere within the image.
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
            // Uses only a part of the line, so that several ropes have room.
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

/// Makes ropes that are straight or evenly bent.
fn laid_out(
    rules: &Rules,
    random: &mut SplitMix64,
    size_px: Vec2,
    width_px: f64,
) -> Option<Layout> {
    let room = room(size_px, width_px);
    let lines: Vec<Line> = (0..rules.ropes)
        .map(|_| refined(&shape::even(random, size_px, width_px)))
        .collect();
    let fits = |line: &Line| room.holds(line) && bends_enough(line, width_px);
    lines.iter().all(fits).then_some(())?;
    finish(lines, width_px, rules, random)
}

/// Makes the layout of lines that are completely inside the image, if their crossings follow the
/// rules.
pub(super) fn finish(
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
        touches: Vec::new(),
        covering: None,
        lines,
        width_px,
        seen_px,
    })
}

/// Makes two strands that run next to each other in contact.
fn touching(random: &mut SplitMix64, size_px: Vec2, width_px: f64) -> Option<Layout> {
    let room = room(size_px, width_px);
    let how = Beside {
        // In contact, or pressed together slightly.
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
    let touch = touch(&lines, width_px)?;
    Some(Layout {
        touches: vec![touch],
        ..uncrossed_layout(lines, width_px)
    })
}

/// Finds the stretch where two strands touch. It ends where 0.6 widths of table are visible between
/// them.
fn touch(lines: &[Line], width_px: f64) -> Option<Touch> {
    let near = meetings(lines, 1.6 * width_px).near;
    let (lines, _) = *near.first()?;
    let span = |side: usize| {
        let along = near.iter().map(|(_, along_px)| along_px[side]);
        let (low, high) = (
            along.clone().fold(f64::MAX, f64::min),
            along.fold(0.0, f64::max),
        );
        (0.5 * (low + high), 0.5 * (high - low))
    };
    let [(a, reach_a), (b, reach_b)] = [span(0), span(1)];
    Some(Touch {
        lines,
        along_px: [a, b],
        reach_px: [reach_a, reach_b],
    })
}

/// Makes a tip near a strand: half of the time next to a strand of another rope, otherwise pointing
/// at a strand of its own rope.
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
    // A rope with one crossing, which is cut off shortly before it passes the crossing for the
    // second time.
    let rules = crossed(1);
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

pub(super) fn uncrossed_layout(lines: Vec<Line>, width_px: f64) -> Layout {
    Layout {
        seen_px: lines.iter().map(|line| [0.0, line.length_px()]).collect(),
        border: vec![[false; 2]; lines.len()],
        tops: Vec::new(),
        touches: Vec::new(),
        covering: None,
        lines,
        width_px,
    }
}

/// Crossings, each with a random strand on top.
pub(super) fn tops(found: &Found, random: &mut SplitMix64) -> Vec<Top> {
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
