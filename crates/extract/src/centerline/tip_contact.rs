//! Finds the end of a tip that touches another strand, or is slightly on top of it.
//!
//! A square tip is seldom flush with the strand. Next to the corner that touches, the table shows
//! between the cut and the strand. Lines along the rope that meet this gap tell where the cut is.
//! If no table shows, the tip ends at the strongest step of brightness at the strand's near edge,
//! or soon after it.

use crate::graph::Graph;
use crate::graph::strands::Leg;
use crate::graph::zones::Zones;
use crate::image::gray::GrayPlane;
use crate::statistics::quantile;
use crate::vec2::{self, Vec2};

/// Number of lines along the rope to each side of its middle, and their distance in half-widths.
const LINES: i32 = 3;
const APART_HALVES: f32 = 0.2;
/// Step along the lines, in pixels.
const STEP_PX: f32 = 0.5;
/// Maximum part of the strand's width that a tip covers. A longer tip would show as an end on the
/// other side.
const UPON: f32 = 0.6;
/// The first step with at least this share of the strongest is taken.
const FIRST: f32 = 0.5;
/// Minimum step of brightness, in levels. A smaller one is noise.
const LEAST_STEP: f32 = 4.0;

/// The strand that a tip touches, as a straight band.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Contact {
    on: Vec2,
    along: Vec2,
    half_px: f32,
}

impl Contact {
    /// The strand at which leg `leg` ends, at its first end (0) or its last (1) in the rope's
    /// order. `None` if it ends freely.
    pub(crate) fn at(leg: &Leg, end: u8, graph: &Graph, zones: &Zones) -> Option<Self> {
        let end = end ^ u8::from(leg.reversed);
        let own = zones.arm_at(2 * leg.edge as usize + usize::from(end))?;
        let node = graph.edges[leg.edge as usize].nodes[usize::from(end)];
        if graph.nodes[node as usize].degree < 3 {
            return None;
        }
        let in_zone = zones.arms_of(zones.arms[own].zone);
        let from = in_zone.start;
        let arms = &zones.arms[in_zone];
        // The strand is the two other arms that are most nearly in line.
        let mut best: Option<(f32, Self)> = None;
        for (i, a) in arms.iter().enumerate() {
            for (j, b) in arms.iter().enumerate().skip(i + 1) {
                let opposite = vec2::dot(a.into, b.into);
                let better = best.is_none_or(|(least, _)| opposite < least);
                if from + i == own || from + j == own || !better {
                    continue;
                }
                let contact = Self {
                    on: a.at,
                    along: vec2::unit_or(vec2::sub(b.at, a.at), a.into),
                    half_px: 0.5 * (a.half_px + b.half_px),
                };
                best = Some((opposite, contact));
            }
        }
        best.filter(|&(opposite, _)| opposite < -0.5)
            .map(|(_, contact)| contact)
    }

    fn holds(&self, at: Vec2) -> bool {
        vec2::cross(self.along, vec2::sub(at, self.on)).abs() <= self.half_px
    }

    /// The distance along `path` at which the tip ends, at most `limit_px`. The rope has half-width
    /// `half_px` and contrast `level`. `scratch` is working memory.
    pub(crate) fn tip(
        &self,
        difference: &GrayPlane,
        path: &impl Fn(f32) -> Vec2,
        (half_px, level, limit_px): (f32, f32, f32),
        scratch: &mut Vec<f32>,
    ) -> f32 {
        let place = |far: f32, line: i32| {
            let ahead = vec2::sub(path(far + 0.5), path(far - 0.5));
            let normal = vec2::normal(vec2::unit_or(ahead, [1.0, 0.0]));
            vec2::along(path(far), normal, APART_HALVES * half_px * line as f32)
        };
        scratch.clear();
        let mut near = limit_px;
        for line in -LINES..=LINES {
            let mut far = -0.7 * half_px;
            let mut before = difference.sample(place(far, line));
            while far < limit_px {
                let at = place(far + STEP_PX, line);
                let value = difference.sample(at);
                if self.holds(at) {
                    if line == 0 {
                        near = far;
                    }
                    break;
                }
                if before >= level && value < level {
                    scratch.push(far + STEP_PX * (before - level) / (before - value));
                    break;
                }
                (far, before) = (far + STEP_PX, value);
            }
        }
        if scratch.len() >= 2 {
            // In the narrow end of the wedge, blur hides where the table begins. Its open end shows
            // the cut.
            return quantile(scratch, 0.25).max(0.0);
        }
        let across = |far: f32| -> f32 {
            let lines = (-LINES..=LINES).map(|line| difference.sample(place(far, line)));
            lines.sum::<f32>() / (2 * LINES + 1) as f32
        };
        let step_at = |far: f32| (across(far + 1.0) - across(far - 1.0)).abs();
        let last = (near + UPON * 2.0 * self.half_px).min(limit_px);
        let places = || {
            (0..)
                .map(|k| near - 1.0 + STEP_PX * k as f32)
                .take_while(|&far| far <= last)
        };
        let strongest = places().map(step_at).fold(LEAST_STEP, f32::max);
        // Takes the first step of about this strength, because the strand's own shades follow
        // behind the cut.
        let mut best = (0.0, near);
        for far in places() {
            let step = step_at(far);
            if step > best.0 && step >= FIRST * strongest {
                best = (step, far);
            } else if best.0 > 0.0 {
                break;
            }
        }
        best.1.max(0.0)
    }
}
