//! Points at equal arc lengths along the smooth curve through others: the Catmull-Rom spline, in four chords a piece.

use crate::vec2::{self, Vec2};

/// Chords that a piece of the spline is measured by.
const CHORDS: usize = 4;

/// Memory and result.
#[derive(Debug, Default)]
pub(super) struct Lay {
    knots: Vec<Vec2>,
    /// The spline at each chord's end, and the way there.
    fine: Vec<(Vec2, f32)>,
    points: Vec<Vec2>,
}

impl Lay {
    /// The length of the curve through `places`.
    pub(super) fn measure(&mut self, places: impl Iterator<Item = Vec2>) -> f32 {
        self.knots.clear();
        self.knots.extend(places);
        self.trace()
    }

    /// Lays as many points as there are `places` along the curve through them, run on straight by `ends` pixels at
    /// either end, or cut. Returns its length; nothing when none is left.
    pub(super) fn lay(
        &mut self,
        places: impl Iterator<Item = Vec2>,
        ends: [f32; 2],
    ) -> Option<f32> {
        self.knots.clear();
        self.knots.extend(places);
        let count = self.knots.len();
        for end_px in ends {
            move_end(&mut self.knots, end_px);
            self.knots.reverse();
            if self.knots.len() < 4 {
                return None;
            }
        }
        let length_px = self.trace();
        let step_px = length_px / (count - 1) as f32;
        self.points.clear();
        let mut piece = 0;
        for k in 0..count {
            let target = step_px * k as f32;
            while piece + 2 < self.fine.len() && self.fine[piece + 1].1 < target {
                piece += 1;
            }
            let ((a, from), (b, to)) = (self.fine[piece], self.fine[piece + 1]);
            let t = ((target - from) / (to - from).max(1e-6)).clamp(0.0, 1.0);
            self.points.push(vec2::along(a, vec2::sub(b, a), t));
        }
        Some(length_px)
    }

    /// The points laid last.
    pub(super) fn points(&self) -> impl Iterator<Item = Vec2> {
        self.points.iter().copied()
    }

    fn trace(&mut self) -> f32 {
        self.fine.clear();
        let knots = &self.knots;
        let Some(&first) = knots.first() else {
            return 0.0;
        };
        self.fine.push((first, 0.0));
        let (mut before, mut way) = (first, 0.0);
        for i in 0..knots.len() - 1 {
            let (q, r) = (knots[i], knots[i + 1]);
            // Run on straight beyond the ends.
            let p = if i > 0 {
                knots[i - 1]
            } else {
                vec2::along(vec2::scale(q, 2.0), r, -1.0)
            };
            let s = knots.get(i + 2).copied();
            let s = s.unwrap_or_else(|| vec2::along(vec2::scale(r, 2.0), q, -1.0));
            for k in 1..=CHORDS {
                let t = k as f32 / CHORDS as f32;
                let here: Vec2 = std::array::from_fn(|c| {
                    let bend = 2.0 * p[c] - 5.0 * q[c] + 4.0 * r[c] - s[c];
                    let twist = 3.0 * (q[c] - r[c]) + s[c] - p[c];
                    0.5 * (2.0 * q[c] + t * (r[c] - p[c] + t * (bend + t * twist)))
                });
                way += vec2::distance(before, here);
                self.fine.push((here, way));
                before = here;
            }
        }
        way
    }
}

/// Moves the first knot outward by `end_px`, or inward past others.
fn move_end(knots: &mut Vec<Vec2>, end_px: f32) {
    if knots.len() < 2 {
        return;
    }
    let mut rest = -end_px;
    let mut gone = 0;
    while gone + 2 < knots.len() {
        let spacing = vec2::distance(knots[gone], knots[gone + 1]);
        // A knot that the end comes near to gives way to it.
        if rest <= 0.7 * spacing {
            break;
        }
        rest -= spacing;
        gone += 1;
    }
    let inward = vec2::unit_or(vec2::sub(knots[gone + 1], knots[gone]), [0.0, 0.0]);
    knots[gone] = vec2::along(knots[gone], inward, rest);
    knots.drain(..gone);
}
