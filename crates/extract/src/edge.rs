//! The two edges of a rope in one of its cross-sections: where, from its middle outward, the difference falls below a
//! level. A few places about where the rope's width says that they lie are read at once, for both edges of many sections;
//! that is enough for nearly all. The rest is sought step by step.

use crate::plane::Plane;
use crate::ray::{LANES, Lanes, Ray};
use crate::vec2::{self, Vec2};

/// The part of a half-width around the center where no edge is looked for: shine lies there.
const CORE: f32 = 0.35;
/// The least distance between places that are read: over a whole pixel a sharp edge is no straight line, and 0.01 px would
/// be lost.
const STEP_PX: f32 = 0.5;

/// The distances along −`normal` and +`normal` at which the difference falls below each level, those that are not
/// `known` (not a number). Where the image ends before one edge, the other and the rope's width tell.
#[inline(always)]
pub(crate) fn edges(
    difference: &Plane,
    (center, normal): (Vec2, Vec2),
    levels: [f32; 2],
    known: [f32; 2],
    seek: Seek,
    [half_px, reach_px]: [f32; 2],
) -> Option<[f32; 2]> {
    let ray = Ray::new(difference, center, normal, reach_px + step_px(half_px));
    let mut found = known.map(Edge::At);
    for (k, side) in [-1.0, 1.0].into_iter().enumerate() {
        if !known[k].is_nan() {
            continue;
        }
        found[k] = match &ray {
            Some(ray) => edge(
                |far| Some(ray.at(side * far)),
                levels[k],
                seek,
                half_px,
                reach_px,
            ),
            None => {
                let read = |far| {
                    let place = vec2::along(center, normal, side * far);
                    difference.holds(place).then(|| difference.sample(place))
                };
                edge(read, levels[k], seek, half_px, reach_px)
            }
        };
    }
    match found {
        [Edge::At(left), Edge::At(right)] => Some([left, right]),
        [Edge::At(left), Edge::OutOfImage] => Some([left, 2.0 * half_px - left]),
        [Edge::OutOfImage, Edge::At(right)] => Some([2.0 * half_px - right, right]),
        _ => None,
    }
}

/// Where an edge is sought first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Seek {
    /// Where the rope's width says that it is.
    Near,
    /// From the core on outward: at a tip, sections that run through its corners come out of the rope and in again.
    Inside,
}

/// One edge of a section, at a distance from its center.
#[derive(Clone, Copy, Debug)]
enum Edge {
    At(f32),
    OutOfImage,
    OutOfReach,
}

/// Places about each edge that are read at once, and how many of them lie before the first that is looked at: hardly
/// any edge lies farther off.
const BATCH: usize = 4;
const BEFORE: usize = 1;
/// Both edges' places.
pub(crate) const PLACES: usize = 2 * BATCH;

/// Distance between the places of a section that are read.
fn step_px(half_px: f32) -> f32 {
    (half_px / 12.0).max(STEP_PX)
}

/// The first place that is read at an edge.
fn first_px(half_px: f32) -> f32 {
    half_px - (BEFORE as f32 + 0.5) * step_px(half_px)
}

/// Where the values for [`near`] are read: from the inside outward, the −normal's first.
pub(crate) fn places(half_px: f32) -> [f32; PLACES] {
    std::array::from_fn(|k| {
        let out = first_px(half_px) + step_px(half_px) * (k % BATCH) as f32;
        if k < BATCH { -out } else { out }
    })
}

/// How far that is from the middle at most.
pub(crate) fn reach_px(half_px: f32) -> f32 {
    first_px(half_px) + step_px(half_px) * BATCH as f32
}

/// The distances of both edges in each lane, as [`edges`] seeks them near where the rope's width says that they are; not
/// a number where they lie farther off.
#[inline(always)]
pub(crate) fn near(values: &[Lanes; PLACES], levels: &[Lanes; 2], half_px: f32) -> [Lanes; 2] {
    let mut found = [[f32::NAN; LANES]; 2];
    let (left, right) = values.split_at(BATCH);
    for ((found, values), levels) in found.iter_mut().zip([left, right]).zip(levels) {
        for l in 0..LANES {
            let level = levels[l];
            let is_in = |k: usize| values[k][l] >= level;
            // From the start outward, or inward, whichever way the edge lies: the first step that crosses the level.
            let mut steps = f32::NAN;
            for k in (0..BATCH - 1).rev() {
                let (high, low) = (values[k][l], values[k + 1][l]);
                let is_next = is_in(k) & !is_in(k + 1);
                let is_sought = is_in(BEFORE) == (k >= BEFORE);
                let here = k as f32 + (high - level) / (high - low);
                steps = if is_next & is_sought { here } else { steps };
            }
            found[l] = first_px(half_px) + step_px(half_px) * steps;
        }
    }
    found
}

/// Where the difference, which `read` tells for a distance as long as it lies in the image, falls below `level`: sought
/// from where the rope's width says that it does, inward or outward, whichever way it lies.
#[inline(always)]
fn edge(
    read: impl Fn(f32) -> Option<f32>,
    level: f32,
    seek: Seek,
    half_px: f32,
    reach_px: f32,
) -> Edge {
    let (core, step) = (CORE * half_px, step_px(half_px));
    let between = |(inner, high): (f32, f32), (outer, low): (f32, f32)| {
        inner + (outer - inner) * (high - level) / (high - low)
    };
    let start = match seek {
        Seek::Near => (half_px - 0.5 * step).max(core),
        Seek::Inside => core,
    };
    let (mut at, mut value) = (start, read(start));
    match value {
        Some(mut inside) if inside >= level => {
            while at < reach_px {
                let next = at + step;
                match read(next) {
                    None => return Edge::OutOfImage,
                    Some(low) if low < level => {
                        return Edge::At(between((at, inside), (next, low)));
                    }
                    Some(value) => (at, inside) = (next, value),
                }
            }
            Edge::OutOfReach
        }
        _ => {
            while at > core {
                let inner = (at - step).max(core);
                let found = read(inner);
                if let Some(high) = found.filter(|&high| high >= level) {
                    return value.map_or(Edge::OutOfImage, |low| {
                        Edge::At(between((inner, high), (at, low)))
                    });
                }
                (at, value) = (inner, found);
            }
            value.map_or(Edge::OutOfImage, |_| Edge::At(core))
        }
    }
}
