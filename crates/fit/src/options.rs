//! Options of a [`Fitter`](crate::Fitter).

use crate::basis::{Basis, Knots, MAX_CONTROL_POINTS};
use crate::setters::setters;
use std::fmt;

/// Highest order: 32 control points.
pub const MAX_ORDER: usize = 31;

/// Degree of the curves of [`Options::auto`].
const CUBIC: usize = 3;

/// Maximum number of points of a centerline.
pub const MAX_POINTS: usize = 256;

/// Method of computing `s = (BᵀB)⁻¹Bᵀc̄`. All three give the same control points. They differ in
/// cost and in the orders that they allow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Solver {
    /// The matrix `(BᵀB)⁻¹Bᵀ`, computed once: a fit is one product. This is the fastest method.
    Pinv,
    /// The Cholesky factor of `BᵀB`, computed once: a fit is a product and two triangular solves.
    /// Its error grows with the square of the condition number.
    Cholesky,
    /// `Q` and `R` of the Householder QR of `B`, computed once: a fit is a product and one
    /// triangular solve.
    Qr,
}

impl Solver {
    /// All solvers, with their names.
    pub const ALL: [(&str, Self); 3] = [
        ("pinv", Self::Pinv),
        ("cholesky", Self::Cholesky),
        ("qr", Self::Qr),
    ];
}

impl fmt::Display for Solver {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let named = Self::ALL.iter().find(|(_, solver)| solver == self);
        f.pad(named.map_or("", |(name, _)| name))
    }
}

/// The normalized arc length ρ of each point in the fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Rho {
    /// Even steps, as in lariat's extraction: all algebra is done in advance.
    Even,
    /// Measured along the given points, chord by chord, for unevenly spaced points: the algebra is
    /// repeated for each fit.
    Measured,
}

impl Rho {
    /// Both, with their names.
    pub const ALL: [(&str, Self); 2] = [("even", Self::Even), ("measured", Self::Measured)];
}

/// Weights of the points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Weights {
    /// All points count the same: all algebra is done in advance.
    Even,
    /// Weights are passed to [`Fitter::fit_weighted`](crate::Fitter::fit_weighted), for example 0
    /// for a hidden point.
    Given,
    /// The weights of `Given`, reduced for points far from the curve (Huber 1964) in at most 5
    /// rounds. A few outliers then hardly move the curve.
    Robust,
}

/// The settings of a [`Fitter`](crate::Fitter). Each field has a method of the same name that sets
/// it: `Options::bezier(5).points(80)`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Options {
    /// Family of curves and its size. Default: a Bezier curve of order 8, the best of the paper's
    /// four.
    pub basis: Basis,
    /// Choose the number of control points: the fewest, up to the number in `basis`, that keep the
    /// curve within a [`Tolerance`](crate::Tolerance) of its points.
    /// [`Fitter::fit_within`](crate::Fitter::fit_within) chooses for each fit, and
    /// [`Fitter::fit`](crate::Fitter::fit) does so with the default tolerance.
    /// [`SteadySize`](crate::SteadySize) keeps the size of a moving rope. Default: no.
    pub choose_size: bool,
    /// Number of points `N` of a centerline, from 2 to [`MAX_POINTS`], and at least the number of
    /// control points. Default: 120, as in the paper.
    pub points: usize,
    /// Method of solving. Default: [`Solver::Pinv`].
    pub solver: Solver,
    /// `λ ≥ 0` in the objective `Σ |cᵢ − f(ρᵢ)|² + λ Σ |sⱼ₋₁ − 2sⱼ + sⱼ₊₁|²`. The second
    /// differences of the control points regularize high orders. Unlike their plain squares, they
    /// are 0 for every evenly spaced straight line, so moving a rope only moves its descriptor. For
    /// a Fourier series they are the coefficients times the square of their harmonic. Default: 0.
    pub ridge: f64,
    /// Make the curve begin and end exactly at the first and the last point. Default: no.
    pub pin_ends: bool,
    /// Arc lengths of the points. Default: [`Rho::Even`].
    pub rho: Rho,
    /// Weights of the points. Default: [`Weights::Even`].
    pub weights: Weights,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            basis: Basis::Bezier { order: 8 },
            choose_size: false,
            points: 120,
            solver: Solver::Pinv,
            ridge: 0.0,
            pin_ends: false,
            rho: Rho::Even,
            weights: Weights::Even,
        }
    }
}

impl Options {
    /// A Bezier curve of this order, with all other options at their defaults.
    pub fn bezier(order: usize) -> Self {
        Self::default().basis(Basis::Bezier { order })
    }

    /// A uniform cubic B-spline of this many control points, with all other options at their
    /// defaults.
    pub fn bspline(control_points: usize) -> Self {
        Self::default().basis(Basis::BSpline {
            degree: CUBIC,
            control_points,
            knots: Knots::Uniform,
        })
    }

    /// The Fourier series of a closed curve with this many harmonics, with all other options at
    /// their defaults.
    pub fn fourier(harmonics: usize) -> Self {
        Self::default().basis(Basis::Fourier { harmonics })
    }

    /// The fewest control points, up to the maximum, that keep the curve within a tolerance of its
    /// `points` points. The curve is a cubic Bezier curve or a uniform cubic B-spline or, if
    /// closed, a Fourier series. The noise gain of these curves hardly grows with the number of
    /// control points.
    pub fn auto(points: usize, closed: bool) -> Self {
        let most = MAX_CONTROL_POINTS.min(points);
        let family = if closed {
            Self::fourier((most.saturating_sub(1) / 2).max(1))
        } else if most > CUBIC + 1 {
            Self::bspline(most)
        } else {
            Self::bezier(most.saturating_sub(1).max(1))
        };
        let choose_size = closed || most > CUBIC + 1;
        family.points(points).choose_size(choose_size)
    }
}

setters! {
    Options {
        basis: Basis,
        choose_size: bool,
        points: usize,
        solver: Solver,
        ridge: f64,
        pin_ends: bool,
        rho: Rho,
        weights: Weights,
    }
}
