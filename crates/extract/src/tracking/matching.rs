//! Agreement of a curve of this image with a rope of the prior, and their relative direction.
//!
//! `near` compares a rope seen in the last image with a curve nearby. If both are whole, it
//! compares them point by point. If one may be a part of the other, it measures how far the part is
//! from the whole. `returned` recognizes a rope that comes back into sight by its shape, length,
//! width and color, wherever it is now.

use crate::vec2::{self, Vec2};

/// Maximum cost of a match of whole ropes: a share of the longer one's length, plus widths.
const FARTHEST: (f32, f32) = (0.15, 4.0);
/// Maximum mean distance of a part from its rope, in widths.
const ALONG_WIDTHS: f32 = 3.0;
/// Maximum length of one shape, relative to the other's, at which it may be a part of the other.
const PART: f32 = 0.93;
/// Maximum factor between the lengths of a rope before and after it was out of sight.
const LENGTH_FACTOR: f32 = 1.35;
/// Maximum change of a rope's color in even light, in levels.
const COLOR_LEVELS: f32 = 60.0;
/// Number of points of a curve that are compared with a rope.
const ASKED: usize = 24;

/// A curve or a rope, as far as it matters for matching.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shape<'a> {
    pub(crate) points: &'a [Vec2],
    pub(crate) closed: bool,
    pub(crate) length_px: f32,
    pub(crate) width_px: f32,
    /// Color difference from the other shape, in levels. 0 if not both colors are known.
    pub(crate) color_levels: f32,
}

/// Agreement of two shapes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Agreement {
    /// In pixels for `near`, without a unit for `returned`. The least cost is the best match.
    pub(crate) cost: f32,
    /// True if the curve runs against the rope.
    pub(crate) reversed: bool,
}

/// Agreement of a curve with a rope that was seen in the last image, or `None` if they do not
/// match.
///
/// The cost of a whole rope is the mean distance of its points. The cost of a part is its mean
/// distance from the whole, plus a penalty of one to three widths that grows with the missing
/// share. Color adds up to two widths to either cost. The lower cost counts.
pub(crate) fn near(rope: &Shape, curve: &Shape) -> Option<Agreement> {
    let by_color = rope.width_px * (curve.color_levels / COLOR_LEVELS).min(2.0);
    let whole = (rope.points.len() == curve.points.len() && rope.closed == curve.closed)
        .then(|| distances(rope.points, curve.points, rope.closed))
        .map(|(ahead, back)| Agreement {
            cost: ahead.min(back) + by_color,
            reversed: back < ahead,
        })
        .filter(|whole| {
            let limit_px = FARTHEST.0 * rope.length_px.max(curve.length_px);
            whole.cost <= limit_px + FARTHEST.1 * rope.width_px
        });
    let shorter = curve.length_px < PART * rope.length_px || rope.closed && !curve.closed;
    let part = shorter
        .then(|| along(rope, curve))
        .or_else(|| (rope.length_px < PART * curve.length_px).then(|| along(curve, rope)))
        .filter(|part| part.cost <= ALONG_WIDTHS * rope.width_px)
        // A match as a whole rope is preferred to one as a part, and a larger part to a smaller
        // one.
        .map(|part| {
            let share = curve.length_px / rope.length_px;
            let missing = 1.0 - share.min(1.0 / share);
            Agreement {
                cost: part.cost + (1.0 + 2.0 * missing) * rope.width_px + by_color,
                ..part
            }
        });
    match (whole, part) {
        (Some(whole), Some(part)) if part.cost < whole.cost => Some(part),
        (None, part) => part,
        (whole, _) => whole,
    }
}

/// Agreement of a curve with a rope that was out of sight, wherever it is now. `whole_px` is the
/// rope's usual length. `None` if the two differ in kind, length, width or color.
pub(crate) fn returned(rope: &Shape, whole_px: f32, curve: &Shape) -> Option<Agreement> {
    let ratio = (whole_px / curve.length_px).max(curve.length_px / whole_px);
    let width = (rope.width_px / curve.width_px).max(curve.width_px / rope.width_px);
    let same_kind = rope.points.len() == curve.points.len() && rope.closed == curve.closed;
    if !same_kind || ratio > LENGTH_FACTOR || width > 1.5 || curve.color_levels > COLOR_LEVELS {
        return None;
    }
    let (ahead, back) = distances(rope.points, curve.points, rope.closed);
    let shift = vec2::sub(centroid(curve.points), centroid(rope.points));
    let shape = shape_distances(rope.points, curve.points, shift);
    // If the rope has moved only a little, its place tells more than its shape. If it has moved
    // far, its shape tells more.
    let moved = vec2::norm(shift) > 0.25 * rope.length_px;
    let (ahead, back) = if moved && !rope.closed {
        shape
    } else {
        (ahead, back)
    };
    let cost = libm::logf(ratio)
        + libm::logf(width)
        + curve.color_levels / COLOR_LEVELS
        + (ahead.min(back) + 0.2 * vec2::norm(shift)) / rope.length_px;
    Some(Agreement {
        cost,
        reversed: back < ahead,
    })
}

/// Mean distance of a part's points from the rope, and the part's direction along it.
pub(crate) fn along(rope: &Shape, part: &Shape) -> Agreement {
    let n = part.points.len();
    let stride = (n / ASKED).max(1);
    let (mut sum, mut count, mut flow) = (0.0, 0.0, 0.0f32);
    for i in (0..n.saturating_sub(1)).step_by(stride) {
        let (at, step) = (
            part.points[i],
            vec2::sub(part.points[i + 1], part.points[i]),
        );
        let (apart, direction) = nearest_place(rope, at, step);
        sum += apart;
        count += 1.0;
        flow += vec2::dot(direction, vec2::unit_or(step, [0.0; 2]));
    }
    Agreement {
        cost: if count > 0.0 {
            sum / count
        } else {
            f32::INFINITY
        },
        reversed: flow < 0.0,
    }
}

/// Distance to the rope's nearest place that runs roughly along `step`, and its direction there.
fn nearest_place(rope: &Shape, at: Vec2, step: Vec2) -> (f32, Vec2) {
    let n = rope.points.len();
    let step = vec2::unit_or(step, [1.0, 0.0]);
    let mut best = (f32::INFINITY, [0.0; 2], f32::INFINITY);
    for i in 0..n - usize::from(!rope.closed) {
        let (a, b) = (rope.points[i], rope.points[(i + 1) % n]);
        let ahead = vec2::sub(b, a);
        let length = vec2::norm(ahead).max(1e-6);
        let t = (vec2::dot(vec2::sub(at, a), ahead) / (length * length)).clamp(0.0, 1.0);
        let apart = vec2::distance(at, vec2::along(a, ahead, t));
        let direction = vec2::scale(ahead, 1.0 / length);
        // Running across the rope costs two widths, so that the right strand wins at a crossing.
        let cost = apart + 2.0 * rope.width_px * vec2::cross(direction, step).abs();
        if cost < best.2 {
            best = (apart, direction, cost);
        }
    }
    (best.0, best.1)
}

/// Mean distance of corresponding points, and the same with one shape reversed. The correspondence
/// of rings starts at the nearest point.
pub(crate) fn distances(a: &[Vec2], b: &[Vec2], closed: bool) -> (f32, f32) {
    let n = a.len();
    if n == 0 || n != b.len() {
        return (f32::INFINITY, f32::INFINITY);
    }
    let shift = if closed { nearest_point(b, a[0]) } else { 0 };
    let (mut ahead, mut back) = (0.0, 0.0);
    for (i, &p) in a.iter().enumerate() {
        ahead += vec2::distance(p, b[(i + shift) % n]);
        let opposite = if closed {
            (shift + n - i) % n
        } else {
            n - 1 - i
        };
        back += vec2::distance(p, b[opposite]);
    }
    (ahead / n as f32, back / n as f32)
}

/// [`distances`] of open curves after `b` is moved back by `shift`.
fn shape_distances(a: &[Vec2], b: &[Vec2], shift: Vec2) -> (f32, f32) {
    let n = a.len();
    let apart = |i: usize, j: usize| vec2::distance(a[i], vec2::sub(b[j], shift));
    let ahead: f32 = (0..n).map(|i| apart(i, i)).sum();
    let back: f32 = (0..n).map(|i| apart(i, n - 1 - i)).sum();
    (ahead / n as f32, back / n as f32)
}

fn centroid(points: &[Vec2]) -> Vec2 {
    let sum = points.iter().copied().fold([0.0; 2], vec2::add);
    vec2::scale(sum, 1.0 / points.len().max(1) as f32)
}

/// Index of the point nearest to `goal`, or 0 without points.
pub(crate) fn nearest_point(points: &[Vec2], goal: Vec2) -> usize {
    let by_distance = |&a: &usize, &b: &usize| {
        vec2::distance(points[a], goal).total_cmp(&vec2::distance(points[b], goal))
    };
    (0..points.len()).min_by(by_distance).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shape(points: &[Vec2]) -> Shape<'_> {
        let length_px = points.windows(2).map(|p| vec2::distance(p[0], p[1])).sum();
        Shape {
            points,
            closed: false,
            length_px,
            width_px: 6.0,
            color_levels: 0.0,
        }
    }

    fn arc(from: f32, to: f32, offset: Vec2) -> Vec<Vec2> {
        (0..60)
            .map(|i| {
                let angle = from + (to - from) * i as f32 / 59.0;
                vec2::add(offset, [80.0 * angle.cos(), 80.0 * angle.sin()])
            })
            .collect()
    }

    #[test]
    fn a_part_is_known_by_where_it_lies_and_runs() {
        let rope = arc(0.0, 4.0, [0.0; 2]);
        let part = arc(3.8, 2.4, [2.0, 1.0]);
        let found = near(&shape(&rope), &shape(&part)).expect("it lies on the rope");
        assert!(found.reversed);
        assert!(along(&shape(&rope), &shape(&part)).cost < 3.0);
        let elsewhere = arc(3.8, 2.4, [90.0, 90.0]);
        assert!(near(&shape(&rope), &shape(&elsewhere)).is_none());
    }

    #[test]
    fn a_rope_that_comes_back_elsewhere_keeps_its_direction_by_its_shape() {
        // A hook, whose ends cannot be confused.
        let hook = |offset: Vec2| -> Vec<Vec2> {
            let mut points: Vec<Vec2> = (0..40).map(|i| [5.0 * i as f32, 0.0]).collect();
            points.extend((0..20).map(|i| [195.0, 5.0 * (i + 1) as f32]));
            points.iter().map(|&p| vec2::add(p, offset)).collect()
        };
        let (rope, mut back) = (hook([0.0; 2]), hook([150.0, -60.0]));
        back.reverse();
        let found = returned(&shape(&rope), 295.0, &shape(&back)).expect("the same length");
        assert!(found.reversed);
    }

    #[test]
    fn a_rope_of_another_color_is_another_rope() {
        let rope = arc(0.0, 4.0, [0.0; 2]);
        let red = Shape {
            color_levels: 120.0,
            ..shape(&rope)
        };
        assert!(returned(&shape(&rope), 320.0, &red).is_none());
    }
}
