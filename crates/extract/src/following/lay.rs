//! Points at equal arc lengths along the smooth curve through others: a Catmull-Rom spline,
//! measured by four chords per piece.

use super::whole;
use crate::vec2::{self, Vec2};
use lariat_portable::{Arch, Simd, WithSimd};

/// Number of chords for measuring a piece of the spline.
const CHORDS: usize = 4;
/// Number of pieces measured in parallel.
const SIDE: usize = 16;

/// Buffers and result.
#[derive(Debug, Default)]
pub(super) struct Lay {
    knots: Vec<Vec2>,
    /// Coordinates of the knots, with one more knot at each end, in a straight extension.
    along: [Vec<f32>; 2],
    /// Length of each piece up to the start of each of its chords, and up to the end of the last.
    parts: Vec<[[f32; SIDE]; CHORDS + 1]>,
    /// Arc length up to the start of each piece.
    ways: Vec<f32>,
    /// For each piece, the first point at or after its start.
    firsts: Vec<i32>,
    /// For each point, the last piece that starts after the previous point, or else 0.
    begins: Vec<u32>,
    points: Vec<Vec2>,
}

impl Lay {
    /// Length of the curve through `places`.
    pub(super) fn measure(&mut self, places: impl Iterator<Item = Vec2>) -> f32 {
        self.knots.clear();
        self.knots.extend(places);
        self.trace(0..self.knots.len())
    }

    /// Lays as many points as there are `places` along the curve through them. Each end is extended
    /// straight by `ends` pixels, or cut if negative. Returns the length, or `None` if too few
    /// places are left.
    pub(super) fn lay(
        &mut self,
        places: impl Iterator<Item = Vec2>,
        ends: [f32; 2],
    ) -> Option<f32> {
        self.knots.clear();
        self.knots.extend(places);
        let count = self.knots.len();
        let first = move_end(&mut self.knots, ends[0], |i| i);
        let left = count - first;
        if left < 4 {
            return None;
        }
        let gone = move_end(&mut self.knots[first..], ends[1], |i| left - 1 - i);
        if left - gone < 4 {
            return None;
        }
        let length_px = self.trace(first..count - gone);
        let step_px = length_px / (count - 1) as f32;
        self.points.clear();
        self.points.resize(count, Vec2::default());
        self.begins.clear();
        self.begins.resize(count + 1, 0);
        Arch::new().dispatch(Space { lay: self, step_px });
        Some(length_px)
    }

    /// Points of the last call of `lay`.
    pub(super) fn points(&self) -> &[Vec2] {
        &self.points
    }

    /// Measures the curve through a range of the knots, and returns its length.
    fn trace(&mut self, knots: std::ops::Range<usize>) -> f32 {
        let knots = &self.knots[knots];
        self.ways.clear();
        if knots.len() < 2 {
            return 0.0;
        }
        let pieces = knots.len() - 1;
        let beyond = |end: Vec2, inner: Vec2| vec2::along(vec2::scale(end, 2.0), inner, -1.0);
        let (before, after) = (
            beyond(knots[0], knots[1]),
            beyond(knots[pieces], knots[pieces - 1]),
        );
        let groups = pieces.div_ceil(SIDE);
        for (c, along) in self.along.iter_mut().enumerate() {
            along.clear();
            along.push(before[c]);
            along.extend(knots.iter().map(|knot| knot[c]));
            // The last group of pieces is filled up.
            along.resize(SIDE * groups + 3, after[c]);
        }
        self.parts.resize(groups, Default::default());
        Arch::new().dispatch(Measure {
            along: self.along.each_ref().map(|along| &along[..]),
            parts: &mut self.parts,
        });
        let mut way = 0.0;
        for i in 0..pieces {
            self.ways.push(way);
            way += self.parts[i / SIDE][CHORDS][i % SIDE];
        }
        way
    }
}

/// One coordinate of a piece of the spline, as a polynomial.
#[derive(Clone, Copy)]
struct Cubic([f32; 4]);

impl Cubic {
    /// The piece from q to r, with p before it and s after it.
    #[inline(always)]
    fn new(p: f32, q: f32, r: f32, s: f32) -> Self {
        let bend = 2.0 * p - 5.0 * q + 4.0 * r - s;
        let twist = 3.0 * (q - r) + s - p;
        Self([q, 0.5 * (r - p), 0.5 * bend, 0.5 * twist])
    }

    #[inline(always)]
    fn at(self, t: f32) -> f32 {
        let [a, b, c, d] = self.0;
        a + t * (b + t * (c + t * d))
    }
}

/// Measures the pieces, group by group.
struct Measure<'a> {
    along: [&'a [f32]; 2],
    parts: &'a mut [[[f32; SIDE]; CHORDS + 1]],
}

impl WithSimd for Measure<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let [x, y] = self.along;
        for (k, parts) in self.parts.iter_mut().enumerate() {
            let (x, y) = (&x[SIDE * k..][..SIDE + 3], &y[SIDE * k..][..SIDE + 3]);
            for i in 0..SIDE {
                let x = Cubic::new(x[i], x[i + 1], x[i + 2], x[i + 3]);
                let y = Cubic::new(y[i], y[i + 1], y[i + 2], y[i + 3]);
                let (mut way, mut before) = (0.0, [x.at(0.0), y.at(0.0)]);
                for (j, part) in parts.iter_mut().enumerate().skip(1) {
                    let t = j as f32 / CHORDS as f32;
                    let here = [x.at(t), y.at(t)];
                    let (dx, dy) = (here[0] - before[0], here[1] - before[1]);
                    way += (dx * dx + dy * dy).sqrt();
                    part[i] = way;
                    before = here;
                }
            }
        }
    }
}

/// Places the points.
struct Space<'a> {
    lay: &'a mut Lay,
    step_px: f32,
}

impl WithSimd for Space<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { lay, step_px } = self;
        let last = lay.begins.len() - 1;
        let steps = 1.0 / step_px.max(1e-6);
        lay.firsts.clear();
        lay.firsts
            .extend(lay.ways.iter().map(|way| whole((way * steps).ceil())));
        for (i, &first) in lay.firsts.iter().enumerate() {
            lay.begins[(first as usize).min(last)] = i as u32;
        }
        let [x, y] = &lay.along;
        let mut piece = 0;
        for (k, point) in lay.points.iter_mut().enumerate() {
            piece = (lay.begins[k] as usize).max(piece);
            let rest = step_px * k as f32 - lay.ways[piece];
            let parts = &lay.parts[piece / SIDE];
            let i = piece % SIDE;
            // The chord that contains the point.
            let after = |j: usize| usize::from(rest > parts[j][i]);
            let chord = (after(1) + after(2) + after(3)) & (CHORDS - 1);
            let (from, to) = (parts[chord][i], parts[chord + 1][i]);
            let share = ((rest - from) / (to - from).max(1e-6)).clamp(0.0, 1.0);
            let chord = chord as i32 as f32;
            let t = (chord + share) * (1.0 / CHORDS as f32);
            let on = |v: &[f32]| {
                let v = &v[piece..][..4];
                Cubic::new(v[0], v[1], v[2], v[3]).at(t)
            };
            *point = [on(x), on(y)];
        }
    }
}

/// Moves the first knot outward by `end_px`, or inward if it is negative, and drops the knots that
/// it passes. `at` gives the knots in order from this end. Returns the number of dropped knots.
fn move_end(knots: &mut [Vec2], end_px: f32, at: impl Fn(usize) -> usize) -> usize {
    if knots.len() < 2 {
        return 0;
    }
    let mut rest = -end_px;
    let mut gone = 0;
    while gone + 2 < knots.len() {
        let spacing = vec2::distance(knots[at(gone)], knots[at(gone + 1)]);
        // A knot near the new end is replaced by it.
        if rest <= 0.7 * spacing {
            break;
        }
        rest -= spacing;
        gone += 1;
    }
    let (end, inner) = (at(gone), at(gone + 1));
    let inward = vec2::unit_or(vec2::sub(knots[inner], knots[end]), [0.0, 0.0]);
    knots[end] = vec2::along(knots[end], inward, rest);
    gone
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn points_lie_at_equal_ways_along_the_curve(
            n in 16..150usize, radius in 20.0..200f32, turn in 0.2..5.0f32,
            ends in (-3.0..1.0f32, -3.0..1.0f32),
        ) {
            // Unevenly spaced.
            let angle = |t: f32| turn * (t + 0.03 * (9.0 * t).sin());
            let places = (0..n).map(|i| {
                let (sin, cos) = angle(i as f32 / (n - 1) as f32).sin_cos();
                [radius * cos, radius * sin]
            });
            let mut lay = Lay::default();
            let spacing_px = radius * turn / n as f32;
            let ends = [ends.0 * spacing_px, ends.1 * spacing_px];
            let length_px = lay.lay(places, ends).expect("most of it is left");
            let arc_px = radius * (angle(1.0) - angle(0.0)) + ends[0] + ends[1];
            prop_assert!((length_px - arc_px).abs() < 0.02 * arc_px, "{length_px} {arc_px}");
            let points = lay.points();
            prop_assert_eq!(points.len(), n);
            let step_px = length_px / (n - 1) as f32;
            for pair in points.windows(2) {
                let way = vec2::distance(pair[0], pair[1]);
                prop_assert!(way <= 1.05 * step_px && way >= 0.95 * step_px, "{way} {step_px}");
            }
        }
    }
}
