//! Errors of curves against the truth: position, correspondence along the rope, ends, width, and
//! connections at crossings.

mod connection;
mod matching;

use super::Truth;
use matching::Pairing;

/// A detected curve.
#[derive(Debug, Clone, Copy)]
pub struct SeenCurve<'a> {
    /// Points at equal steps of arc length, [x, y] in pixels.
    pub points: &'a [[f32; 2]],
    /// Width in pixels.
    pub width_px: f32,
    /// True if the last point is one step before the first.
    pub closed: bool,
}

/// A detected crossing.
#[derive(Debug, Clone, Copy)]
pub struct SeenCrossing {
    /// Position in pixels.
    pub at: [f32; 2],
    /// Index of the upper curve, and the normalized arc length of the crossing on it.
    pub over: (usize, f32),
    /// Index of the lower curve, and the normalized arc length of the crossing on it.
    pub under: (usize, f32),
}

/// Result for one true crossing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CrossingScore {
    /// Angle between the strands, 0 to 90 degrees.
    pub angle_deg: f64,
    /// True if curves continue along both strands.
    pub connected: bool,
    /// True if the crossing was reported there with the correct strand on top.
    pub order_right: bool,
}

/// Comparison of curves with the truth.
///
/// A rope without a matching curve also counts: the distances of its true points from the detected
/// curves are included. For a false curve, the distances from the true ropes are included. The
/// distances of an unmatched rope are at most half of its length, even in a picture without curves.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Score {
    /// Number of true ropes.
    pub ropes: usize,
    /// Number of curves.
    pub curves: usize,
    /// True if a curve is closed and its rope open, or the other way round.
    pub misclosed: bool,
    /// Distances of each curve's points from the true centerline.
    pub distances_px: Vec<f64>,
    /// Distances between each point of a curve and the true point at the same ρ.
    pub correspondences_px: Vec<f64>,
    /// Distances of an open curve's first and last point from the true ends.
    pub ends_px: Vec<f64>,
    /// Width of each matched curve minus the true width.
    pub width_errors_px: Vec<f64>,
    /// Results for all true crossings.
    pub crossings: Vec<CrossingScore>,
    /// For each place where strands touch without crossing: true if curves continue along both
    /// strands.
    pub touches: Vec<bool>,
}

impl Score {
    /// Returns true if the number of curves is wrong, or if a curve is closed or open by mistake.
    pub fn is_miscounted(&self) -> bool {
        self.ropes != self.curves || self.misclosed
    }

    /// Returns the mean distance from the true centerline.
    pub fn mean_px(&self) -> f64 {
        self.distances_px.iter().sum::<f64>() / self.distances_px.len().max(1) as f64
    }
}

/// Scores curves against the truth. Each true rope is matched with one curve, by the assignment
/// with the most ropes and the smallest distance between points at the same ρ. The better direction
/// is used, and for a closed rope the best start. Curves of fewer than two points are skipped.
pub fn score(truth: &Truth, curves: &[SeenCurve], crossings: &[SeenCrossing]) -> Score {
    let seen: Vec<Vec<[f64; 2]>> = curves
        .iter()
        .map(|curve| curve.points.iter().map(|p| p.map(f64::from)).collect())
        .collect();
    let mut score = Score {
        ropes: truth.ropes.len(),
        curves: curves.len(),
        ..Score::default()
    };
    let pairing = Pairing::best(truth, &seen);
    for (rope, curve) in truth.ropes.iter().zip(&pairing.curve_of) {
        let Some((k, placed)) = curve else {
            score.missed(rope, &seen);
            continue;
        };
        score.misclosed |= rope.closed != curves[*k].closed;
        let width_px = f64::from(curves[*k].width_px);
        score.width_errors_px.push(width_px - rope.width_px);
        let off = placed.errors_px(&rope.points, rope.closed, &seen[*k]);
        if !rope.closed {
            score.ends_px.extend([off[0], off[off.len() - 1]]);
        }
        score.correspondences_px.extend(off);
        let line = connection::Polyline::new(&rope.points, rope.closed);
        let distances = seen[*k].iter().map(|&p| line.distance_px(p));
        score.distances_px.extend(distances);
    }
    for (k, points) in seen.iter().enumerate() {
        if !pairing.is_used(k) {
            let nearest = |&p: &[f64; 2]| {
                let lines = truth.ropes.iter();
                lines
                    .map(|rope| connection::Polyline::new(&rope.points, rope.closed).distance_px(p))
                    .fold(f64::INFINITY, f64::min)
            };
            // Only every fourth point, because such a curve is wrong as a whole.
            score
                .distances_px
                .extend(points.iter().step_by(4).map(nearest));
        }
    }
    let lines: Vec<_> = (seen.iter().zip(curves))
        .map(|(points, curve)| connection::Polyline::new(points, curve.closed))
        .collect();
    score.crossings = truth
        .crossings
        .iter()
        .map(|crossing| CrossingScore {
            angle_deg: crossing.angle_deg,
            connected: connection::is_connected(truth, crossing, &lines),
            order_right: connection::is_order_right(truth, crossing, &lines, crossings),
        })
        .collect();
    let touches = truth.touches.iter();
    score.touches = touches
        .map(|touch| connection::is_kept_apart(truth, touch, &lines))
        .collect();
    score
}

impl Score {
    fn missed(&mut self, rope: &super::TrueRope, seen: &[Vec<[f64; 2]>]) {
        let lines: Vec<_> = seen
            .iter()
            .filter(|points| points.len() > 1)
            .map(|points| connection::Polyline::new(points, false))
            .collect();
        let away_px = |p: [f64; 2]| {
            let nearest = lines.iter().map(|line| line.distance_px(p));
            // At most half of the rope's own length, also if there is no curve at all.
            nearest.fold(0.5 * rope.length_px, f64::min)
        };
        let step = (rope.points.len() / 120).max(1);
        let off: Vec<f64> = rope
            .points
            .iter()
            .step_by(step)
            .map(|&p| away_px(p))
            .collect();
        if !rope.closed {
            let ends = [rope.points[0], rope.points[rope.points.len() - 1]];
            self.ends_px.extend(ends.map(away_px));
        }
        self.distances_px.extend(&off);
        self.correspondences_px.extend(off);
    }
}

#[cfg(test)]
mod tests {
    use super::super::line::{Line, Vec2};
    use super::super::{TrueCrossing, TrueRope, TrueTouch};
    use super::*;

    const CURVE_POINTS: usize = 120;

    /// A rope that crosses itself once, at (300, 200): x³ − x and 1 − x², the nodal cubic.
    fn looped() -> (Line, Truth) {
        let knots: Vec<Vec2> = (0..=400)
            .map(|i| {
                let t = -1.6 + 3.2 * f64::from(i) / 400.0;
                [300.0 + 60.0 * (t * t * t - t), 200.0 + 80.0 * (1.0 - t * t)]
            })
            .collect();
        let line = Line::through(&knots, false, 1999);
        let found = super::super::line::meetings(std::slice::from_ref(&line), 0.0);
        let meeting = found.meetings[0];
        let length_px = line.length_px();
        let [a, b] = meeting.along_px.map(|px| px / length_px);
        let rope = TrueRope {
            points: line.points.clone(),
            length_px,
            width_px: 8.0,
            closed: false,
            border: [false; 2],
        };
        let crossing = TrueCrossing {
            at: meeting.at,
            angle_deg: 2.0 * meeting.sin_half.asin().to_degrees(),
            over: (0, b),
            under: (0, a),
        };
        let truth = Truth {
            ropes: vec![rope],
            crossings: vec![crossing],
            touches: Vec::new(),
        };
        (line, truth)
    }

    fn points(line: &Line) -> Vec<[f32; 2]> {
        let step_px = line.length_px() / (CURVE_POINTS - 1) as f64;
        (0..CURVE_POINTS)
            .map(|i| line.at(i as f64 * step_px).map(|c| c as f32))
            .collect()
    }

    fn curve(points: &[[f32; 2]], closed: bool) -> SeenCurve<'_> {
        SeenCurve {
            points,
            width_px: 8.5,
            closed,
        }
    }

    #[test]
    fn the_truth_itself_is_right_in_either_direction() {
        let (line, truth) = looped();
        let mut points = points(&line);
        for reversed in [false, true] {
            let crossing = &truth.crossings[0];
            let rho = |rho: f64| if reversed { 1.0 - rho } else { rho } as f32;
            let seen = SeenCrossing {
                at: crossing.at.map(|c| c as f32),
                over: (0, rho(crossing.over.1)),
                under: (0, rho(crossing.under.1)),
            };
            let right = score(&truth, &[curve(&points, false)], &[seen]);
            assert!(!right.is_miscounted());
            assert!(right.mean_px() < 1e-3, "{}", right.mean_px());
            assert!(right.correspondences_px.iter().all(|&e| e < 1e-2));
            assert!(right.ends_px.iter().all(|&e| e < 1e-3));
            assert!((right.width_errors_px[0] - 0.5).abs() < 1e-9);
            assert!(right.crossings[0].connected && right.crossings[0].order_right);
            let upside_down = SeenCrossing {
                over: seen.under,
                under: seen.over,
                ..seen
            };
            let wrong = score(&truth, &[curve(&points, false)], &[upside_down]);
            assert!(wrong.crossings[0].connected && !wrong.crossings[0].order_right);
            points.reverse();
        }
    }

    /// The curve follows the loop backward: every point is on the rope, but the crossing is wrong.
    #[test]
    fn a_curve_that_turns_off_at_the_crossing_is_found_out() {
        let (line, truth) = looped();
        let [a, b] = [truth.crossings[0].under.1, truth.crossings[0].over.1];
        let whole_px = line.length_px();
        let swapped: Vec<[f32; 2]> = (0..CURVE_POINTS)
            .map(|i| {
                let rho = i as f64 / (CURVE_POINTS - 1) as f64;
                let rho = if rho > a && rho < b { a + b - rho } else { rho };
                line.at(rho * whole_px).map(|c| c as f32)
            })
            .collect();
        let wrong = score(&truth, &[curve(&swapped, false)], &[]);
        assert!(wrong.mean_px() < 0.5, "{}", wrong.mean_px());
        assert!(!wrong.crossings[0].connected && !wrong.crossings[0].order_right);
        assert!(wrong.correspondences_px.iter().any(|&e| e > 10.0));
    }

    /// Two curves instead of one: the loop, and the two ends joined.
    #[test]
    fn a_loop_cut_off_is_a_wrong_count_and_a_wrong_connection() {
        let (line, truth) = looped();
        let [a, b] =
            [truth.crossings[0].under.1, truth.crossings[0].over.1].map(|r| r * line.length_px());
        let cut = line.cut(a, b);
        let rest: Vec<[f32; 2]> = (0..CURVE_POINTS)
            .map(|i| {
                let at_px = (line.length_px() - (b - a)) * i as f64 / (CURVE_POINTS - 1) as f64;
                let at_px = if at_px > a { at_px + b - a } else { at_px };
                line.at(at_px).map(|c| c as f32)
            })
            .collect();
        let loop_points = points(&cut);
        let wrong = score(
            &truth,
            &[curve(&rest, false), curve(&loop_points, false)],
            &[],
        );
        assert!(wrong.is_miscounted());
        assert!(!wrong.crossings[0].connected);
        assert!(!wrong.distances_px.is_empty() && !wrong.ends_px.is_empty());
    }

    #[test]
    fn a_closed_rope_may_start_anywhere_and_go_either_way() {
        let knots: Vec<Vec2> = (0..200)
            .map(|i| {
                let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / 200.0).sin_cos();
                [200.0 + 120.0 * cos, 150.0 + 70.0 * sin]
            })
            .collect();
        let line = Line::through(&knots, true, 2000);
        let truth = Truth {
            ropes: vec![TrueRope {
                points: line.points.clone(),
                length_px: line.length_px(),
                width_px: 8.5,
                closed: true,
                border: [false; 2],
            }],
            crossings: Vec::new(),
            touches: Vec::new(),
        };
        let mut seen: Vec<[f32; 2]> = (0..CURVE_POINTS)
            .map(|i| {
                let at_px = line.length_px() * (0.377 + i as f64 / CURVE_POINTS as f64);
                line.at(at_px).map(|c| c as f32)
            })
            .collect();
        for _ in 0..2 {
            let right = score(&truth, &[curve(&seen, true)], &[]);
            assert!(right.correspondences_px.iter().all(|&e| e < 0.05));
            assert!(right.ends_px.is_empty() && !right.is_miscounted());
            seen.reverse();
        }
        assert!(score(&truth, &[curve(&seen, false)], &[]).is_miscounted());
    }

    /// Two strands that come together, run side by side for 60 px, and part.
    #[test]
    fn strands_exchanged_where_they_touch_are_found_out() {
        let side = |sign: f64| {
            let knots: Vec<Vec2> = (0..=100)
                .map(|i| {
                    let x = 3.0 * f64::from(i) - 150.0;
                    let away = (x.abs() - 30.0).max(0.0) / 120.0;
                    [200.0 + x, 150.0 + sign * (4.0 + 60.0 * away * away)]
                })
                .collect();
            Line::through(&knots, false, 1999)
        };
        let lines = [side(-1.0), side(1.0)];
        let rope = |line: &Line| TrueRope {
            points: line.points.clone(),
            length_px: line.length_px(),
            width_px: 8.0,
            closed: false,
            border: [false; 2],
        };
        let truth = Truth {
            ropes: lines.iter().map(rope).collect(),
            crossings: Vec::new(),
            touches: vec![TrueTouch {
                strands: [(0, 0.5, 70.0), (1, 0.5, 70.0)],
            }],
        };
        let right = lines.each_ref().map(points);
        let half = CURVE_POINTS / 2;
        let exchanged = [0, 1].map(|k| [&right[k][..half], &right[1 - k][half..]].concat());
        for (seen, is_kept_apart) in [(right, true), (exchanged, false)] {
            let curves = seen.each_ref().map(|points| curve(points, false));
            let score = score(&truth, &curves, &[]);
            assert_eq!(score.touches, [is_kept_apart]);
        }
    }

    #[test]
    fn what_was_not_seen_counts() {
        let (_, truth) = looped();
        let nothing = score(&truth, &[], &[]);
        assert!(nothing.is_miscounted() && nothing.mean_px() > 50.0);
        assert_eq!(nothing.ends_px.len(), 2);
        assert!(!nothing.crossings[0].connected);
    }
}
