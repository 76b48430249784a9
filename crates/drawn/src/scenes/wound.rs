//! Ropes that are closer together than random ones: the figure-eight knot, coils, pairs of strands.

use super::layout::{Layout, Top, refined, room, tops, uncrossed_layout};
use super::line::{Line, Vec2, meetings, minus, norm};
use super::rules::bends_enough;
use super::shape::TRIAL_SEGMENTS;
use crate::rendered::portable::{cos_turns, sin_turns, smoothstep};
use lariat_portable::SplitMix64;

/// Smallest arc length between successive crossings of a figure-eight, in widths. Stiff ropes have
/// at least 2.9.
const LOBE_WIDTHS: std::ops::Range<f64> = 2.5..5.0;
/// Sine of the flattest crossing's angle in it (20°).
const FLATTEST: f64 = 0.342;
/// Minimum distance between a tip and any other strand, in widths.
const TIP_WIDTHS: f64 = 2.0;

/// Makes the picture of a figure-eight knot with four crossings, tightened as far as its lobes
/// allow.
pub(super) fn eight(random: &mut SplitMix64, size_px: Vec2, width_px: f64) -> Option<Layout> {
    let inner = random.uniform(1.4, 2.6);
    let scale_px = width_px * random.uniform(1.0, 2.2);
    let open = random.uniform(0.03, 0.12);
    let bumps = [(); 4].map(|()| [random.uniform(-0.16, 0.16), random.uniform(0.0, 1.0)]);
    let knots: Vec<Vec2> = (0..=TRIAL_SEGMENTS)
        .map(|i| {
            let turns = open + (1.0 - 2.0 * open) * i as f64 / TRIAL_SEGMENTS as f64;
            let mut radius = inner + cos_turns(2.0 * turns);
            for (k, [size, phase]) in bumps.iter().enumerate() {
                radius += size * sin_turns((k + 1) as f64 * turns + phase);
            }
            [cos_turns(3.0 * turns), sin_turns(3.0 * turns)].map(|c| scale_px * radius * c)
        })
        .collect();
    let line = Line::through(&placed(&knots, random, size_px)?, false, TRIAL_SEGMENTS);
    let found = meetings(std::slice::from_ref(&line), 0.0).meetings;
    let mut along_px: Vec<f64> = found.iter().flat_map(|m| m.along_px).collect();
    along_px.sort_by(f64::total_cmp);
    let lobes_px = along_px.windows(2).map(|pair| pair[1] - pair[0]);
    let least_widths = lobes_px.fold(f64::MAX, f64::min) / width_px;
    let is_eight = found.len() == 4 && found.iter().all(|m| m.sin >= FLATTEST);
    (is_eight && LOBE_WIDTHS.contains(&least_widths)).then_some(())?;
    let mut layout = laid(line, random, size_px, width_px)?;
    // In half of the pictures, the rope goes over and under alternately, as in the knot.
    if random.sign() > 0.0 {
        alternate(&mut layout.tops, &along_px);
    }
    Some(layout)
}

/// Makes the rope go over and under alternately. `along_px`: all positions of its crossings, in
/// order.
fn alternate(tops: &mut [Top], along_px: &[f64]) {
    for top in tops {
        let rank = along_px.partition_point(|&other| other < top.along_px[0] - 1.0);
        if !rank.is_multiple_of(2) {
            top.along_px.swap(0, 1);
        }
    }
}

/// Makes a coil of three to five loops. The offset between loops is so small that the overlaps of
/// neighboring loops merge.
pub(super) fn coil(random: &mut SplitMix64, size_px: Vec2, width_px: f64) -> Option<Layout> {
    let loops = (3 + random.next_u64() % 3) as f64;
    let radius_px = random.uniform(0.1, 0.2) * size_px[1];
    let pitch = random.uniform(0.35, 0.9);
    let squash = random.uniform(0.75, 1.0);
    let [often, phase] = [random.uniform(0.3, 0.9), random.uniform(0.0, 1.0)];
    // One tail comes in at the top and the other leaves there, both bent away from the coil.
    let tails = [(); 2].map(|()| random.uniform(0.8, 1.8));
    let knots: Vec<Vec2> = (0..=TRIAL_SEGMENTS)
        .map(|i| {
            let share = i as f64 / TRIAL_SEGMENTS as f64;
            // A turn is 2 π radii long.
            let tail_turns = tails.map(|tail| tail / (2.0 * std::f64::consts::PI));
            let all = tail_turns[0] + loops + tail_turns[1];
            let turns = share * all - tail_turns[0];
            let at = turns.clamp(0.0, loops);
            let beyond = 2.0 * std::f64::consts::PI * (turns - at);
            let radius = 1.0 + 0.08 * sin_turns(often * at + phase);
            let x = pitch * at + radius * sin_turns(at) + beyond;
            let y = radius * cos_turns(at) + 0.35 * beyond * beyond;
            [radius_px * x, radius_px * squash * y]
        })
        .collect();
    let line = Line::through(&placed(&knots, random, size_px)?, false, TRIAL_SEGMENTS);
    laid(line, random, size_px, width_px)
}

/// Makes two ropes in contact side by side over a long distance, which part at both ends of it.
pub(super) fn pair(random: &mut SplitMix64, size_px: Vec2, width_px: f64) -> Option<Layout> {
    let run_px = width_px * random.uniform(10.0, 25.0);
    let legs_px = [(); 2].map(|()| width_px * random.uniform(6.0, 12.0));
    let apart_widths = [(); 2].map(|()| random.uniform(3.0, 4.5));
    let together_widths = random.uniform(0.8, 0.98);
    let bends = [(); 2].map(|()| random.uniform(-0.25, 0.25));
    let length_px = legs_px[0] + run_px + legs_px[1];
    let step_px = length_px / TRIAL_SEGMENTS as f64;
    let mut spine = [0.0; 2];
    let mut sides = [Vec::new(), Vec::new()];
    for i in 0..=TRIAL_SEGMENTS {
        let along_px = i as f64 * step_px;
        let ends_px = [along_px, length_px - along_px];
        let mut widths = together_widths;
        for (k, end_px) in ends_px.into_iter().enumerate() {
            let parted = smoothstep(1.0 - end_px / legs_px[k]);
            widths += parted * (apart_widths[k] - together_widths);
        }
        let share = along_px / length_px;
        let turns = bends[0] * share + bends[1] * share * share;
        let [cos, sin] = [cos_turns(turns), sin_turns(turns)];
        for (side, sign) in sides.iter_mut().zip([-0.5, 0.5]) {
            let off_px = sign * width_px * widths;
            side.push([spine[0] - off_px * sin, spine[1] + off_px * cos]);
        }
        spine = [spine[0] + step_px * cos, spine[1] + step_px * sin];
    }
    let all = placed(&sides.concat(), random, size_px)?;
    let sides = all.chunks_exact(TRIAL_SEGMENTS + 1);
    let lines: Vec<Line> = sides
        .map(|side| refined(&Line::through(side, false, TRIAL_SEGMENTS)))
        .collect();
    let fits = |line: &Line| room(size_px, width_px).holds(line) && bends_enough(line, width_px);
    let is_parallel = meetings(&lines, 0.0).meetings.is_empty();
    (lines.iter().all(fits) && is_parallel).then(|| uncrossed_layout(lines, width_px))
}

/// Turns the points and moves them anywhere in the picture.
fn placed(points: &[Vec2], random: &mut SplitMix64, size_px: Vec2) -> Option<Vec<Vec2>> {
    let turns = random.uniform(0.0, 1.0);
    let (cos, sin) = (cos_turns(turns), sin_turns(turns));
    let mut turned: Vec<Vec2> = (points.iter())
        .map(|[x, y]| [cos * x - sin * y, sin * x + cos * y])
        .collect();
    for axis in 0..2 {
        let side = || turned.iter().map(|p| p[axis]);
        let (low, high) = (
            side().fold(f64::MAX, f64::min),
            side().fold(f64::MIN, f64::max),
        );
        let spare_px = size_px[axis] - (high - low);
        (spare_px > 0.0).then_some(())?;
        let shift_px = random.uniform(0.0, spare_px) - low;
        turned.iter_mut().for_each(|p| p[axis] += shift_px);
    }
    Some(turned)
}

/// Makes the layout of one line if the picture and the rope's stiffness allow it and its tips are
/// free.
fn laid(line: Line, random: &mut SplitMix64, size_px: Vec2, width_px: f64) -> Option<Layout> {
    let is_free = |tip: Vec2, along_px: f64| {
        (line.points.iter().enumerate()).all(|(i, &p)| {
            let apart_px = (i as f64 * line.step_px - along_px).abs();
            apart_px < 2.0 * TIP_WIDTHS * width_px || norm(minus(p, tip)) > TIP_WIDTHS * width_px
        })
    };
    let tips_free = is_free(line.points[0], 0.0)
        && is_free(line.points[line.points.len() - 1], line.length_px());
    let fits = room(size_px, width_px).holds(&line) && bends_enough(&line, width_px);
    (fits && tips_free).then_some(())?;
    let lines = vec![refined(&line)];
    let found = meetings(&lines, 0.0);
    Some(Layout {
        tops: tops(&found, random),
        ..uncrossed_layout(lines, width_px)
    })
}
