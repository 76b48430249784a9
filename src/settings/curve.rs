//! `[fit]`: the curve.

use lariat_fit::{Basis, Knots, Options, Rho, Solver, Weights};
use std::fmt;

/// The family of an open rope's curve. A closed rope is always a Fourier series.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Family {
    Bezier,
    BSpline,
    Rational,
    /// For lines of points that are all closed; in the chain an open rope is then a Bezier curve.
    Fourier,
    Points,
    Mass,
}

impl Family {
    pub(super) const ALL: [(&'static str, Self); 6] = [
        ("bezier", Self::Bezier),
        ("bspline", Self::BSpline),
        ("rational", Self::Rational),
        ("fourier", Self::Fourier),
        ("points", Self::Points),
        ("mass", Self::Mass),
    ];
}

impl fmt::Display for Family {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = Self::ALL.iter().find(|(_, family)| family == self);
        f.write_str(name.map_or("", |(name, _)| name))
    }
}

/// How many control points, less one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Order {
    Named(usize),
    /// Chosen anew for every curve.
    Auto,
}

/// `[fit]`: the curve.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Fit {
    pub(crate) basis: Family,
    pub(crate) order: Order,
    /// The highest that `order = "auto"` chooses.
    pub(crate) max_order: usize,
    /// Of a B-spline's pieces.
    pub(crate) degree: usize,
    pub(crate) knots: Knots,
    pub(crate) solver: Solver,
    pub(crate) ridge: f64,
    pub(crate) pin_ends: bool,
    pub(crate) rho: Rho,
    pub(crate) robust: bool,
    pub(crate) filter: bool,
    /// How strongly the filter thinks a rope accelerates.
    pub(crate) acceleration_px_s2: f64,
}

impl Default for Fit {
    fn default() -> Self {
        Self {
            basis: Family::Bezier,
            order: Order::Named(8),
            max_order: 16,
            degree: 3,
            knots: Knots::Uniform,
            solver: Solver::Pinv,
            ridge: 0.0,
            pin_ends: false,
            rho: Rho::Even,
            robust: false,
            filter: false,
            acceleration_px_s2: 2000.0,
        }
    }
}

impl Fit {
    /// Why curves of these settings cannot be filtered in time, if they cannot.
    pub(super) fn unfilterable(&self) -> Option<&'static str> {
        match (self.filter, self.order, self.basis) {
            (true, Order::Auto, _) => Some(
                "a filter needs the same control points in every frame: name the order, or leave the filter out",
            ),
            (true, _, Family::Rational) => Some(
                "rational curves cannot be filtered, as their weights change from frame to frame: choose another \
                 basis, or leave the filter out",
            ),
            _ => None,
        }
    }

    /// The fitter's own options for centerlines of `points` points.
    pub(crate) fn options(&self, points: usize, closed: bool) -> Options {
        let order = match self.order {
            Order::Named(order) => order,
            Order::Auto => self.max_order,
        };
        let basis = match self.basis {
            // As many coefficients as an open curve of this order has control points, or one fewer.
            _ if closed => Basis::Fourier {
                harmonics: (order / 2).max(1),
            },
            Family::Bezier | Family::Fourier => Basis::Bezier { order },
            Family::BSpline => Basis::BSpline {
                degree: self.degree.min(order),
                control_points: order + 1,
                knots: self.knots,
            },
            Family::Rational => Basis::RationalBezier { order },
            Family::Points => Basis::FeaturePoints { count: order + 1 },
            Family::Mass => Basis::CenterOfMass,
        };
        Options {
            basis,
            choose_size: self.order == Order::Auto,
            points,
            solver: self.solver,
            ridge: self.ridge,
            // A closed curve has no ends.
            pin_ends: self.pin_ends && !closed,
            rho: self.rho,
            weights: if self.robust {
                Weights::Robust
            } else {
                Weights::Even
            },
        }
    }
}
