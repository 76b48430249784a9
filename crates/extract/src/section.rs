//! Cross-sections: where across a rope its two edges lie, between pixels.
//!
//! A rope's edge is where the difference from the table is half of the rope's own there: the lens spreads
//! an edge evenly to both sides, so that point stays in place, whatever the sharpness and however
//! bright the rope is. The own difference is the median of the sections around, so that one speck of
//! shine does not move an edge, times what [`Shading`] says is left of it at the rim.

use crate::line::Line;
use crate::plane::Plane;
use crate::shading::Shading;
use crate::vec2::{self, Vec2};

/// Half-widths to each side, beyond 3 px, that an edge is looked for.
const REACH: f32 = 1.6;
/// The same in an overlap, where the other strand may lie in between.
const BESIDE: f32 = 3.4;
/// The part of a half-width around the center where no edge is looked for: shine lies there.
const CORE: f32 = 0.35;

/// Memory of the measuring.
#[derive(Debug, Default)]
pub(crate) struct Sections {
    contrast: Vec<f32>,
    window: Vec<f32>,
    /// What was found at which sample.
    found: Vec<(usize, Option<Found>)>,
}

/// The middle and the width of one section.
#[derive(Clone, Copy, Debug)]
struct Found {
    center: Vec2,
    width_px: f32,
}

/// How the sections of one line are taken.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Measure {
    /// Half the rope's width, as known so far.
    pub(crate) half_px: f32,
    /// Distance between the line's samples.
    pub(crate) step_px: f32,
    /// How much a section's width may differ from the rope's, as a factor.
    pub(crate) tolerance: f32,
    /// At which share of the rope's contrast its edges lie.
    pub(crate) shading: Shading,
}

impl Sections {
    /// Moves each sample of `line` that lies outside of crossings to the middle of its section and
    /// gives it its width; weights 0 are left alone, and set where a section makes no sense.
    pub(crate) fn measure(&mut self, line: &mut Line, difference: &Plane, how: Measure) {
        self.measure_ends(line, difference, how, line.samples.len());
    }

    /// As [`measure`](Self::measure), only for the `count` samples at either end.
    pub(crate) fn measure_ends(
        &mut self,
        line: &mut Line,
        difference: &Plane,
        how: Measure,
        count: usize,
    ) {
        self.measure_contrast(line, difference, how);
        let reach = ((how.half_px / how.step_px) as usize).max(2);
        self.found.clear();
        let n = line.samples.len();
        let (first, last) = (count.min(n), n.saturating_sub(count).max(count.min(n)));
        for i in (0..first).chain(last..n) {
            let sample = line.samples[i];
            let normal = vec2::normal(line.tangent(i, reach));
            let contrast = self.contrast_near(i, line, how);
            let levels = how.shading.shares.map(|share| share * contrast);
            let overlap = sample.weight < 1.0;
            let reach_px = if overlap { BESIDE } else { REACH } * how.half_px + 3.0;
            let seen = sample.weight > 0.0;
            let edges =
                seen.then(|| edges(difference, sample.at, normal, levels, how.half_px, reach_px));
            let found = edges.flatten().map(|[left, right]| {
                // Of two strands side by side, this one lies half the rest of the width aside.
                let rest = (left + right - 2.0 * how.half_px).max(0.0);
                let (aside, width_px) = if overlap {
                    (0.5 * sample.side * rest, (left + right - rest).max(0.1))
                } else {
                    (0.0, left + right)
                };
                let far = rest > 2.4 * how.half_px;
                Found {
                    center: vec2::along(sample.at, normal, 0.5 * (right - left) + aside),
                    width_px: if overlap && far { 0.0 } else { width_px },
                }
            });
            self.found.push((i, found));
        }
        let expected = 2.0 * how.half_px;
        let plausible = expected / how.tolerance..expected * how.tolerance;
        for &(i, found) in &self.found {
            let sample = &mut line.samples[i];
            match found {
                Some(found) if plausible.contains(&found.width_px) => {
                    (sample.at, sample.width_px) = (found.center, found.width_px);
                }
                _ => sample.weight = 0.0,
            }
        }
    }

    /// The rope's own difference from the table at each sample.
    fn measure_contrast(&mut self, line: &Line, difference: &Plane, how: Measure) {
        let reach = ((how.half_px / how.step_px) as usize).max(2);
        self.contrast.clear();
        for (i, sample) in line.samples.iter().enumerate() {
            let normal = vec2::normal(line.tangent(i, reach));
            let sum: f32 = [-0.5, -0.25, 0.0, 0.25, 0.5]
                .iter()
                .map(|k| difference.sample(vec2::along(sample.at, normal, k * how.half_px)))
                .sum();
            self.contrast.push(sum / 5.0);
        }
    }

    /// The median contrast of the visible samples within three widths.
    fn contrast_near(&mut self, i: usize, line: &Line, how: Measure) -> f32 {
        let reach = ((6.0 * how.half_px / how.step_px) as usize).max(4);
        let stride = (reach / 6).max(1);
        let n = line.samples.len();
        self.window.clear();
        for k in (0..=2 * reach).step_by(stride) {
            let Some(j) = (i + k).checked_sub(reach) else {
                continue;
            };
            if j < n && line.samples[j].weight > 0.0 {
                self.window.push(self.contrast[j]);
            }
        }
        if self.window.is_empty() {
            return self.contrast[i].max(2.0);
        }
        crate::background::median(&mut self.window).max(2.0)
    }
}

/// The distances along −`normal` and +`normal` at which the difference falls below each level. Where the image ends
/// before one edge, the other and the rope's width tell.
fn edges(
    difference: &Plane,
    center: Vec2,
    normal: Vec2,
    levels: [f32; 2],
    half_px: f32,
    reach_px: f32,
) -> Option<[f32; 2]> {
    let outward = [vec2::scale(normal, -1.0), normal];
    let found = [0, 1].map(|side| {
        edge(
            difference,
            center,
            outward[side],
            levels[side],
            half_px,
            reach_px,
        )
    });
    match found {
        [Edge::At(left), Edge::At(right)] => Some([left, right]),
        [Edge::At(left), Edge::OutOfImage] => Some([left, 2.0 * half_px - left]),
        [Edge::OutOfImage, Edge::At(right)] => Some([2.0 * half_px - right, right]),
        _ => None,
    }
}

/// One edge of a section, at a distance from its center.
#[derive(Clone, Copy, Debug)]
enum Edge {
    At(f32),
    OutOfImage,
    OutOfReach,
}

fn edge(
    difference: &Plane,
    center: Vec2,
    out: Vec2,
    level: f32,
    half_px: f32,
    reach_px: f32,
) -> Edge {
    let step = (half_px / 12.0).max(0.5);
    let mut at = CORE * half_px;
    let mut before = difference.sample(vec2::along(center, out, at));
    while at < reach_px {
        let next = at + step;
        let place = vec2::along(center, out, next);
        if !difference.holds(place) {
            return Edge::OutOfImage;
        }
        let value = difference.sample(place);
        if value < level {
            let part = if before > value {
                ((before - level) / (before - value)).max(0.0)
            } else {
                0.0
            };
            return Edge::At(at + part * step);
        }
        (at, before) = (next, value);
    }
    Edge::OutOfReach
}

/// How far the rope goes on along the path `at` (a position for each distance), at most `limit_px`:
/// the distance of the tip, and whether the image's border cuts it.
pub(crate) fn tip(
    difference: &Plane,
    at: impl Fn(f32) -> Vec2,
    level: f32,
    limit_px: f32,
) -> (f32, bool) {
    const STEP: f32 = 0.5;
    let mut before = difference.sample(at(0.0));
    let mut far = 0.0;
    while far < limit_px {
        let p = at(far + STEP);
        let value = difference.sample(p);
        if value < level {
            let fall = before - value;
            let part = if fall > 0.0 {
                ((before - level) / fall).clamp(0.0, 1.0)
            } else {
                0.0
            };
            return (far + STEP * part, false);
        }
        if !difference.holds(p) {
            return (far + STEP, true);
        }
        (far, before) = (far + STEP, value);
    }
    (far, false)
}
