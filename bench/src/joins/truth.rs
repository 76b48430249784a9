//! Compares assignments with the true ropes.

use lariat_drawn::{moving, scenes};
use lariat_extract::Alternative;

/// Distance from a rope at which an end of a strand is on it, in widths.
const NEAR: f64 = 0.6;

/// A true rope, as positions at equal distances.
pub(super) struct Rope {
    points: Vec<[f64; 2]>,
    width_px: f64,
    closed: bool,
}

/// A place on a true rope.
#[derive(Clone, Copy)]
struct Place {
    rope: usize,
    /// Arc length.
    at_px: f64,
    /// 1 if the direction is that of growing arc length, −1 if not.
    sign: f64,
}

impl From<moving::TrueRope> for Rope {
    fn from(rope: moving::TrueRope) -> Self {
        let moving::TrueRope {
            points, width_px, ..
        } = rope;
        Self {
            points,
            width_px,
            closed: false,
        }
    }
}

impl From<scenes::TrueRope> for Rope {
    fn from(rope: scenes::TrueRope) -> Self {
        let scenes::TrueRope {
            points,
            width_px,
            closed,
            ..
        } = rope;
        Self {
            points,
            width_px,
            closed,
        }
    }
}

impl Rope {
    fn step_px(&self) -> f64 {
        let [a, b] = [self.points[0], self.points[1]];
        (a[0] - b[0]).hypot(a[1] - b[1])
    }
    fn length_px(&self) -> f64 {
        let n = self.points.len() - usize::from(!self.closed);
        self.step_px() * n as f64
    }
}

/// Places on true ropes near a position, along a direction.
fn places(ropes: &[Rope], at: [f32; 2], into: [f32; 2], reach: f64) -> Vec<Place> {
    let mut all = Vec::new();
    let norm = f64::from(into[0].hypot(into[1])).max(1e-9);
    for (rope, of) in ropes.iter().enumerate() {
        let n = of.points.len();
        let far = |i: usize| {
            (of.points[i][0] - f64::from(at[0])).hypot(of.points[i][1] - f64::from(at[1]))
        };
        let reach_px = reach * of.width_px + 1.0;
        let mut i = 0;
        while i < n {
            if far(i) > reach_px {
                i += 1;
                continue;
            }
            let mut best = i;
            while i < n && far(i) <= reach_px {
                if far(i) < far(best) {
                    best = i;
                }
                i += 1;
            }
            let (a, b) = (best.saturating_sub(2), (best + 2).min(n - 1));
            let d = [
                of.points[b][0] - of.points[a][0],
                of.points[b][1] - of.points[a][1],
            ];
            let cos = (d[0] * f64::from(into[0]) + d[1] * f64::from(into[1]))
                / (d[0].hypot(d[1]).max(1e-9) * norm);
            if cos.abs() > 0.6 {
                all.push(Place {
                    rope,
                    at_px: best as f64 * of.step_px(),
                    sign: cos.signum(),
                });
            }
        }
    }
    all
}

fn is_join_right(ropes: &[Rope], join: &[[f32; 2]; 4], passed_px: f64) -> bool {
    let [a, into_a, b, into_b] = *join;
    let from = places(ropes, a, into_a, NEAR);
    let to = places(ropes, b, [-into_b[0], -into_b[1]], NEAR);
    let far_px = f64::from((a[0] - b[0]).hypot(a[1] - b[1]));
    from.iter().any(|p| {
        to.iter().any(|q| {
            let rope = &ropes[p.rope];
            let mut way = p.sign * (q.at_px - p.at_px);
            if rope.closed && way < -0.5 * rope.length_px() {
                way += rope.length_px();
            }
            p.rope == q.rope
                && p.sign == q.sign
                && way > 0.65 * far_px.min(passed_px) - 1.2 * rope.width_px
                && way < 1.35 * far_px.max(passed_px) + 1.2 * rope.width_px
                && way > -rope.width_px
        })
    })
}

fn is_end_right(ropes: &[Rope], [at, into]: [[f32; 2]; 2]) -> bool {
    places(ropes, at, into, NEAR).iter().any(|p| {
        let rope = &ropes[p.rope];
        let left = if p.sign > 0.0 {
            rope.length_px() - p.at_px
        } else {
            p.at_px
        };
        !rope.closed && left < 3.0 * rope.width_px
    })
}

/// Number of errors of an alternative.
pub(super) fn errors(ropes: &[Rope], of: &Alternative) -> usize {
    let joins = of.joins.iter().zip(&of.passed_px);
    let joins = joins.filter(|(join, px)| !is_join_right(ropes, join, f64::from(**px)));
    let ends = of.ends.iter().filter(|end| !is_end_right(ropes, **end));
    let left = of.left_out.iter().filter(|[at, along]| {
        let long = along[0].hypot(along[1]) > 2.0 * of.half_px;
        long && !places(ropes, *at, *along, 0.3).is_empty()
    });
    joins.count() + ends.count() + left.count()
}
