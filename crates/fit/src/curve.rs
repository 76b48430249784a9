//! A fitted curve as its users need it: points, direction, curvature, length, the nearest point,
//! and the derivatives of these with respect to the control points.
//!
//! Every family except the Fourier series is a sequence of Bezier pieces (with weighted control
//! points, if rational). [`Curve::new`] computes them on the stack, and all other functions use the
//! pieces.

mod derivatives;
mod descent;
mod distance;
mod error;
mod length;
mod nearest;
mod pieces;
mod polynomial;
mod segments;
mod series;

pub use distance::Distance;
pub use error::CurveError;
pub use nearest::Nearest;

use crate::basis::{Basis, Knots, MAX_CONTROL_POINTS};
use crate::functions::{self, MAX_KNOTS};
use pieces::{KnotSpan, Pieces};

/// A curve of any [`Basis`] in `D` dimensions: `f(ρ)`, ρ from 0 to 1.
///
/// It borrows the control points, stores everything else inline and does not allocate. Creating a
/// curve costs about as much as evaluating a dozen points. Lengths are in the control points' unit
/// (px), and curvatures in its inverse.
///
/// Outside 0 to 1, polynomials are continued: B-splines and feature points by their first and last
/// piece. A Fourier series is periodic. A rational curve may reach infinity there.
///
/// ```
/// use lariat_fit::Curve;
///
/// let curve = Curve::bezier(&[[0.0, 0.0], [50.0, 100.0], [100.0, 0.0]])?;
/// assert_eq!(curve.point(0.5), [50.0, 50.0]);
/// assert_eq!(curve.tangent(0.5), Some([1.0, 0.0]));
/// assert!((curve.nearest([50.0, 80.0]).distance - 30.0).abs() < 1e-9);
/// # Ok::<(), lariat_fit::CurveError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Curve<'a, const D: usize = 2> {
    basis: Basis,
    control_points: &'a [[f64; D]],
    weights: &'a [f64],
    knots: [f64; MAX_KNOTS],
    knot_count: usize,
    pieces: Pieces<D>,
}

impl<'a, const D: usize> Curve<'a, D> {
    /// Creates the curve of these control points.
    ///
    /// `weights` are for rational curves, one positive number per control point; other bases have
    /// none. `knots` are for B-splines: the full clamped vector from 0 to 1, of `control_points +
    /// degree + 1` numbers. `knots` may be empty if the knots are even ([`Knots::Uniform`]), and
    /// must be empty for all other bases.
    ///
    /// # Errors
    /// Fails if the numbers of control points, weights or knots do not match the basis, if a number
    /// is not finite, if a weight is not positive, or if knots descend or repeat too often.
    pub fn new(
        basis: Basis,
        control_points: &'a [[f64; D]],
        weights: &'a [f64],
        knots: &[f64],
    ) -> Result<Self, CurveError> {
        error::check(basis, control_points, weights)?;
        let mut own = [0.0; MAX_KNOTS];
        let knot_count = match basis {
            Basis::BSpline {
                knots: Knots::Averaged,
                ..
            } if knots.is_empty() => return Err(CurveError::KnotsWanted),
            Basis::BSpline { degree, .. } if !knots.is_empty() => {
                error::check_knots(degree, control_points.len(), knots)?;
                own[..knots.len()].copy_from_slice(knots);
                knots.len()
            }
            _ if !knots.is_empty() => return Err(CurveError::NoKnots { basis }),
            // Even knots do not depend on the positions of the points.
            _ => functions::knots(basis, &[], &mut own),
        };
        let pieces = Pieces::new(basis, control_points, weights, &own[..knot_count]);
        Ok(Self {
            basis,
            control_points,
            weights,
            knots: own,
            knot_count,
            pieces,
        })
    }

    /// Creates the Bezier curve of 1 to 32 control points.
    ///
    /// # Errors
    /// Fails for 0 or more than 32 control points, or if one is not finite.
    pub fn bezier(control_points: &'a [[f64; D]]) -> Result<Self, CurveError> {
        let order = control_points.len().saturating_sub(1);
        Self::new(Basis::Bezier { order }, control_points, &[], &[])
    }

    /// The family of the curve.
    pub fn basis(&self) -> Basis {
        self.basis
    }

    /// The control points.
    pub fn control_points(&self) -> &'a [[f64; D]] {
        self.control_points
    }

    /// Weights of a rational curve; empty for other bases.
    pub fn weights(&self) -> &'a [f64] {
        self.weights
    }

    /// Knots of a B-spline, or those that make feature points the corners of a polyline; empty for
    /// other bases.
    pub fn knots(&self) -> &[f64] {
        &self.knots[..self.knot_count]
    }

    /// Writes the derivative of the curve's point at `rho` with respect to each control point to
    /// `values`, one number for each: `∂f(ρ)/∂sⱼ`, the same for every axis. These are the values of
    /// the basis functions. For a rational curve, they are the rational ones, `wⱼ Bⱼ / Σ w B`.
    ///
    /// If `values` is too short, only the first entries are written.
    pub fn jacobian(&self, rho: f64, values: &mut [f64]) {
        let mut all = [0.0; MAX_CONTROL_POINTS];
        let all = &mut all[..self.control_points.len()];
        functions::values(self.basis, self.knots(), rho, all);
        if !self.weights.is_empty() {
            for (value, weight) in all.iter_mut().zip(self.weights) {
                *value *= weight;
            }
            let sum: f64 = all.iter().sum();
            for value in all.iter_mut() {
                *value /= sum;
            }
        }
        for (place, value) in values.iter_mut().zip(all) {
            *place = *value;
        }
    }

    /// Writes the derivative of the curve's point at `rho` with respect to each control point's
    /// weight to `values`, one vector for each: `∂f(ρ)/∂wⱼ = Bⱼ (pⱼ − f) / Σ w B`, or zeros if the
    /// basis has no weights.
    ///
    /// If `values` is too short, only the first entries are written.
    pub fn weight_jacobian(&self, rho: f64, values: &mut [[f64; D]]) {
        let count = self.control_points.len().min(values.len());
        values[..count].fill([0.0; D]);
        if self.weights.is_empty() {
            return;
        }
        let point = self.point(rho);
        let mut shares = [0.0; MAX_CONTROL_POINTS];
        self.jacobian(rho, &mut shares);
        for (j, value) in values[..count].iter_mut().enumerate() {
            for axis in 0..D {
                let away = self.control_points[j][axis] - point[axis];
                value[axis] = shares[j] / self.weights[j] * away;
            }
        }
    }

    /// Its Bezier pieces; none for a Fourier series.
    pub(crate) fn pieces(&self) -> impl Iterator<Item = KnotSpan<'_, D>> {
        (0..self.pieces.count()).map(|index| self.pieces.piece(index))
    }

    /// The first `K` derivatives with respect to ρ at `rho`, from the 0th: the point, its velocity,
    /// and so on.
    fn jet<const K: usize>(&self, rho: f64) -> [[f64; D]; K] {
        if self.basis.is_closed() {
            series::jet(self.control_points, rho)
        } else {
            self.pieces.jet(rho)
        }
    }
}
