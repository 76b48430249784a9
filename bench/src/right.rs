//! Tests whether a curve is a whole rope in order, and whether a picture's curves are its ropes.

use lariat_drawn::scenes::{SeenCurve, TrueRope, Truth, score};
use lariat_extract::{Curve, Status};
use lariat_wire::MIN_CONFIDENCE;

/// Minimum share of a rope that is covered, and of a curve that is on the rope.
pub(super) const WHOLE: f64 = 0.93;
/// Number of sample points per segment of a curve.
const STEPS: usize = 6;

/// Returns whether the curve is one of the true ropes.
pub(super) fn is_right(truth: &Truth, curve: &Curve) -> bool {
    truth.ropes.iter().any(|rope| is_whole(rope, curve))
}

/// Returns whether each rope has a right curve and no curve is left over.
pub(super) fn is_all_right(truth: &Truth, curves: &[Curve]) -> bool {
    let has_one = |rope: &TrueRope| curves.iter().any(|curve| is_whole(rope, curve));
    curves.len() == truth.ropes.len() && truth.ropes.iter().all(has_one)
}

/// Returns whether a curve is off every rope for more than half of its length.
pub(super) fn is_false(truth: &Truth, curve: &Curve) -> bool {
    let points: Vec<[f64; 2]> = curve.points.iter().map(|p| p.map(f64::from)).collect();
    let off = |p: &&[f64; 2]| {
        let ropes = truth.ropes.iter();
        !ropes.clone().any(|rope| {
            let reach_px = reach_px(rope) + 0.1 * rope.width_px;
            let mut places = rope.points.iter().step_by(8);
            places.any(|q| (p[0] - q[0]).powi(2) + (p[1] - q[1]).powi(2) <= reach_px.powi(2))
        })
    };
    2 * points.iter().filter(off).count() > points.len()
}

/// Returns the maximum distance of a curve from a rope's centerline.
fn reach_px(rope: &TrueRope) -> f64 {
    (0.5 * rope.width_px + 1.0).max(3.0)
}

fn is_whole(rope: &TrueRope, curve: &Curve) -> bool {
    let points: Vec<[f64; 2]> = curve.points.iter().map(|p| p.map(f64::from)).collect();
    let back = curve.closed.then(|| points[0]);
    let after = points[1..].iter().copied().chain(back);
    let dense: Vec<_> = (points.iter().zip(after))
        .flat_map(|(from, to)| {
            (0..STEPS).map(move |k| {
                let share = k as f64 / STEPS as f64;
                [0, 1].map(|c| from[c] + share * (to[c] - from[c]))
            })
        })
        .chain(points.last().copied())
        .collect();
    // On long ropes, every eighth point is more than a rope width from the next.
    let sparse: Vec<_> = rope.points.iter().copied().step_by(8).collect();
    let close: Vec<_> = rope.points.iter().copied().step_by(2).collect();
    let reach_px = reach_px(rope);
    share_near(&sparse, &dense, reach_px) >= WHOLE
        && share_near(&points, &close, reach_px + 0.1 * rope.width_px) >= WHOLE
        && is_in_order(rope, curve)
}

/// Returns the share of `points` that have one of `others` within `reach_px`.
pub(super) fn share_near(points: &[[f64; 2]], others: &[[f64; 2]], reach_px: f64) -> f64 {
    // Neighboring points have neighboring matches, so the last match is tried first.
    let mut last = 0;
    let is_near = |p: &&[f64; 2]| {
        let near = |q: &[f64; 2]| (p[0] - q[0]).powi(2) + (p[1] - q[1]).powi(2) <= reach_px.powi(2);
        let found = match others.get(last) {
            Some(q) if near(q) => Some(last),
            _ => others.iter().position(near),
        };
        last = found.unwrap_or(last);
        found.is_some()
    };
    points.iter().filter(is_near).count() as f64 / points.len().max(1) as f64
}

/// Returns whether points at the same share of both lengths coincide. A part missing at an end
/// displaces them by no more than its length.
fn is_in_order(rope: &TrueRope, curve: &Curve) -> bool {
    let truth = Truth {
        ropes: vec![rope.clone()],
        ..Truth::default()
    };
    let seen = SeenCurve {
        points: &curve.points,
        width_px: curve.width_px,
        closed: curve.closed,
    };
    let off_px = score(&truth, &[seen], &[]).correspondences_px;
    let most_px = (1.0 - WHOLE) * rope.length_px + 2.0 * rope.width_px;
    off_px.iter().all(|off| *off <= most_px)
}

/// Returns true if a curve is claimed to be a rope: readers receive it, and nothing suggests that
/// it is something else.
pub(super) fn is_claimed(curve: &Curve) -> bool {
    curve.confidence >= MIN_CONFIDENCE && curve.status != Status::Doubtful
}
