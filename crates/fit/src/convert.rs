//! One curve in other words: of a higher or lower order, in pieces, as powers of ρ, in two parts, backwards, with
//! more knots. Nothing here is made for every frame: all of it allocates.

mod degree;
mod knots;
mod monomial;
mod parts;

pub use degree::{Reduced, elevate_degree, reduce_degree};
pub use knots::{BezierPiece, bezier_pieces, insert_knot};
pub use monomial::{from_monomial, to_monomial};
pub use parts::{reverse, split_at};

use crate::basis::Basis;
use crate::curve::{Curve, CurveError};

/// What a [`Curve`] is made of, by itself.
#[derive(Debug, Clone, PartialEq)]
pub struct OwnedCurve<const D: usize = 2> {
    /// The family it belongs to.
    pub basis: Basis,
    /// The control points.
    pub control_points: Vec<[f64; D]>,
    /// Weights of a rational curve; of others none.
    pub weights: Vec<f64>,
    /// Knots of a B-spline; of others none.
    pub knots: Vec<f64>,
}

impl<const D: usize> OwnedCurve<D> {
    /// The curve of it.
    ///
    /// # Errors
    /// Where the fields, which are open to everyone, do not make a curve; never for what this crate returned.
    pub fn as_curve(&self) -> Result<Curve<'_, D>, CurveError> {
        Curve::new(self.basis, &self.control_points, &self.weights, &self.knots)
    }
}

impl<const D: usize> From<&Curve<'_, D>> for OwnedCurve<D> {
    fn from(curve: &Curve<'_, D>) -> Self {
        let knots = match curve.basis() {
            Basis::BSpline { .. } => curve.knots(),
            _ => &[],
        };
        Self {
            basis: curve.basis(),
            control_points: curve.control_points().to_vec(),
            weights: curve.weights().to_vec(),
            knots: knots.to_vec(),
        }
    }
}
