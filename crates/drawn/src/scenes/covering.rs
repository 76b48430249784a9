//! A hand or a gripper that covers part of a rope.

use super::layout::Layout;
use super::line::{Line, Vec2, cross, dot, minus, mix, norm};
use super::paint::Painted;
use super::style::{Rgb, Style};
use crate::rendered::portable::{cos_turns, sin_turns, smoothstep};
use lariat_portable::SplitMix64;

/// Number of places that are tried on a rope.
const TRIES: usize = 40;
/// Longest hidden stretch, in widths, and the largest turn of the rope on it.
const LONGEST_WIDTHS: f64 = 12.0;
const MOST_TURN: f64 = 0.7;
/// Distance between the hidden stretch and a tip or a crossing, in widths.
const CLEAR_WIDTHS: f64 = 4.0;
const SKIN: Rgb = [206.0, 158.0, 132.0];

/// The covered region: everything within half a width of the segment between two points.
#[derive(Debug, Clone, Copy)]
pub(super) struct Covering {
    ends: [Vec2; 2],
    half_px: f64,
    is_hand: bool,
}

impl Covering {
    /// Makes a covering that hides a stretch of the first rope and nothing else, if there is room.
    pub(super) fn over(layout: &Layout, random: &mut SplitMix64, size_px: Vec2) -> Option<Self> {
        let line = &layout.lines[0];
        let width_px = layout.width_px;
        (0..TRIES).find_map(|_| {
            let along_px = random.uniform(0.0, line.length_px());
            let tangent = line.tangent(along_px);
            let normal = [-tangent[1], tangent[0]].map(|c| random.sign() * c);
            let turns = random.uniform(-0.12, 0.12);
            let (cos, sin) = (cos_turns(turns), sin_turns(turns));
            let back = [
                cos * normal[0] - sin * normal[1],
                sin * normal[0] + cos * normal[1],
            ];
            let is_hand = random.sign() > 0.0;
            let half_px = width_px * random.uniform(1.3, 3.2);
            let ahead_px = width_px * random.uniform(0.5, 2.5);
            let reach_px = match is_hand {
                true => size_px[0] + size_px[1],
                false => width_px * random.uniform(5.0, 9.0),
            };
            let at = line.at(along_px);
            let ends = [-ahead_px, reach_px].map(|px| [0, 1].map(|k| at[k] + px * back[k]));
            let covering = Self {
                ends,
                half_px,
                is_hand,
            };
            covering.is_apt(layout, along_px).then_some(covering)
        })
    }

    /// Returns whether the covering hides a short stretch around this position and no other part of
    /// the rope.
    fn is_apt(&self, layout: &Layout, along_px: f64) -> bool {
        let (line, width_px): (&Line, f64) = (&layout.lines[0], layout.width_px);
        // The rope's half width, plus a rim in which the table is visible.
        let is_under = |px: f64| self.within_px(line.at(px)) > -1.5 * width_px;
        let walk = |sign: f64| {
            let steps = 0..(LONGEST_WIDTHS * width_px) as usize;
            let far = steps.map(|k| along_px + sign * k as f64);
            far.take_while(|&px| is_under(px))
                .last()
                .unwrap_or(along_px)
        };
        let [from_px, to_px] = [walk(-1.0), walk(1.0)];
        let clear_px = CLEAR_WIDTHS * width_px;
        let near = from_px - clear_px..to_px + clear_px;
        let turned = [line.tangent(from_px), line.tangent(to_px)];
        let turn = libm::atan2(cross(turned[0], turned[1]).abs(), dot(turned[0], turned[1]));
        let elsewhere = (0..line.segments()).map(|i| i as f64 * line.step_px);
        to_px - from_px <= LONGEST_WIDTHS * width_px
            && turn <= MOST_TURN
            && near.start > 0.0
            && near.end < line.length_px()
            && (layout.tops.iter().flat_map(|top| top.along_px)).all(|px| !near.contains(&px))
            && (elsewhere.filter(|px| !(from_px - 1.0..to_px + 1.0).contains(px)))
                .all(|px| !is_under(px))
    }

    /// Depth of a point inside the covering.
    fn within_px(&self, p: Vec2) -> f64 {
        let [a, b] = self.ends;
        let along = minus(b, a);
        let share = dot(minus(p, a), along) / dot(along, along);
        let round_px = self.half_px - norm(minus(p, mix(a, b, share.clamp(0.0, 1.0))));
        if self.is_hand {
            return round_px;
        }
        // A box, with straight ends.
        let length_px = norm(along);
        let across_px = self.half_px - (cross(minus(p, a), along) / length_px).abs();
        across_px.min(length_px * share.min(1.0 - share))
    }

    /// Draws the covering over the ropes, and reduces `seen`, the share of each pixel in which rope
    /// is visible.
    pub(super) fn paint(
        &self,
        painted: &mut Painted,
        seen: &mut [f32],
        width: usize,
        look: &Style,
    ) {
        // The gripper's gray contrasts with the table.
        let gray = if look.table[0] > 115.0 { 50.0 } else { 165.0 };
        let color = if self.is_hand { SKIN } else { [gray; 3] };
        for (i, seen) in seen.iter_mut().enumerate() {
            let within_px = self.within_px([(i % width) as f64, (i / width) as f64]);
            let share = (within_px + 0.5).clamp(0.0, 1.0) as f32;
            // A hand is round and darkens toward its rim.
            let light = match self.is_hand {
                true => 0.75 + 0.25 * smoothstep(within_px / self.half_px) as f32,
                false => 1.0,
            };
            for (value, color) in painted.light[i].iter_mut().zip(color) {
                *value += share * (light * color - *value);
            }
            painted.cover[i] += share * (1.0 - painted.cover[i]);
            *seen *= 1.0 - share;
        }
    }
}
