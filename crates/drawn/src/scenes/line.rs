//! Curves as points at equal steps of arc length: positions, cuts, bends, and intersections.

use crate::rendered::truth::meet;

pub(super) type Vec2 = [f64; 2];

#[inline]
pub(super) fn minus(a: Vec2, b: Vec2) -> Vec2 {
    [a[0] - b[0], a[1] - b[1]]
}

#[inline]
pub(super) fn dot(a: Vec2, b: Vec2) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

#[inline]
pub(super) fn cross(a: Vec2, b: Vec2) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

#[inline]
pub(super) fn norm(a: Vec2) -> f64 {
    dot(a, a).sqrt()
}

#[inline]
pub(super) fn mix(a: Vec2, b: Vec2, share: f64) -> Vec2 {
    [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])]
}

/// A polyline of equal steps. The last point of a closed line is one step before its first.
#[derive(Debug, Clone)]
pub(super) struct Line {
    pub(super) points: Vec<Vec2>,
    pub(super) closed: bool,
    pub(super) step_px: f64,
}

impl Line {
    /// Makes a smooth curve through `knots` (Catmull and Rom 1974) with `segments` equal steps.
    pub(super) fn through(knots: &[Vec2], closed: bool, segments: usize) -> Self {
        const PIECES: usize = 8;
        let count = knots.len();
        let spans = if closed { count } else { count - 1 };
        let knot = |i: isize| {
            if closed {
                knots[i.rem_euclid(count as isize) as usize]
            } else {
                knots[i.clamp(0, count as isize - 1) as usize]
            }
        };
        let mut dense = Vec::with_capacity(spans * PIECES + 1);
        for i in 0..spans as isize {
            let [a, b, c, d] = [-1, 0, 1, 2].map(|k| knot(i + k));
            for piece in 0..PIECES {
                let t = piece as f64 / PIECES as f64;
                dense.push([0, 1].map(|k| catmull_rom([a[k], b[k], c[k], d[k]], t)));
            }
        }
        dense.push(knot(spans as isize));
        Self::even(&dense, closed, segments)
    }

    /// Divides a dense polyline into `segments` equal steps. A closed polyline ends at its first
    /// point.
    fn even(dense: &[Vec2], closed: bool, segments: usize) -> Self {
        let mut lengths = vec![0.0];
        for pair in dense.windows(2) {
            lengths.push(lengths[lengths.len() - 1] + norm(minus(pair[1], pair[0])));
        }
        let length_px = lengths[lengths.len() - 1];
        let step_px = length_px / segments as f64;
        let count = if closed { segments } else { segments + 1 };
        let mut at = 1;
        let points = (0..count)
            .map(|k| {
                let goal = k as f64 * step_px;
                while at + 1 < lengths.len() && lengths[at] < goal {
                    at += 1;
                }
                let span = (lengths[at] - lengths[at - 1]).max(1e-12);
                mix(dense[at - 1], dense[at], (goal - lengths[at - 1]) / span)
            })
            .collect();
        Self {
            points,
            closed,
            step_px,
        }
    }

    #[inline]
    pub(super) fn segments(&self) -> usize {
        self.points.len() - usize::from(!self.closed)
    }

    #[inline]
    pub(super) fn length_px(&self) -> f64 {
        self.segments() as f64 * self.step_px
    }

    /// Ends of segment `i`.
    #[inline]
    pub(super) fn segment(&self, i: usize) -> [Vec2; 2] {
        let next = if i + 1 == self.points.len() { 0 } else { i + 1 };
        [self.points[i], self.points[next]]
    }

    /// Point at an arc length. For an arc length beyond a tip, the tip itself.
    pub(super) fn at(&self, along_px: f64) -> Vec2 {
        let mut position = along_px / self.step_px;
        if self.closed {
            position = position.rem_euclid(self.segments() as f64);
        }
        let position = position.clamp(0.0, self.segments() as f64);
        let i = (position as usize).min(self.segments() - 1);
        let [from, to] = self.segment(i);
        mix(from, to, position - i as f64)
    }

    /// Unit tangent at an arc length.
    pub(super) fn tangent(&self, along_px: f64) -> Vec2 {
        let d = minus(
            self.at(along_px + self.step_px),
            self.at(along_px - self.step_px),
        );
        let length = norm(d).max(1e-12);
        [d[0] / length, d[1] / length]
    }

    /// Cuts out the part between two arc lengths, with as many steps as the whole.
    pub(super) fn cut(&self, from_px: f64, to_px: f64) -> Self {
        let count = 4 * self.segments();
        let dense: Vec<Vec2> = (0..=count)
            .map(|k| self.at(from_px + (to_px - from_px) * k as f64 / count as f64))
            .collect();
        Self::even(&dense, false, self.segments())
    }

    /// Radius of the tightest bend.
    pub(super) fn least_radius_px(&self) -> f64 {
        // Over at least three pixels, because rounding would bend shorter steps.
        let reach = ((3.0 / self.step_px) as usize).max(1);
        let count = self.points.len();
        let (from, to) = if self.closed {
            (0, count)
        } else {
            (reach, count.saturating_sub(reach))
        };
        (from..to)
            .map(|i| {
                let (a, b) = (
                    self.points[(i + count - reach) % count],
                    self.points[(i + reach) % count],
                );
                let (u, v) = (minus(self.points[i], a), minus(b, self.points[i]));
                let turn = cross(u, v).abs() / (norm(u) * norm(v)).max(1e-12);
                // asin(x) ≥ x: for such small turns, the radius is right to a percent.
                let turn = if dot(u, v) < 0.0 { 2.0 } else { turn };
                reach as f64 * self.step_px / turn.max(1e-9)
            })
            .fold(f64::INFINITY, f64::min)
    }
}

fn catmull_rom([a, b, c, d]: [f64; 4], t: f64) -> f64 {
    b + 0.5 * t * (c - a + t * (2.0 * a - 5.0 * b + 4.0 * c - d + t * (3.0 * (b - c) + d - a)))
}

/// Two strands that cross.
#[derive(Debug, Clone, Copy)]
pub(super) struct Meeting {
    /// Indices of the lines.
    pub(super) lines: [usize; 2],
    /// Arc length on each line.
    pub(super) along_px: [f64; 2],
    pub(super) at: Vec2,
    /// Sines of half the angle between the lines and of the whole angle.
    pub(super) sin_half: f64,
    pub(super) sin: f64,
}

/// Result of [`meetings`].
#[derive(Debug, Default)]
pub(super) struct Found {
    pub(super) meetings: Vec<Meeting>,
    /// Places closer than the requested distance: lines and arc lengths.
    pub(super) near: Vec<([usize; 2], [f64; 2])>,
}

/// Finds where lines cross each other or themselves. Also finds where they come closer than
/// `near_px`, although they are more than 1.5 times that distance apart along the rope.
pub(super) fn meetings(lines: &[Line], near_px: f64) -> Found {
    let mut found = Found::default();
    for a in 0..lines.len() {
        for b in a..lines.len() {
            pair_meetings([a, b], [&lines[a], &lines[b]], near_px, &mut found);
        }
    }
    found
}

fn pair_meetings(of: [usize; 2], [a, b]: [&Line; 2], near_px: f64, found: &mut Found) {
    let is_same = of[0] == of[1];
    for i in 0..a.segments() {
        let [p, q] = a.segment(i);
        let mut j = if is_same { i + 2 } else { 0 };
        while j < b.segments() {
            let [r, s] = b.segment(j);
            let distance_px = norm(minus(r, p));
            // Segments that are farther apart cannot intersect.
            if distance_px < 1.01 * (a.step_px + b.step_px)
                && let Some((u, v)) = meet([p, q], [r, s])
            {
                let (along, other) = (minus(q, p), minus(s, r));
                let scale = norm(along) * norm(other);
                let sin = cross(along, other).abs() / scale;
                let cos = dot(along, other).abs() / scale;
                found.meetings.push(Meeting {
                    lines: of,
                    along_px: [(i as f64 + u) * a.step_px, (j as f64 + v) * b.step_px],
                    at: mix(p, q, u),
                    sin_half: ((1.0 - cos) / 2.0).max(0.0).sqrt(),
                    sin,
                });
            }
            let mut apart_px = (j as f64 - i as f64) * a.step_px;
            if is_same && a.closed {
                apart_px = apart_px.min(a.length_px() - apart_px);
            }
            if distance_px < near_px && !(is_same && apart_px < 1.5 * near_px) {
                let along_px = [i as f64 * a.step_px, j as f64 * b.step_px];
                found.near.push((of, along_px));
            }
            // The distance cannot shrink faster than the line advances.
            let spare = (distance_px - near_px.max(a.step_px)) / b.step_px;
            j += (spare.max(0.0) as usize).saturating_sub(1).max(1);
        }
    }
}
