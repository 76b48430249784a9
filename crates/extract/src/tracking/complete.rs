//! Completes a partly visible rope. Covered parts keep their known shape, and move along with the
//! ends of the visible part.

use crate::scene::Curve;
use crate::vec2::{self, Vec2};

/// Buffers.
#[derive(Debug, Default)]
pub(crate) struct Completer {
    joined: Vec<Vec2>,
}

impl Completer {
    /// Reserves memory for this many points.
    pub(crate) fn reserve(&mut self, points: usize) {
        self.joined.reserve(points);
    }

    /// Puts `part`, which runs in the rope's direction, in its place in the rope's known `points`,
    /// which are at equal steps over `length_px`. Returns the new length, and the part's start and
    /// end along it. Without a place for it, `part` becomes the whole rope.
    pub(crate) fn complete(
        &mut self,
        points: &mut Vec<Vec2>,
        length_px: f32,
        part: &Curve,
    ) -> (f32, [f32; 2]) {
        let n = points.len();
        let (Some(&first), Some(&last)) = (part.points.first(), part.points.last()) else {
            return (length_px, [0.0, length_px]);
        };
        let Some([from, to]) = place(points, length_px, part) else {
            points.clear();
            points.extend_from_slice(&part.points);
            return (part.length_px, [0.0, part.length_px]);
        };
        self.joined.clear();
        let shift = vec2::sub(first, points[from]);
        self.joined
            .extend(points[..from].iter().map(|&p| vec2::add(p, shift)));
        self.joined.extend_from_slice(&part.points);
        let shift = vec2::sub(last, points[to]);
        self.joined
            .extend(points[to + 1..].iter().map(|&p| vec2::add(p, shift)));
        let spans = self.joined[..=from].windows(2);
        let from_px = spans.map(|pair| vec2::distance(pair[0], pair[1])).sum();
        let whole_px = resample(&self.joined, n, points);
        (whole_px, [from_px, from_px + part.length_px])
    }
}

/// Indices of the points between which the part belongs. They minimize the distances to both of its
/// ends plus the misfit of its length.
fn place(points: &[Vec2], length_px: f32, part: &Curve) -> Option<[usize; 2]> {
    let (&first, &last) = (part.points.first()?, part.points.last()?);
    let step_px = length_px / (points.len().max(2) - 1) as f32;
    let steps = part.length_px / step_px.max(1e-6);
    let mut best = (f32::INFINITY, None);
    for (i, &a) in points.iter().enumerate() {
        let near = vec2::distance(a, first);
        if near >= best.0 {
            continue;
        }
        for (j, &b) in points.iter().enumerate().skip(i + 1) {
            let miss_px = ((j - i) as f32 - steps).abs() * step_px;
            let cost = near + vec2::distance(b, last) + miss_px;
            if cost < best.0 {
                best = (cost, Some([i, j]));
            }
        }
    }
    best.1
}

/// Fills `out` with `count` points at equal steps along `line`, and returns its length.
fn resample(line: &[Vec2], count: usize, out: &mut Vec<Vec2>) -> f32 {
    let span = |i: usize| vec2::distance(line[i], line[i + 1]);
    let length_px: f32 = (0..line.len() - 1).map(span).sum();
    out.clear();
    let (mut i, mut passed) = (0, 0.0);
    for k in 0..count {
        let target = length_px * k as f32 / (count.max(2) - 1) as f32;
        while i + 2 < line.len() && passed + span(i) < target {
            passed += span(i);
            i += 1;
        }
        let t = ((target - passed) / span(i).max(1e-6)).clamp(0.0, 1.0);
        out.push(vec2::along(line[i], vec2::sub(line[i + 1], line[i]), t));
    }
    length_px
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_covered_rest_moves_along_with_what_is_seen() {
        let mut points: Vec<Vec2> = (0..=100).map(|i| [2.0 * i as f32, 0.0]).collect();
        let part = Curve {
            points: (0..=100).map(|i| [40.0 + i as f32, 5.0]).collect(),
            length_px: 100.0,
            ..Curve::default()
        };
        let (length_px, seen_px) = Completer::default().complete(&mut points, 200.0, &part);
        assert!((seen_px[0] - 40.0).abs() < 3.0 && (seen_px[1] - 140.0).abs() < 3.0);
        assert_eq!(points.len(), 101);
        assert!((length_px - 200.0).abs() < 3.0, "{length_px}");
        assert!(points.iter().all(|p| (p[1] - 5.0).abs() < 1e-3));
        assert!((points[0][0]).abs() < 2.0 && (points[100][0] - 200.0).abs() < 2.0);
    }
}
