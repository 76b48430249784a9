//! Distance between the curves of two results, independent of the ropes' numbers.

use lariat_wire::{Centerlines, Curve, Descriptors, Status};

type Point = [f32; 2];

/// Largest distance between the recorded ropes and those found now, from the points of either to
/// the other, in pixels. It is infinite if only one of the two has ropes.
pub(super) fn between(recorded: &Centerlines, now: &Centerlines) -> f64 {
    farthest(recorded, now).max(farthest(now, recorded))
}

/// Largest distance between a control point and the recorded one; infinite if the curves differ in
/// rope or kind.
pub(super) fn between_control_points(recorded: &Descriptors, now: &Descriptors) -> f64 {
    if recorded.count != now.count {
        return f64::INFINITY;
    }
    let mut farthest = 0.0;
    for (recorded, now) in recorded.curves().iter().zip(now.curves()) {
        let kind = |of: &lariat_wire::Descriptor| (of.track, of.basis, of.count);
        if kind(recorded) != kind(now) {
            return f64::INFINITY;
        }
        let pairs = recorded.control_points().iter().zip(now.control_points());
        for ([x, y], [now_x, now_y]) in pairs {
            farthest = (x - now_x).hypot(y - now_y).max(farthest);
        }
    }
    farthest
}

fn farthest(of: &Centerlines, from: &Centerlines) -> f64 {
    let points = seen(of).flat_map(Curve::points);
    points
        .map(|point| nearest(*point, from))
        .fold(0.0, f64::max)
}

fn seen(message: &Centerlines) -> impl Iterator<Item = &Curve> {
    let is_seen = |curve: &&Curve| !matches!(curve.status(), Some(Status::Lost) | None);
    message.curves().iter().filter(is_seen)
}

fn nearest(point: Point, message: &Centerlines) -> f64 {
    let mut nearest = f64::INFINITY;
    for curve in seen(message) {
        let points = curve.points();
        let closing = match (curve.closed, points) {
            (1.., [first, .., last]) => Some([*last, *first]),
            (_, [only]) => Some([*only, *only]),
            _ => None,
        };
        let segments = points.windows(2).map(|pair| [pair[0], pair[1]]);
        for segment in segments.chain(closing) {
            nearest = nearest.min(to_segment(point, segment));
        }
    }
    nearest
}

fn to_segment(point: Point, [a, b]: [Point; 2]) -> f64 {
    let [point, a, b] = [point, a, b].map(|p| p.map(f64::from));
    let minus = |p: [f64; 2], q: [f64; 2]| [p[0] - q[0], p[1] - q[1]];
    let (ab, ap) = (minus(b, a), minus(point, a));
    let length_squared = ab[0] * ab[0] + ab[1] * ab[1];
    let t = match length_squared > 0.0 {
        true => ((ap[0] * ab[0] + ap[1] * ab[1]) / length_squared).clamp(0.0, 1.0),
        false => 0.0,
    };
    (ap[0] - t * ab[0]).hypot(ap[1] - t * ab[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(y: f32) -> Box<Centerlines> {
        let mut message = Box::new(Centerlines::EMPTY);
        message.count = 1;
        message.curves[0].count = 3;
        for (i, point) in message.curves[0].points[..3].iter_mut().enumerate() {
            *point = [10.0 * i as f32, y];
        }
        message
    }

    #[test]
    fn a_line_moved_sideways_is_as_far_as_it_was_moved() {
        assert_eq!(between(&line(5.0), &line(5.0)), 0.0);
        assert_eq!(between(&line(5.0), &line(8.0)), 3.0);
        let mut shorter = line(5.0);
        shorter.curves[0].count = 2;
        assert_eq!(between(&line(5.0), &shorter), 10.0);
        assert_eq!(between(&shorter, &line(5.0)), 10.0);
    }

    #[test]
    fn a_rope_that_is_not_seen_now_is_infinitely_far() {
        let nothing = Box::new(Centerlines::EMPTY);
        assert_eq!(between(&line(5.0), &nothing), f64::INFINITY);
        assert_eq!(between(&nothing, &line(5.0)), f64::INFINITY);
        assert_eq!(between(&nothing, &nothing), 0.0);
        let mut lost = line(5.0);
        lost.curves[0].status = Status::Lost as u32;
        assert_eq!(between(&lost, &nothing), 0.0);
    }
}
