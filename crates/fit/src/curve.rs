//! A fitted curve as its users see it: any point of it, where it goes, how it bends, how long it is, what of it
//! is nearest, and how all that moves with the control points.
//!
//! Every family but the Fourier series is a run of Bezier pieces (of weighted control points, if rational):
//! [`Curve::new`] makes them, on the stack, and all else is asked of the pieces.

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
/// It borrows the control points, keeps all else to itself and allocates nothing; making one costs about as
/// much as a dozen points of it. The control points' unit (px) is that of all lengths, and its inverse that of
/// curvatures.
///
/// Outside 0 to 1 a polynomial goes on as such, B-splines and feature points by their first and last piece, and a
/// Fourier series around again. A rational curve may run to infinity there.
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
    /// The curve of these control points.
    ///
    /// `weights` belong to rational curves, one to each control point, and are positive; for others there are
    /// none. `knots` belong to B-splines: the full clamped vector from 0 to 1, `control_points + degree + 1` of
    /// them; they may be left out where they lie evenly ([`Knots::Uniform`]), and for all other bases they are.
    ///
    /// # Errors
    /// Numbers of control points, weights or knots that do not fit the basis, numbers that are not finite,
    /// weights that are not positive, knots that descend or come too often.
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
            // Even knots do not depend on where the points are.
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

    /// The Bezier curve of 1 to 32 control points.
    ///
    /// # Errors
    /// No control point, more than 32, or one that is not finite.
    pub fn bezier(control_points: &'a [[f64; D]]) -> Result<Self, CurveError> {
        let order = control_points.len().saturating_sub(1);
        Self::new(Basis::Bezier { order }, control_points, &[], &[])
    }

    /// The family it belongs to.
    pub fn basis(&self) -> Basis {
        self.basis
    }

    /// What it was made of.
    pub fn control_points(&self) -> &'a [[f64; D]] {
        self.control_points
    }

    /// A rational curve's weights; none of other bases.
    pub fn weights(&self) -> &'a [f64] {
        self.weights
    }

    /// A B-spline's knots, or those that make feature points the corners of a polyline; none of other bases.
    pub fn knots(&self) -> &[f64] {
        &self.knots[..self.knot_count]
    }

    /// Writes to `values`, one number for each control point, how much the curve's point at `rho` moves with
    /// it: `∂f(ρ)/∂sⱼ`, the same for every axis. These are the values of the basis's functions; of a rational
    /// curve the rational ones, `wⱼ Bⱼ / Σ w B`.
    ///
    /// Only as many are written as there are places and control points.
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

    /// Writes to `values`, one vector for each control point, how the curve's point at `rho` moves with that
    /// control point's weight: `∂f(ρ)/∂wⱼ = Bⱼ (pⱼ − f) / Σ w B`; zeros where the basis has no weights.
    ///
    /// Only as many are written as there are places and control points.
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

    /// Its Bezier pieces; of a Fourier series none.
    pub(crate) fn pieces(&self) -> impl Iterator<Item = KnotSpan<'_, D>> {
        (0..self.pieces.count()).map(|index| self.pieces.piece(index))
    }

    /// The `K` derivatives at `rho` from the 0th: the point, the velocity by ρ, and so on.
    fn jet<const K: usize>(&self, rho: f64) -> [[f64; D]; K] {
        if self.basis.is_closed() {
            series::jet(self.control_points, rho)
        } else {
            self.pieces.jet(rho)
        }
    }
}
