//! The two edges of a rope in one of its cross-sections: where, from its middle outward, the difference falls below a
//! level. A few places about where the rope's width says that they lie are read at once, for both edges; that is enough
//! for nearly all. The rest is sought step by step.

use crate::plane::Plane;
use crate::ray::Ray;
use crate::vec2::{self, Vec2};

/// The part of a half-width around the center where no edge is looked for: shine lies there.
const CORE: f32 = 0.35;
/// The least distance between places that are read: over a whole pixel a sharp edge is no straight line, and 0.01 px would
/// be lost.
const STEP_PX: f32 = 0.5;

/// The distances along −`normal` and +`normal` at which the difference falls below each level. Where the image ends
/// before one edge, the other and the rope's width tell.
#[inline(always)]
pub(crate) fn edges(
    difference: &Plane,
    center: Vec2,
    normal: Vec2,
    levels: [f32; 2],
    seek: Seek,
    half_px: f32,
    reach_px: f32,
) -> Option<[f32; 2]> {
    let found = match Ray::new(difference, center, normal, reach_px + step_px(half_px)) {
        Some(ray) => {
            let first = half_px - (BEFORE as f32 + 0.5) * step_px(half_px);
            let mut far = [0.0; 2 * BATCH];
            for k in 0..BATCH {
                let out = first + step_px(half_px) * k as f32;
                (far[k], far[BATCH + k]) = (-out, out);
            }
            let values = ray.at_each(far);
            let sides = [(-1.0, &values[..BATCH]), (1.0, &values[BATCH..])];
            let mut found = [Edge::OutOfReach; 2];
            for ((found, (side, values)), level) in found.iter_mut().zip(sides).zip(levels) {
                *found = match edge_within(values, level).filter(|_| seek == Seek::Near) {
                    Some(steps) => Edge::At(first + step_px(half_px) * steps),
                    None => edge(
                        |far| Some(ray.at(side * far)),
                        level,
                        seek,
                        half_px,
                        reach_px,
                    ),
                };
            }
            found
        }
        None => [-1.0, 1.0].map(|side| {
            let level = levels[usize::from(side > 0.0)];
            let read = |far| {
                let place = vec2::along(center, normal, side * far);
                difference.holds(place).then(|| difference.sample(place))
            };
            edge(read, level, seek, half_px, reach_px)
        }),
    };
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

/// Distance between the places of a section that are read.
fn step_px(half_px: f32) -> f32 {
    (half_px / 12.0).max(STEP_PX)
}

/// Where among `values`, read from the inside outward at equal steps, the edge lies, in steps; as `edge` seeks it.
#[inline(always)]
fn edge_within(values: &[f32], level: f32) -> Option<f32> {
    let mut outside = 0u32;
    for (k, value) in values.iter().enumerate() {
        outside |= u32::from(*value < level) << k;
    }
    // The bits up to the start, and those beyond it.
    let up_to = (2 << BEFORE) - 1;
    let outer = if outside >> BEFORE & 1 == 0 {
        (outside & !up_to).trailing_zeros()
    } else {
        u32::BITS - (!outside & up_to).leading_zeros()
    } as usize;
    if outer == 0 || outer >= values.len() {
        return None;
    }
    let (high, low) = (values[outer - 1], values[outer]);
    Some((outer - 1) as f32 + (high - level) / (high - low))
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
