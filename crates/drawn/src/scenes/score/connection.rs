//! Checks whether curves continue correctly at a crossing, and whether the reported upper strand is
//! correct.
//!
//! A curve follows a strand if it passes just before the crossing and just after it, and if its
//! length in between is the strand's. A curve that turns off into the other strand and returns
//! through a loop is longer. A curve that ends there, or continues elsewhere, passes only once.

use super::super::line::{Vec2, dot, minus, mix, norm};
use super::super::{TrueCrossing, TrueRope, TrueTouch, Truth};
use super::SeenCrossing;

/// Points of a curve with their arc lengths.
#[derive(Debug)]
pub(super) struct Polyline<'a> {
    points: &'a [Vec2],
    closed: bool,
    /// Arc length at each point, and of the whole.
    along_px: Vec<f64>,
}

impl<'a> Polyline<'a> {
    pub(super) fn new(points: &'a [Vec2], closed: bool) -> Self {
        let mut line = Self {
            points,
            closed,
            along_px: vec![0.0],
        };
        for i in 0..line.segments() {
            let [p, q] = line.segment(i);
            let next_px = line.along_px[i] + norm(minus(q, p));
            line.along_px.push(next_px);
        }
        line
    }

    fn segments(&self) -> usize {
        self.points.len().saturating_sub(usize::from(!self.closed))
    }

    fn segment(&self, i: usize) -> [Vec2; 2] {
        [self.points[i], self.points[(i + 1) % self.points.len()]]
    }

    fn length_px(&self) -> f64 {
        self.along_px[self.segments()]
    }

    /// Distance of a point from segment `i`, and position of the nearest point along the segment, 0
    /// to 1.
    fn nearest_on_segment(&self, i: usize, point: Vec2) -> (f64, f64) {
        let [p, q] = self.segment(i);
        let (d, to) = (minus(q, p), minus(point, p));
        let share = (dot(to, d) / dot(d, d).max(1e-12)).clamp(0.0, 1.0);
        (norm(minus(point, mix(p, q, share))), share)
    }

    /// Distance of a point from the line.
    pub(super) fn distance_px(&self, point: Vec2) -> f64 {
        let distances = (0..self.segments()).map(|i| self.nearest_on_segment(i, point).0);
        distances.fold(f64::INFINITY, f64::min)
    }

    fn at(&self, along_px: f64) -> Vec2 {
        let along_px = if self.closed {
            along_px.rem_euclid(self.length_px().max(1e-9))
        } else {
            along_px
        };
        let i = self.along_px.partition_point(|&px| px <= along_px);
        let i = i.clamp(1, self.segments()) - 1;
        let span_px = (self.along_px[i + 1] - self.along_px[i]).max(1e-12);
        let [p, q] = self.segment(i);
        mix(
            p,
            q,
            ((along_px - self.along_px[i]) / span_px).clamp(0.0, 1.0),
        )
    }

    fn tangent(&self, along_px: f64, reach_px: f64) -> Vec2 {
        let d = minus(self.at(along_px + reach_px), self.at(along_px - reach_px));
        let length = norm(d).max(1e-12);
        [d[0] / length, d[1] / length]
    }

    /// Nearest positions of all passages of the line within a distance of a point.
    fn passages_px(&self, point: Vec2, within_px: f64) -> Vec<f64> {
        let mut passages = Vec::new();
        let mut nearest: Option<(f64, f64)> = None;
        for i in 0..self.segments() {
            let (distance_px, share) = self.nearest_on_segment(i, point);
            if distance_px <= within_px {
                let span_px = self.along_px[i + 1] - self.along_px[i];
                let here = (distance_px, self.along_px[i] + share * span_px);
                nearest =
                    Some(nearest.map_or(here, |best| if here.0 < best.0 { here } else { best }));
            } else if let Some((_, along_px)) = nearest.take() {
                passages.push(along_px);
            }
        }
        passages.extend(nearest.map(|(_, along_px)| along_px));
        passages
    }
}

/// Half of the length that a crossing covers along each strand: w/2 (1/sin θ + 1/tan θ).
fn covered_px(width_px: f64, angle_deg: f64) -> f64 {
    let angle = angle_deg.max(1.0).to_radians();
    0.5 * width_px * (1.0 + angle.cos()) / angle.sin()
}

/// Returns whether curves continue along both of the crossing's strands.
pub(super) fn is_connected(truth: &Truth, crossing: &TrueCrossing, curves: &[Polyline]) -> bool {
    [crossing.over, crossing.under].iter().all(|&(rope, rho)| {
        let rope = &truth.ropes[rope];
        // Half a width beyond the covered part, where the strands are apart and the next crossing
        // has not begun.
        let reach_px = covered_px(rope.width_px, crossing.angle_deg) + 0.5 * rope.width_px;
        curves
            .iter()
            .any(|curve| follows(rope, rho, reach_px, curve))
    })
}

/// Returns whether curves continue along both of two touching strands.
pub(super) fn is_kept_apart(truth: &Truth, touch: &TrueTouch, curves: &[Polyline]) -> bool {
    touch.strands.iter().all(|&(rope, rho, reach_px)| {
        let follows = |curve| follows(&truth.ropes[rope], rho, reach_px, curve);
        curves.iter().any(follows)
    })
}

/// Returns whether a curve follows a rope from `reach_px` before a position to `reach_px` after it.
fn follows(rope: &TrueRope, rho: f64, reach_px: f64, curve: &Polyline) -> bool {
    if curve.segments() == 0 {
        return false;
    }
    let width_px = rope.width_px;
    let line = Polyline::new(&rope.points, rope.closed);
    let middle_px = rho * line.length_px();
    // Closer to this strand than to the other. In a bend, a chord between a curve's points may be
    // off by 2 px.
    let within_px = (0.6 * width_px).max(2.0);
    let [before, after] =
        [-reach_px, reach_px].map(|px| curve.passages_px(line.at(middle_px + px), within_px));
    // The strand's own length, and an allowance for detours. The allowance is far below the 3π
    // widths of a loop.
    let wanted_px = 2.0 * reach_px;
    let spare_px = 0.3 * wanted_px.min(10.0 * width_px) + width_px;
    before.iter().any(|&from_px| {
        after.iter().any(|&to_px| {
            let mut length_px = (to_px - from_px).abs();
            let mut half_way_px = 0.5 * (from_px + to_px);
            if curve.closed && 2.0 * length_px > curve.length_px() {
                length_px = curve.length_px() - length_px;
                half_way_px += 0.5 * curve.length_px();
            }
            let off_px = norm(minus(curve.at(half_way_px), line.at(middle_px)));
            (length_px - wanted_px).abs() < spare_px && off_px < 0.5 * reach_px + width_px
        })
    })
}

/// Returns whether the crossing was reported near its position, with an upper curve that follows
/// the upper strand there and not the lower one.
pub(super) fn is_order_right(
    truth: &Truth,
    crossing: &TrueCrossing,
    curves: &[Polyline],
    seen: &[SeenCrossing],
) -> bool {
    let width_px = truth.ropes[crossing.over.0].width_px;
    // The position of a flat crossing is less certain along the strands than across.
    let within_px = covered_px(width_px, crossing.angle_deg) + 0.5 * width_px;
    let nearest = seen
        .iter()
        .map(|seen| (norm(minus(seen.at.map(f64::from), crossing.at)), seen))
        .filter(|(away_px, _)| *away_px < within_px)
        .min_by(|a, b| a.0.total_cmp(&b.0));
    let Some((_, seen)) = nearest else {
        return false;
    };
    let (Some(upper), Some(lower)) = (curves.get(seen.over.0), curves.get(seen.under.0)) else {
        return false;
    };
    if upper.segments() == 0 || lower.segments() == 0 {
        return false;
    }
    let tangent = |line: &Polyline, rho: f64| line.tangent(rho * line.length_px(), 0.5 * width_px);
    let [over, under] = [crossing.over, crossing.under].map(|(rope, rho)| {
        let rope = &truth.ropes[rope];
        tangent(&Polyline::new(&rope.points, rope.closed), rho)
    });
    let [upper, lower] = [(upper, seen.over.1), (lower, seen.under.1)]
        .map(|(line, rho)| tangent(line, f64::from(rho)));
    let agree = |a: Vec2, b: Vec2| dot(a, b).abs();
    agree(upper, over) + agree(lower, under) > agree(upper, under) + agree(lower, over)
}
