//! Families of curves. Each family defines the basis functions that control points weight.

use std::fmt;

/// Maximum number of control points of a curve.
pub const MAX_CONTROL_POINTS: usize = 32;

/// Placement of a B-spline's knots. All are clamped: repeated knots at both ends make the curve
/// begin and end at its outer control points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Knots {
    /// Even steps.
    Uniform,
    /// Denser where a rope bends, as determined from its curve. A [`SteadySize`](crate::SteadySize)
    /// computes these knots for its rope. A fitter created with `Placed` begins with even knots.
    Placed,
    /// Averages of the points' ρ, with the same number of points between neighboring knots (Piegl
    /// and Tiller, *The NURBS Book*, equations 9.68 and 9.69).
    Averaged,
}

impl Knots {
    /// Placements that can be requested, with their names.
    pub const NAMED: [(&str, Self); 2] = [("uniform", Self::Uniform), ("averaged", Self::Averaged)];
}

/// Family of curves that a descriptor's control points belong to, and its size.
///
/// Senders of curves have to name their family, so receivers must handle every new one. The enum is
/// therefore exhaustive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Basis {
    /// Bernstein polynomials: a Bezier curve of `order`, 1 to 31, with `order + 1` control points,
    /// as in the paper.
    Bezier {
        /// Order `n` of the curve.
        order: usize,
    },
    /// A clamped B-spline, where each control point moves only a part of the curve.
    BSpline {
        /// Degree of its pieces, from 1 to one less than `control_points`.
        degree: usize,
        /// Number of control points, 2 to 32.
        control_points: usize,
        /// Placement of the knots, where pieces meet.
        knots: Knots,
    },
    /// A Bezier curve whose control points have weights, which are estimated as well.
    RationalBezier {
        /// Order of the curve.
        order: usize,
    },
    /// A truncated Fourier series, for closed curves: `a₀ + Σ aₖ cos 2πkρ + bₖ sin 2πkρ`. Its
    /// "control points" are the coefficients `a₀, a₁, b₁, a₂, b₂, …`.
    Fourier {
        /// Number of harmonics, 1 to 15.
        harmonics: usize,
    },
    /// Points of the centerline itself, at even steps of arc length from the first to the last,
    /// joined by straight lines: the local descriptor common in visual servoing.
    FeaturePoints {
        /// Number of points, 2 to 32.
        count: usize,
    },
    /// The mean of all points: a single "control point".
    CenterOfMass,
}

impl Basis {
    /// Number of control points of its curves.
    pub const fn control_points(self) -> usize {
        match self {
            Self::Bezier { order } | Self::RationalBezier { order } => order + 1,
            Self::BSpline { control_points, .. } => control_points,
            Self::Fourier { harmonics } => 2 * harmonics + 1,
            Self::FeaturePoints { count } => count,
            Self::CenterOfMass => 1,
        }
    }

    /// Degree of its polynomials, or the number of harmonics of a Fourier series.
    pub const fn order(self) -> usize {
        match self {
            Self::Bezier { order } | Self::RationalBezier { order } => order,
            Self::BSpline { degree, .. } => degree,
            Self::Fourier { harmonics } => harmonics,
            Self::FeaturePoints { .. } => 1,
            Self::CenterOfMass => 0,
        }
    }

    /// Returns whether its curves are closed: they end where they begin.
    pub const fn is_closed(self) -> bool {
        matches!(self, Self::Fourier { .. })
    }

    /// Returns whether its curves begin and end at their outer control points, so that these can be
    /// pinned.
    pub const fn has_ends(self) -> bool {
        matches!(
            self,
            Self::Bezier { .. } | Self::BSpline { .. } | Self::RationalBezier { .. }
        )
    }

    /// The next smaller curve of the same family, if there is one.
    pub(crate) fn smaller(self) -> Option<Self> {
        let less = |size: usize, low: usize| (size > low).then(|| size - 1);
        Some(match self {
            Self::Bezier { order } => Self::Bezier {
                order: less(order, 1)?,
            },
            Self::RationalBezier { order } => Self::RationalBezier {
                order: less(order, 1)?,
            },
            Self::BSpline {
                degree,
                control_points,
                knots,
            } => Self::BSpline {
                degree,
                control_points: less(control_points, degree + 1)?,
                knots,
            },
            Self::Fourier { harmonics } => Self::Fourier {
                harmonics: less(harmonics, 1)?,
            },
            Self::FeaturePoints { count } => Self::FeaturePoints {
                count: less(count, 2)?,
            },
            Self::CenterOfMass => return None,
        })
    }

    /// Replaces a spline of one piece by the equivalent Bezier curve.
    pub(crate) fn named(self) -> Self {
        match self {
            Self::BSpline {
                degree,
                control_points,
                knots: Knots::Uniform,
            } if control_points == degree + 1 => Self::Bezier { order: degree },
            other => other,
        }
    }

    /// Name of the family, as in settings and JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Bezier { .. } => "bezier",
            Self::BSpline { .. } => "bspline",
            Self::RationalBezier { .. } => "rational",
            Self::Fourier { .. } => "fourier",
            Self::FeaturePoints { .. } => "points",
            Self::CenterOfMass => "mass",
        }
    }

    /// The `i`-th of `points` values of ρ in even steps. They range from 0 to 1 or, for a closed
    /// curve, to one step before 1, because ρ = 1 is the same point as ρ = 0.
    pub const fn even_rho(self, i: usize, points: usize) -> f64 {
        if self.is_closed() {
            i as f64 / points as f64
        } else if points < 2 {
            0.0
        } else {
            i as f64 / (points - 1) as f64
        }
    }
}

impl fmt::Display for Basis {
    /// Writes a phrase such as "a Bezier curve of 9 control points".
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bezier { order } => {
                write!(
                    f,
                    "a Bezier curve of {} control points",
                    order.saturating_add(1)
                )
            }
            Self::BSpline {
                degree,
                control_points,
                ..
            } => write!(
                f,
                "a B-spline of degree {degree} with {control_points} control points"
            ),
            Self::RationalBezier { order } => {
                write!(
                    f,
                    "a rational Bezier curve of {} control points",
                    order.saturating_add(1)
                )
            }
            Self::Fourier { harmonics: 1 } => write!(f, "a Fourier series of 1 harmonic"),
            Self::Fourier { harmonics } => write!(f, "a Fourier series of {harmonics} harmonics"),
            Self::FeaturePoints { count } => write!(f, "{count} feature points"),
            Self::CenterOfMass => write!(f, "the center of mass"),
        }
    }
}
