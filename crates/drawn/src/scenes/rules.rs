//! Requirements of a class on its curves, and checks of these.

use std::ops::RangeInclusive;

use super::Class;
use super::line::{Found, Line, Meeting, meetings};
use lariat_portable::SplitMix64;

/// Minimum distance between the centers of strands that should not be close, in widths.
const CLEAR_WIDTHS: f64 = 2.0;
/// Radius of the tightest bend for thin ropes: 120 points must be able to represent it.
const LEAST_RADIUS_PX: f64 = 16.0;

/// Requirements of a class on its curves.
pub(super) struct Rules {
    pub(super) width_px: [f64; 2],
    crossings: RangeInclusive<usize>,
    /// Minimum and maximum of the sine of the flattest crossing's angle.
    sin: [f64; 2],
    pub(super) ropes: usize,
    pub(super) swing: [f64; 2],
}

impl Rules {
    pub(super) fn of(class: Class, random: &mut SplitMix64) -> Self {
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
            Class::Eights => rules.width_px = [10.5, 14.0],
            Class::OneColor => {
                rules.crossings = 2..=6;
                rules.sin = [0.342, 1.0];
                rules.ropes = 3 + (random.next_u64() % 2) as usize;
                rules.swing = [0.0, 0.3];
            }
            Class::Taut => rules.crossings = 0..=0,
            Class::Laid => {
                rules.crossings = 0..=1;
                rules.sin[0] = 0.5;
                rules.ropes = 1 + (random.next_u64() % 3) as usize;
            }
            composed if composed.is_composed() => {
                rules.crossings = 0..=3;
                rules.ropes = 1 + (random.next_u64() % 3) as usize;
                rules.swing = [0.0, 0.4];
            }
            _ => {}
        }
        rules
    }
}

/// Rules for this number of crossings above 30°, with ropes that are otherwise unrestricted.
pub(super) fn crossed(times: usize) -> Rules {
    Rules {
        width_px: [7.0, 14.0],
        crossings: times..=times,
        sin: [0.5, 1.0],
        ropes: 1,
        swing: [0.0, 0.5],
    }
}

/// Returns whether no bend is too tight for the rope.
pub(super) fn bends_enough(line: &Line, width_px: f64) -> bool {
    line.least_radius_px() >= (1.5 * width_px).max(LEAST_RADIUS_PX)
}

/// Returns the lines' crossings if they follow the rules: number, angles, distances from each other
/// and from the tips, and no strands close to each other elsewhere.
pub(super) fn crossings_as_asked(
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
    // Half of the length that a crossing covers along a strand: w/2 (1/sin θ + 1/tan θ).
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
            // Straight strands are 2w apart at w / sin(θ/2) from their crossing; bent ones at a
            // greater distance.
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
