//! Aligns the direction and the start of a curve with those of its track.

use super::matching::{self, nearest_point};
use crate::scene::Curve;
use crate::vec2::{self, Vec2, distance};

/// Maximum gap between a rope's ends at which it may look like a ring in the next image, in widths.
const CLOSING_WIDTHS: f32 = 5.0;

/// Cuts a ring open where the ends of its open rope touch.
pub(crate) fn open_ring(last: &[Vec2], curve: &mut Curve) {
    let (Some(&first), Some(&end)) = (last.first(), last.last()) else {
        return;
    };
    if distance(first, end) < CLOSING_WIDTHS * curve.width_px {
        let seam = vec2::scale(vec2::add(first, end), 0.5);
        rotate(curve, nearest_point(&curve.points, seam));
        curve.closed = false;
    }
}

/// Turns a ring so that it runs in the direction of the last one and starts nearest to its start.
pub(crate) fn align_ring(last: &[Vec2], curve: &mut Curve) {
    let (ahead, back) = matching::distances(last, &curve.points, true);
    if back < ahead {
        reverse(curve);
    }
    rotate(curve, nearest_point(&curve.points, last[0]));
}

pub(crate) fn reverse(curve: &mut Curve) {
    curve.points.reverse();
    curve.widths_px.reverse();
    curve.hidden.reverse();
    curve.border.swap(0, 1);
}

/// Makes point `first` of a ring its first.
pub(crate) fn rotate(curve: &mut Curve, first: usize) {
    curve.points.rotate_left(first);
    curve.widths_px.rotate_left(first);
    curve.hidden.rotate_left(first);
}

pub(crate) fn signed_area(points: &[Vec2]) -> f32 {
    let n = points.len();
    (0..n)
        .map(|i| vec2::cross(points[i], points[(i + 1) % n]))
        .sum()
}
