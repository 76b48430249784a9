//! Global minimum of a number over a curve, by branch and bound.
//!
//! The number (a distance, a coordinate) is a function of a point, and differs between two points
//! by at most their distance. On a part of the curve that deviates from its chord by at most δ, it
//! is therefore at least its minimum on the chord minus δ. Parts that cannot contain less than the
//! best value are discarded, and the others are halved. Each halving reduces δ to a quarter.
//! Newton's method improves each candidate at once, which rules out most other parts.
//!
//! Near the minimum, few parts remain, as δ competes with a parabola. Many remain only if the
//! number is almost constant along a stretch of the curve, such as the distance of a circle from
//! its center. The tolerance grows with the number of parts examined, which bounds the work.

use super::Curve;
use super::pieces::KnotSpan;
use super::segments::{BezierSegment, Segment, SeriesSegment};

/// Maximum excess over the minimum, as a share of the curve's size.
pub(crate) const TOLERANCE: f64 = 1e-9;

/// Number of parts after which the tolerance grows by a factor of four. After 17 such rounds (4352
/// parts) it equals the curve's size.
const PATIENCE: u32 = 256;

/// The number to minimize.
pub(crate) trait Objective<const D: usize> {
    /// Its minimum on a chord, and the position of that minimum on the chord, from 0 to 1.
    fn on_chord(&self, chord: &[[f64; D]; 2]) -> (f64, f64);

    /// Its value at a point of the curve, and its first two derivatives with respect to ρ, given
    /// the point and its derivatives. The result may contain the derivatives of another function
    /// with the same minima.
    fn at(&self, jet: &[[f64; D]; 3]) -> Slope;
}

/// A value along the curve, with derivatives.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Slope {
    pub(crate) value: f64,
    pub(crate) first: f64,
    pub(crate) second: f64,
}

/// A minimum on a curve.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Least {
    pub(crate) rho: f64,
    pub(crate) value: f64,
}

impl<const D: usize> Curve<'_, D> {
    /// Finds the minimum of `objective` over the curve, to [`TOLERANCE`] of its size.
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
            // A tiny negative number has been rounded to the start of the next turn.
            if rho >= 1.0 {
                rho = 0.0;
            }
        }
        Least { rho, value }
    }

    /// Distance of the farthest control point from the first, or the extent of a closed curve.
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
    /// The smooth part to which Newton's method is confined; `None` for the whole curve.
    piece: Option<KnotSpan<'a, D>>,
    best: Least,
    tolerance: f64,
    /// Maximum difference of values that counts as rounding.
    rounding: f64,
    visits: u32,
}

impl<const D: usize, O: Objective<D>> Search<'_, '_, D, O> {
    /// Finds a first candidate. With two steps for each control point, it is on the right part of
    /// most curves.
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
        // The interval cannot be halved any more.
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

    /// Returns whether a bound is below the best value by more than the tolerance; `false` for NaN.
    fn can_hold_less(&self, bound: f64) -> bool {
        bound < self.best.value - self.tolerance
    }

    /// Runs Newton's method from `rho` within the smooth part, with a trust region, and records the
    /// result.
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
        // Enough to halve a quarter down to an ulp, with some other steps in between.
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
            // At the minimum, values differ only by rounding, but the slope is still meaningful.
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
