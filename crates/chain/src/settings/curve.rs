//! `[fit]`: the curve.

use lariat_fit::{Basis, Knots, Options, Rho, Solver, Tolerance, Weights};
use lariat_wire::Basis as Sent;
use std::fmt;

/// Default number of control points of a named basis. It corresponds to order 8, the best of the
/// paper's four orders.
pub(super) const DEFAULT_CONTROL_POINTS: usize = 9;

/// The family of an open rope's curve. A closed rope is always a Fourier series.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Family {
    /// The curve with the fewest control points that stays on the rope: a cubic Bezier curve or a
    /// cubic B-spline.
    Auto,
    /// This basis. A Fourier series is for input in which all lines are closed; in the chain, an
    /// open rope becomes a Bezier curve.
    Named(Sent),
}

impl Family {
    pub(super) const ALL: [(&'static str, Self); 1 + Sent::ALL.len()] = {
        let mut all = [("auto", Self::Auto); 1 + Sent::ALL.len()];
        let mut i = 0;
        while i < Sent::ALL.len() {
            all[i + 1] = (Sent::ALL[i].name(), Self::Named(Sent::ALL[i]));
            i += 1;
        }
        all
    };
}

impl fmt::Display for Family {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Auto => "auto",
            Self::Named(basis) => basis.name(),
        })
    }
}

/// The number of control points of a curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ControlPoints {
    /// This many.
    Named(usize),
    /// As few as possible while the curve stays on the rope.
    Auto,
}

/// `[fit]`: the curve.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// The family of curves.
    pub basis: Family,
    /// The number of control points, if it was set. Otherwise the basis "auto" chooses it, and
    /// other bases have 9. With the basis "auto" a number selects a Bezier curve.
    pub control_points: Option<ControlPoints>,
    /// Maximum distance of the curve from the points, in widths of the rope.
    pub tolerance: f64,
    /// Upper limit of the tolerance, in pixels.
    pub tolerance_px: f64,
    /// Maximum number that `control_points = "auto"` chooses.
    pub max_control_points: usize,
    /// Degree of a B-spline's pieces.
    pub degree: usize,
    /// Placement of a B-spline's knots.
    pub knots: Knots,
    /// How the regression is solved.
    pub solver: Solver,
    /// Weight that keeps control points small.
    pub ridge: f64,
    /// True if the curve ends exactly at the rope's end points.
    pub pin_ends: bool,
    /// How each point's position along the curve is determined.
    pub rho: Rho,
    /// True if outliers have less weight.
    pub robust: bool,
    /// True if control points are filtered over time.
    pub filter: bool,
    /// Acceleration that the filter expects of a rope.
    pub acceleration_px_s2: f64,
}

impl Default for Fit {
    fn default() -> Self {
        Self {
            basis: Family::Auto,
            control_points: None,
            tolerance: Tolerance::WIDTHS,
            tolerance_px: Tolerance::LIMIT_PX,
            max_control_points: 17,
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
    /// Returns the reason if these curves cannot be filtered over time.
    pub(super) fn unfilterable(&self) -> Option<&'static str> {
        match (self.filter, self.basis) {
            (true, Family::Named(Sent::RationalBezier)) => Some(
                "rational curves cannot be filtered, as their weights change from frame to frame: choose another \
                 basis, or leave the filter out",
            ),
            _ => None,
        }
    }

    /// Returns the tolerance for a rope of this width. Width and tolerance have the same unit.
    pub fn tolerance(&self, width: f64, unit_per_px: f64) -> Tolerance {
        Tolerance::of_width(width, self.tolerance, self.tolerance_px * unit_per_px)
    }

    /// Returns the warning for a rope whose curve is this far from its points, in widths of the
    /// rope.
    pub fn coarse(&self, rms: f64, worst: f64, control_points: usize) -> String {
        let remedy = match self.family() {
            Family::Auto => "no curve here follows it better; steer by its centerline",
            _ => {
                "leave control points and basis to lariat (basis = \"auto\"), and it takes a curve that fits"
            }
        };
        format!(
            "the curve of {control_points} control points is up to {worst:.1} widths of the rope beside its points \
             (rms {rms:.2}): {remedy}"
        )
    }

    /// Returns the family of the curve. A number of control points without a basis selects the
    /// paper's Bezier curve.
    pub(super) fn family(&self) -> Family {
        match (self.basis, self.control_points) {
            (Family::Auto, Some(_)) => Family::Named(Sent::Bezier),
            (basis, _) => basis,
        }
    }

    /// Returns the fitter's options for centerlines of `points` points.
    pub fn options(&self, points: usize, closed: bool) -> Options {
        let control_points = match self.control_points {
            Some(ControlPoints::Named(count)) => count,
            Some(ControlPoints::Auto) => self.max_control_points,
            None => DEFAULT_CONTROL_POINTS,
        };
        // The degree of a Bezier curve.
        let order = control_points.saturating_sub(1);
        let auto = Options::auto(points, closed);
        let family = self.family();
        let basis = match family {
            Family::Auto => auto.basis,
            // The number of coefficients is that of an open curve's control points, or one less.
            _ if closed => Basis::Fourier {
                harmonics: (order / 2).max(1),
            },
            Family::Named(Sent::Bezier | Sent::Fourier) => Basis::Bezier { order },
            Family::Named(Sent::BSpline) => Basis::BSpline {
                degree: self.degree.min(order),
                control_points,
                knots: self.knots,
            },
            Family::Named(Sent::RationalBezier) => Basis::RationalBezier { order },
            Family::Named(Sent::FeaturePoints) => Basis::FeaturePoints {
                count: control_points,
            },
            Family::Named(Sent::CenterOfMass) => Basis::CenterOfMass,
        };
        Options::default()
            .basis(basis)
            .choose_size(match family {
                Family::Auto => auto.choose_size,
                _ => self.control_points == Some(ControlPoints::Auto),
            })
            .points(points)
            .solver(self.solver)
            .ridge(self.ridge)
            // A closed curve has no ends.
            .pin_ends(self.pin_ends && !closed)
            .rho(self.rho)
            .weights(if self.robust {
                Weights::Robust
            } else {
                Weights::Even
            })
    }
}
