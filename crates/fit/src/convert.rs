//! Converts curves to other forms: a higher or lower order, Bezier pieces, powers of ρ, two parts,
//! the reversed curve, more knots. These functions allocate and are not for use in every frame.

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

/// The data of a [`Curve`], owned.
#[derive(Debug, Clone, PartialEq)]
pub struct OwnedCurve<const D: usize = 2> {
    /// Family of the curve.
    pub basis: Basis,
    /// Control points.
    pub control_points: Vec<[f64; D]>,
    /// Weights of a rational curve; otherwise empty.
    pub weights: Vec<f64>,
    /// Knots of a B-spline; otherwise empty.
    pub knots: Vec<f64>,
}

impl<const D: usize> OwnedCurve<D> {
    /// Borrows this data as a curve.
    ///
    /// # Errors
    /// Fails if the public fields are not a valid curve. Values returned by this crate never fail.
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
