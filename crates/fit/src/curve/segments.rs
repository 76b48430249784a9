//! Parts of a curve that can be halved and have a bound on their deviation from the chord.

use super::derivatives::{minus, norm};
use super::pieces::KnotSpan;
use super::series;
use crate::basis::MAX_CONTROL_POINTS;

/// A part of a curve.
pub(crate) trait Segment<const D: usize>: Sized {
    /// Its range of ρ.
    fn span(&self) -> [f64; 2];

    /// Its two ends.
    fn chord(&self) -> [[f64; D]; 2];

    /// Upper bound of the distance of its points from the chord.
    fn deviation(&self) -> f64;

    /// Its first and its second half.
    fn halves(&self) -> [Self; 2];
}

/// A part of a Bezier piece, as a separate Bezier curve.
pub(crate) struct BezierSegment<const D: usize> {
    span: [f64; 2],
    count: usize,
    /// Control points, times their weights if any.
    points: [[f64; D]; MAX_CONTROL_POINTS],
    weights: Option<[[f64; 1]; MAX_CONTROL_POINTS]>,
}

impl<const D: usize> BezierSegment<D> {
    pub(crate) fn new(piece: &KnotSpan<'_, D>) -> Self {
        let count = piece.points.len();
        let mut points = [[0.0; D]; MAX_CONTROL_POINTS];
        points[..count].copy_from_slice(piece.points);
        let weights = (!piece.weights.is_empty()).then(|| {
            let mut weights = [[1.0]; MAX_CONTROL_POINTS];
            weights[..count].copy_from_slice(piece.weights);
            weights
        });
        Self {
            span: [piece.from, piece.to],
            count,
            points,
            weights,
        }
    }

    /// A control point divided by its weight.
    fn control_point(&self, j: usize) -> [f64; D] {
        match &self.weights {
            Some(weights) => self.points[j].map(|c| c / weights[j][0]),
            None => self.points[j],
        }
    }
}

impl<const D: usize> Segment<D> for BezierSegment<D> {
    fn span(&self) -> [f64; 2] {
        self.span
    }

    fn chord(&self) -> [[f64; D]; 2] {
        [self.control_point(0), self.control_point(self.count - 1)]
    }

    /// A point of the curve is a mean of control points with nonnegative shares. The same mean of
    /// points of the chord is on the chord. The control points therefore bound the deviation: each
    /// is compared with the point of the same index when the chord is divided into even steps.
    fn deviation(&self) -> f64 {
        let [from, to] = self.chord();
        let mut largest = 0.0f64;
        for j in 1..self.count - 1 {
            let share = j as f64 / (self.count - 1) as f64;
            let point = self.control_point(j);
            let squared: f64 = (0..D)
                .map(|axis| (point[axis] - from[axis] - share * (to[axis] - from[axis])).powi(2))
                .sum();
            largest = largest.max(squared);
        }
        largest.sqrt()
    }

    fn halves(&self) -> [Self; 2] {
        let [from, to] = self.span;
        let middle = 0.5 * (from + to);
        let (first, second) = halved(&self.points, self.count);
        let weights = self
            .weights
            .as_ref()
            .map(|weights| halved(weights, self.count));
        let (first_weights, second_weights) = weights.unzip();
        let half = |span, points, weights| Self {
            span,
            count: self.count,
            points,
            weights,
        };
        [
            half([from, middle], first, first_weights),
            half([middle, to], second, second_weights),
        ]
    }
}

type ControlPoints<const D: usize> = [[f64; D]; MAX_CONTROL_POINTS];

/// De Casteljau's recurrence at ½. Its left and right edges are the halves' control points.
fn halved<const D: usize>(
    points: &ControlPoints<D>,
    count: usize,
) -> (ControlPoints<D>, ControlPoints<D>) {
    let mut first = [[0.0; D]; MAX_CONTROL_POINTS];
    let mut second = *points;
    for (done, edge) in first[..count].iter_mut().enumerate() {
        *edge = second[0];
        for j in 0..count - 1 - done {
            second[j] = middle(&second[j], &second[j + 1]);
        }
    }
    (first, second)
}

#[inline]
fn middle<const D: usize>(a: &[f64; D], b: &[f64; D]) -> [f64; D] {
    std::array::from_fn(|axis| 0.5 * (a[axis] + b[axis]))
}

/// An arc of a Fourier series.
pub(crate) struct SeriesSegment<'a, const D: usize> {
    coefficients: &'a [[f64; D]],
    /// A bound on the second derivative.
    second: f64,
    span: [f64; 2],
    chord: [[f64; D]; 2],
}

impl<'a, const D: usize> SeriesSegment<'a, D> {
    /// Creates the arc of a full turn.
    pub(crate) fn new(coefficients: &'a [[f64; D]]) -> Self {
        let [start] = series::jet(coefficients, 0.0);
        Self {
            coefficients,
            second: series::second_bound(coefficients),
            span: [0.0, 1.0],
            chord: [start; 2],
        }
    }
}

impl<const D: usize> Segment<D> for SeriesSegment<'_, D> {
    fn span(&self) -> [f64; 2] {
        self.span
    }

    fn chord(&self) -> [[f64; D]; 2] {
        self.chord
    }

    /// Linear interpolation over a step `h` has an error of at most `max |f″| h²/8`.
    fn deviation(&self) -> f64 {
        self.second * (self.span[1] - self.span[0]).powi(2) / 8.0
    }

    fn halves(&self) -> [Self; 2] {
        let middle = 0.5 * (self.span[0] + self.span[1]);
        let [point] = series::jet(self.coefficients, middle);
        let half = |span, chord| Self {
            span,
            chord,
            ..*self
        };
        [
            half([self.span[0], middle], [self.chord[0], point]),
            half([middle, self.span[1]], [point, self.chord[1]]),
        ]
    }
}

/// Position along a chord, from 0 to 1, of the chord's nearest point to `to`.
pub(crate) fn nearest_on_chord<const D: usize>(chord: &[[f64; D]; 2], to: &[f64; D]) -> f64 {
    let along = minus(&chord[1], &chord[0]);
    let length = norm(&along);
    if length == 0.0 {
        return 0.0;
    }
    let direction = along.map(|c| c / length);
    let reach: f64 = (0..D)
        .map(|axis| (to[axis] - chord[0][axis]) * direction[axis])
        .sum();
    (reach / length).clamp(0.0, 1.0)
}
