//! From the points of a centerline to a curve: regression on Bernstein polynomials and other families.
//!
//! The method is that of F. Chen, *Bezier-based Regression Feature Descriptor for Deformable Linear
//! Objects* (arXiv 2312.16502). A centerline of `N` points `c̄`, the `i`-th at the normalized arc
//! length `ρᵢ ∈ [0, 1]` (its equations 1 and 2), is taken for a Bezier curve
//! `f(ρ) = Σⱼ pⱼ Bⱼₙ(ρ)` of order `n` (equations 3 and 4). Least squares (equations 5 to 7) gives the
//! `n + 1` control points, which are the descriptor:
//!
//! ```text
//! s = (BᵀB)⁻¹ Bᵀ c̄,    B is N × (n + 1),  Bᵢⱼ = Bⱼₙ(ρᵢ)
//! ```
//!
//! The paper writes `B ⊗ I₂`; here `x` and `y` are two right-hand sides of the same `B`, and a third dimension
//! would be one more. The grid of `ρ`, the basis and so all of the algebra are fixed when a [`Fitter`] is made. A fit
//! after that is one small product and allocates nothing.
//!
//! ```
//! use lariat_fit::{Fitter, Options, point_at};
//!
//! let mut fitter = Fitter::new(Options { points: 50, ..Options::bezier(3) })?;
//! let points: Vec<[f64; 2]> = (0..50)
//!     .map(|i| point_at(&[[0.0, 0.0], [10.0, 40.0], [60.0, -20.0], [90.0, 30.0]], i as f64 / 49.0))
//!     .collect();
//! let fit = fitter.fit(&points)?;
//! assert!((fit.control_points[1][1] - 40.0).abs() < 1e-9);
//! assert!(fit.max_px < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | for | see |
//! |---|---|
//! | the families of curves | [`Basis`]: Bezier, B-spline, rational Bezier, Fourier, feature points, center of mass |
//! | ridge, pinned ends, measured arc length, weights, the robust option, the least size within a tolerance | [`Options`], [`Tolerance`], [`SteadySize`] |
//! | the curve itself: points, tangents, curvature, length, what is nearest, `∂f/∂s` | [`Curve`] |
//! | `∂s/∂c̄`, the covariance of `s` | [`Fitter::matrix`], [`Fit::covariance_factor`] |
//! | points at equal steps again, after a map; what pixel noise does to the control points then | [`Resampler`], [`Fitter::propagate`] |
//! | the control points in time, with their velocities | [`Filter`] |
//! | other forms of a curve | [`elevate_degree`], [`reduce_degree`], [`bezier_pieces`], [`to_monomial`], … |
//!
//! # When the descriptor is stable
//!
//! The paper asks for `N ≫ n + 1`, so that `BᵀB` has an inverse. What is needed exactly, and checked:
//!
//! 1. at least as many points as control points, `N ≥ n + 1`;
//! 2. as many *different* values of ρ among them (and, for a B-spline, one for each function where it is not 0:
//!    Schoenberg and Whitney 1953). Even steps have them; where arc length is measured, repeated points are refused;
//! 3. a condition number of `B` below the solver's limit, 4.5·10⁹ for `pinv` and `qr` and 6.7·10⁴ for `cholesky`, so that
//!    rounding moves the control points by less than a millionth of their size.
//!
//! The first two make the descriptor exist and be unique, the third makes it come out. How much the *noise* of the points
//! moves it is another number, the noise gain: the largest standard deviation of a control point for noise of 1 in the
//! points. For 120 points (`cargo run --release -p lariat-fit --example conditions`):
//!
//! | control points | Bezier: condition, noise gain | cubic B-spline | Fourier |
//! |---:|---|---|---|
//! | 5 | 11, 1.6 | 5.4, 0.75 | 1.4, 0.13 |
//! | 9 | 147, 25 | 5.1, 0.74 | 1.4, 0.13 |
//! | 13 | 2.1·10³, 390 | 4.9, 0.94 | 1.4, 0.13 |
//! | 17 | 3.2·10⁴, 6.3·10³ | 4.8, 1.1 | 1.4, 0.13 |
//! | 25 | 7.7·10⁶, 1.7·10⁶ | 4.7, 1.3 | 1.4, 0.13 |
//!
//! So a Bezier curve of high order is drawn rightly, but its control points are not a feature to servo on; a B-spline's
//! are, whatever their number.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod adaptive;
mod arc_length;
mod basis;
mod bezier;
mod checked;
mod choice;
mod condition;
mod convert;
mod curve;
mod error;
mod factor;
mod filter;
mod fitter;
mod folded;
mod functions;
mod kernel;
mod linear;
mod matrix;
mod noise;
mod options;
mod placed;
mod rational;
mod resample;
mod robust;
mod solve;
mod system;
mod tolerance;
mod weighted;

pub use arc_length::ArcLengthError;
pub use basis::{Basis, Knots, MAX_CONTROL_POINTS};
pub use bezier::{bernstein, point_at};
pub use choice::{Judged, Line, SteadySize};
pub use convert::{
    BezierPiece, OwnedCurve, Reduced, bezier_pieces, elevate_degree, from_monomial, insert_knot,
    reduce_degree, reverse, split_at, to_monomial,
};
pub use curve::{Curve, CurveError, Distance, Nearest};
pub use error::{FitError, FitterError};
pub use filter::{
    CurveSpace, CurveSpaceError, Filter, FilterError, FilterOptions, FilterStep, Noise,
    PredictError, Prediction, UpdateError,
};
pub use fitter::{Fit, Fitter, MAX_COORDINATE_PX};
pub use functions::MAX_KNOTS;
pub use options::{MAX_ORDER, MAX_POINTS, Options, Rho, Solver, Weights};
pub use rational::{MAX_WEIGHT, RationalFit, RationalFitter};
pub use resample::{ResampleError, Resampler};
pub use tolerance::Tolerance;
pub use weighted::{MAX_NOISE_GAIN, WeightedError};
