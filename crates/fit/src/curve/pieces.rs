//! A curve as consecutive Bezier pieces.

use super::polynomial;
use crate::basis::{Basis, MAX_CONTROL_POINTS};

/// Maximum number of control points of all pieces. A B-spline of degree `d` with `m` control points
/// has at most `m − d` pieces of `d + 1` points, and (32 − d)(d + 1) is largest at 15 and 16.
const MAX_PIECE_POINTS: usize = 272;

/// Bezier pieces of one degree, each over a part of ρ.
#[derive(Debug, Clone)]
pub(crate) struct Pieces<const D: usize> {
    degree: usize,
    count: usize,
    /// Piece `i` is from `breaks[i]` to `breaks[i + 1]`.
    breaks: [f64; MAX_CONTROL_POINTS + 1],
    /// `degree + 1` control points of each piece, times their weights if rational.
    points: [[f64; D]; MAX_PIECE_POINTS],
    weights: [[f64; 1]; MAX_CONTROL_POINTS],
    rational: bool,
}

/// One piece.
#[derive(Debug, Clone, Copy)]
pub(crate) struct KnotSpan<'a, const D: usize> {
    pub(crate) from: f64,
    pub(crate) to: f64,
    /// Control points, times their weights if any.
    pub(crate) points: &'a [[f64; D]],
    /// Empty, or one weight for each point.
    pub(crate) weights: &'a [[f64; 1]],
}

impl<const D: usize> Pieces<D> {
    /// Creates the pieces of a valid curve. A Fourier series has none.
    pub(crate) fn new(
        basis: Basis,
        control_points: &[[f64; D]],
        weights: &[f64],
        knots: &[f64],
    ) -> Self {
        let mut pieces = Self {
            degree: basis.order(),
            count: 1,
            breaks: [0.0; MAX_CONTROL_POINTS + 1],
            points: [[0.0; D]; MAX_PIECE_POINTS],
            weights: [[0.0]; MAX_CONTROL_POINTS],
            rational: !weights.is_empty(),
        };
        pieces.breaks[1] = 1.0;
        match basis {
            Basis::Fourier { .. } => pieces.count = 0,
            Basis::BSpline { .. } | Basis::FeaturePoints { .. } => {
                let Self { points, breaks, .. } = &mut pieces;
                pieces.count = to_bezier(basis.order(), knots, control_points, points, breaks);
            }
            _ => {
                pieces.points[..control_points.len()].copy_from_slice(control_points);
                for (j, &weight) in weights.iter().enumerate() {
                    pieces.weights[j] = [weight];
                    for coordinate in &mut pieces.points[j] {
                        *coordinate *= weight;
                    }
                }
            }
        }
        pieces
    }

    pub(crate) fn count(&self) -> usize {
        self.count
    }

    pub(crate) fn piece(&self, index: usize) -> KnotSpan<'_, D> {
        let size = self.degree + 1;
        KnotSpan {
            from: self.breaks[index],
            to: self.breaks[index + 1],
            points: &self.points[index * size..(index + 1) * size],
            weights: if self.rational {
                &self.weights[..size]
            } else {
                &[]
            },
        }
    }

    /// Index of the piece that contains `rho`: the later piece where two meet, and the first or
    /// last piece beyond the ends.
    pub(crate) fn at(&self, rho: f64) -> usize {
        let meetings = &self.breaks[1..self.count];
        meetings.partition_point(|&meeting| meeting <= rho)
    }

    /// The first `K` derivatives with respect to ρ, from the 0th.
    #[inline]
    pub(crate) fn jet<const K: usize>(&self, rho: f64) -> [[f64; D]; K] {
        self.piece(self.at(rho)).jet(rho)
    }
}

impl<const D: usize> KnotSpan<'_, D> {
    /// The first `K` derivatives with respect to ρ, from the 0th.
    #[inline]
    pub(crate) fn jet<const K: usize>(&self, rho: f64) -> [[f64; D]; K] {
        let length = self.to - self.from;
        let local = (rho - self.from) / length;
        let mut jet = polynomial::jet::<D, K>(self.points, local);
        if !self.weights.is_empty() {
            divide(&mut jet, &polynomial::jet::<1, K>(self.weights, local));
        }
        if length != 1.0 {
            let mut scale = 1.0;
            for derivative in &mut jet {
                for coordinate in derivative {
                    *coordinate *= scale;
                }
                scale /= length;
            }
        }
        jet
    }
}

/// Converts the derivatives of `w f` and of `w` to those of `f`, by Leibniz's rule:
/// `(w f)⁽ᵏ⁾ = Σ C(k,i) w⁽ⁱ⁾ f⁽ᵏ⁻ⁱ⁾`.
fn divide<const D: usize, const K: usize>(jet: &mut [[f64; D]; K], weight: &[[f64; 1]; K]) {
    for k in 0..K {
        for (i, &binomial) in polynomial::binomials(k).iter().enumerate().skip(1) {
            let lower = jet[k - i];
            for axis in 0..D {
                jet[k][axis] -= binomial * weight[i][0] * lower[axis];
            }
        }
        for coordinate in &mut jet[k] {
            *coordinate /= weight[0][0];
        }
    }
}

/// Splits a clamped B-spline into Bezier pieces, by inserting each knot until it separates pieces
/// (Piegl and Tiller, *The NURBS Book*, algorithm A5.6). Writes the `degree + 1` control points of
/// each to `points`, and the pieces' ends in ρ to `breaks` (one more than there are pieces).
/// Returns the number of pieces.
///
/// `knots` must be clamped and ascending, and may repeat at most `degree` times inside.
pub(crate) fn to_bezier<const D: usize>(
    degree: usize,
    knots: &[f64],
    control_points: &[[f64; D]],
    points: &mut [[f64; D]],
    breaks: &mut [f64],
) -> usize {
    let size = degree + 1;
    let last = knots.len() - 1;
    let (mut from, mut to, mut piece) = (degree, degree + 1, 0);
    points[..size].copy_from_slice(&control_points[..size]);
    breaks[0] = knots[degree];
    loop {
        let first = to;
        while to < last && knots[to + 1] == knots[to] {
            to += 1;
        }
        let times = to - first + 1;
        breaks[piece + 1] = knots[to];
        let begin = piece * size;
        for inserted in times + 1..=degree {
            // Inserts knot `to` for the `inserted`-th time: every point from there on moves towards
            // the one before.
            for k in (inserted..=degree).rev() {
                let reach = knots[from + k + times + 1 - inserted] - knots[from];
                let share = (knots[to] - knots[from]) / reach;
                let (before, here) = (points[begin + k - 1], points[begin + k]);
                points[begin + k] =
                    std::array::from_fn(|axis| share * here[axis] + (1.0 - share) * before[axis]);
            }
            // Not reached at the end, where the knot is already repeated, so there is a next piece.
            points[begin + size + degree - inserted] = points[begin + degree];
        }
        piece += 1;
        if to >= last {
            return piece;
        }
        for i in degree - times..=degree {
            points[begin + size + i] = control_points[to - degree + i];
        }
        (from, to) = (to, to + 1);
    }
}
