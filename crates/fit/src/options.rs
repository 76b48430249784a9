//! What a [`Fitter`](crate::Fitter) is asked for.

use crate::basis::{Basis, Knots, MAX_CONTROL_POINTS};
use crate::setters::setters;
use std::fmt;

/// The highest order: 32 control points.
pub const MAX_ORDER: usize = 31;

/// The degree of the curves of [`Options::auto`].
const CUBIC: usize = 3;

/// The most points of a centerline.
pub const MAX_POINTS: usize = 256;

/// How `s = (BᵀB)⁻¹Bᵀc̄` is computed. All three give the same control points; they differ in cost and in
/// the orders they can be trusted with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Solver {
    /// The matrix `(BᵀB)⁻¹Bᵀ`, computed once: a fit is one product. The fastest.
    Pinv,
    /// The Cholesky factor of `BᵀB`, computed once: a fit is a product and two triangular solves. Its
    /// error goes with the square of the condition number.
    Cholesky,
    /// `Q` and `R` of the Householder QR of `B`, computed once: a fit is a product and one triangular solve.
    Qr,
}

impl Solver {
    /// All of them, with their names.
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

/// The normalized arc length ρ that each point is fitted at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Rho {
    /// In even steps, as lariat's extraction spaces its points: all of the algebra is done beforehand.
    Even,
    /// Measured along the given points, chord by chord, for points that are not evenly spaced: the algebra is
    /// done again for each fit.
    Measured,
}

impl Rho {
    /// Both, with their names.
    pub const ALL: [(&str, Self); 2] = [("even", Self::Even), ("measured", Self::Measured)];
}

/// How much each point counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Weights {
    /// As much as any other: all of the algebra is done beforehand.
    Even,
    /// As [`Fitter::fit_weighted`](crate::Fitter::fit_weighted) is told: a hidden point weighs nothing.
    Given,
    /// As told, and less where it lies far off the curve (Huber 1964), reweighted at most 5 times: a few points that
    /// are far off hardly move the curve.
    Robust,
}

/// The settings of a [`Fitter`](crate::Fitter). Each field has a method of its name that sets it:
/// `Options::bezier(5).points(80)`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Options {
    /// The family of curves and its size. Default: a Bezier curve of order 8, the best of the paper's four.
    pub basis: Basis,
    /// Chooses the number of control points: the fewest, at most those of `basis`, that keep the curve within a
    /// [`Tolerance`](crate::Tolerance) of its points. [`Fitter::fit_within`](crate::Fitter::fit_within) chooses for each fit,
    /// and [`Fitter::fit`](crate::Fitter::fit) does so with the default tolerance;
    /// [`SteadySize`](crate::SteadySize) keeps a moving rope's. Default: no.
    pub choose_size: bool,
    /// How many points `N` a centerline has, from 2 to [`MAX_POINTS`] and no fewer than control points.
    /// Default: 120, as in the paper.
    pub points: usize,
    /// Default: [`Solver::Pinv`].
    pub solver: Solver,
    /// `λ ≥ 0`: what is minimized is `Σ |cᵢ − f(ρᵢ)|² + λ Σ |sⱼ₋₁ − 2sⱼ + sⱼ₊₁|²`. The second differences of
    /// the control points tame high orders; unlike their plain squares they are 0 for every evenly drawn
    /// straight line, so that a moved rope still has a moved descriptor. For a Fourier series they are the
    /// coefficients times the square of their harmonic. Default: 0.
    pub ridge: f64,
    /// Whether the curve begins and ends exactly at the first and the last point. Default: no.
    pub pin_ends: bool,
    /// Default: [`Rho::Even`].
    pub rho: Rho,
    /// Default: [`Weights::Even`].
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
    /// A Bezier curve of this order, everything else at its default.
    pub fn bezier(order: usize) -> Self {
        Self::default().basis(Basis::Bezier { order })
    }

    /// A uniform cubic B-spline of this many control points, everything else at its default.
    pub fn bspline(control_points: usize) -> Self {
        Self::default().basis(Basis::BSpline {
            degree: CUBIC,
            control_points,
            knots: Knots::Uniform,
        })
    }

    /// The Fourier series of a closed curve with this many harmonics, everything else at its default.
    pub fn fourier(harmonics: usize) -> Self {
        Self::default().basis(Basis::Fourier { harmonics })
    }

    /// The fewest control points that keep the curve within a tolerance of its `points` points, up to as many as there
    /// may be: of a cubic Bezier curve or a uniform cubic B-spline, or, of a closed curve, of a Fourier series. Of these
    /// the noise gain hardly grows with their number.
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
