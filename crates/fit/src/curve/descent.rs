//! The least of a number over all of a curve, by branch and bound.
//!
//! The number (a distance, a coordinate) belongs to a point, and no two points differ in it by more than they
//! are apart. So on a part of the curve that strays from its chord by at most δ it is at least its least on
//! the chord less δ. Parts that cannot hold less than what is found are let go, others halved: δ falls to a
//! quarter each time. What is found is improved at once by Newton's method, which makes most other parts
//! hopeless.
//!
//! Few parts near the least stay, δ against a parabola. Only where the curve keeps almost the same
//! number over a length (a circle about its middle) there are many; there the tolerance grows with the work, so
//! that the work is bounded.

use super::Curve;
use super::pieces::KnotSpan;
use super::segments::{BezierSegment, Segment, SeriesSegment};

/// How much more than the least may be found, as a share of the curve's size.
pub(crate) const TOLERANCE: f64 = 1e-9;

/// After so many parts the tolerance is four times as large: after 17 such rounds, 4352 parts, it is the
/// curve's size.
const PATIENCE: u32 = 256;

/// What is sought the least of.
pub(crate) trait Objective<const D: usize> {
    /// The least of it on a chord, and where: from 0 to 1.
    fn on_chord(&self, chord: &[[f64; D]; 2]) -> (f64, f64);

    /// Its value at a point of the curve, and two derivatives by ρ of it, or of what has its minima where it
    /// has them; by the point's own.
    fn at(&self, jet: &[[f64; D]; 3]) -> Slope;
}

/// A value along the curve, and where it goes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Slope {
    pub(crate) value: f64,
    pub(crate) first: f64,
    pub(crate) second: f64,
}

/// Where on a curve something is least.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Least {
    pub(crate) rho: f64,
    pub(crate) value: f64,
}

impl<const D: usize> Curve<'_, D> {
    /// The least of `objective` over the curve, to [`TOLERANCE`] of its size.
    pub(crate) fn least(&self, objective: &impl Objective<D>) -> Least {
        let closed = self.basis.is_closed();
        let mut search = Search {
            curve: self,
            objective,
            piece: None,
            best: Least {
                rho: 0.0,
                value: f64::INFINITY,
            },
            tolerance: TOLERANCE * self.size(),
            rounding: self.rounding(),
            visits: 0,
        };
        search.begin();
        if closed {
            search.descend(&SeriesSegment::new(self.control_points));
        } else {
            for piece in self.pieces() {
                search.piece = Some(piece);
                search.descend(&BezierSegment::new(&piece));
            }
        }
        let Least { mut rho, value } = search.best;
        if closed {
            rho -= rho.floor();
            // What was a hair below 0 has been rounded to where the next turn begins.
            if rho >= 1.0 {
                rho = 0.0;
            }
        }
        Least { rho, value }
    }

    /// How far from the first control point the others are, or the reach of a closed curve.
    pub(crate) fn size(&self) -> f64 {
        let origin = match self.control_points.first() {
            Some(first) if !self.basis.is_closed() => *first,
            _ => [0.0; D],
        };
        let others = self.control_points.iter().skip(1);
        let mut largest = 0.0f64;
        for point in others {
            for axis in 0..D {
                largest = largest.max((point[axis] - origin[axis]).abs());
            }
        }
        largest
    }
}

struct Search<'a, 'c, const D: usize, O> {
    curve: &'a Curve<'c, D>,
    objective: &'a O,
    /// The part within which the curve is smooth, and Newton's method may go; none: everywhere.
    piece: Option<KnotSpan<'a, D>>,
    best: Least,
    tolerance: f64,
    /// By how much values may differ that are the same.
    rounding: f64,
    visits: u32,
}

impl<const D: usize, O: Objective<D>> Search<'_, '_, D, O> {
    /// A first guess: two steps for each control point find the right part of most curves.
    fn begin(&mut self) {
        let steps = 2 * self.curve.control_points.len();
        let mut first = self.best;
        for i in 0..=steps {
            let rho = i as f64 / steps as f64;
            let [point] = self.curve.jet(rho);
            let (value, _) = self.objective.on_chord(&[point; 2]);
            if value < first.value {
                first = Least { rho, value };
            }
        }
        if !self.curve.basis.is_closed() {
            let pieces = &self.curve.pieces;
            self.piece = Some(pieces.piece(pieces.at(first.rho)));
        }
        self.improve(first.rho);
    }

    fn descend(&mut self, segment: &impl Segment<D>) {
        self.visits += 1;
        if self.visits.is_multiple_of(PATIENCE) {
            self.tolerance *= 4.0;
        }
        let (on_chord, share) = self.objective.on_chord(&segment.chord());
        if !self.can_hold_less(on_chord - segment.deviation()) {
            return;
        }
        let [from, to] = segment.span();
        let rho = from + share * (to - from);
        let [point] = self.curve.jet(rho);
        let (value, _) = self.objective.on_chord(&[point; 2]);
        if self.can_hold_less(value) {
            self.improve(rho);
            if !self.can_hold_less(on_chord - segment.deviation()) {
                return;
            }
        }
        // Numbers have no middle any more.
        let middle = 0.5 * (from + to);
        if middle <= from || middle >= to {
            return;
        }
        let [first, second] = segment.halves();
        if share <= 0.5 {
            self.descend(&first);
            self.descend(&second);
        } else {
            self.descend(&second);
            self.descend(&first);
        }
    }

    /// Whether a bound is below what is found, by more than matters. Not if it is NaN.
    fn can_hold_less(&self, bound: f64) -> bool {
        bound < self.best.value - self.tolerance
    }

    /// Newton's method from `rho` within the smooth part, each step no longer than it has proved to be good
    /// for; takes what it ends at.
    fn improve(&mut self, rho: f64) {
        let (low, high) = match &self.piece {
            Some(piece) => (piece.from, piece.to),
            None => (f64::NEG_INFINITY, f64::INFINITY),
        };
        let slope = |rho: f64| {
            self.objective.at(&match &self.piece {
                Some(piece) => piece.jet(rho),
                None => self.curve.jet(rho),
            })
        };
        let (mut rho, mut here) = (rho, slope(rho));
        let mut reach = 0.25 * (high - low).min(1.0);
        // Halvings from a quarter to an ulp, and some steps between them.
        for _ in 0..64 {
            let newton = -here.first / here.second;
            let downhill = if here.second > 0.0 && newton.is_finite() {
                newton.clamp(-reach, reach)
            } else {
                -reach.copysign(here.first)
            };
            let next = (rho + downhill).clamp(low, high);
            let step = (next - rho).abs();
            if step <= f64::EPSILON * rho.abs().max(f64::EPSILON) {
                break;
            }
            let there = slope(next);
            // At the bottom the values differ in rounding alone; the slope still tells.
            let level = there.value - here.value <= self.rounding;
            if there.value < here.value || (level && there.first.abs() < here.first.abs()) {
                (rho, here) = (next, there);
            } else {
                reach = 0.25 * step;
            }
        }
        if here.value < self.best.value {
            self.best = Least {
                rho,
                value: here.value,
            };
        }
    }
}
