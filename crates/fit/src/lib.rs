//! Fits curves to the points of a centerline, by regression on Bernstein polynomials and other
//! bases.
//!
//! The control points of the curve describe the rope's shape (F. Chen, *Bezier-based Regression
//! Feature Descriptor for Deformable Linear Objects*, [arXiv
//! 2312.16502](https://arxiv.org/abs/2312.16502)). A centerline is `N` points `c̄`, the `i`-th at
//! the normalized arc length `ρᵢ ∈ [0, 1]` (the paper's equations 1 and 2). Its model is a Bezier
//! curve `f(ρ) = Σⱼ pⱼ Bⱼₙ(ρ)` of order `n` (equations 3 and 4). Least squares (equations 5 to 8)
//! gives the `n + 1` control points `s`, the descriptor:
//!
//! ```text
//! s = (BᵀB)⁻¹ Bᵀ c̄,    B is N × (n + 1),  Bᵢⱼ = Bⱼₙ(ρᵢ)
//! ```
//!
//! The paper writes `B ⊗ I₂`. Here each coordinate, in the plane or in 3-D, is a right-hand side of
//! the same `B`. A [`Fitter`] is computed once. A fit is then one small product and does not
//! allocate.
//!
//! ```
//! use lariat_fit::{Fitter, Options, point_at};
//!
//! let mut fitter = Fitter::new(Options::bezier(3).points(50))?;
//! let points: Vec<[f64; 2]> = (0..50)
//!     .map(|i| point_at(&[[0.0, 0.0], [10.0, 40.0], [60.0, -20.0], [90.0, 30.0]], i as f64 / 49.0))
//!     .collect();
//! let fit = fitter.fit(&points)?;
//! assert!((fit.control_points[1][1] - 40.0).abs() < 1e-9);
//! assert!(fit.max_px < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! - [`Fitter`], [`Fit`], [`Options`]: a fit, with ridge, pinned ends, weights, outliers, measured
//!   arc length
//! - [`Basis`]: Bezier, B-spline, rational Bezier, Fourier, feature points, center of mass
//! - [`Curve`]: points, tangents, curvature, length, nearest points, and `∂f/∂s`
//! - [`Tolerance`], [`SteadySize`]: the fewest control points within a tolerance, kept over time
//! - [`Fitter::matrix`], [`Fit::covariance_factor`]: `∂s/∂c̄`, and the covariance of `s`
//! - [`Resampler`], [`Fitter::propagate`]: equal steps after a map, and the effect of pixel noise
//! - [`Fitter::spread`]: covariance from an error ellipsoid for each point, as in 3-D
//! - [`Filter`]: control points and their velocities over time
//! - [`elevate_degree`], [`reduce_degree`], [`bezier_pieces`], [`to_monomial`], …: other forms of a
//!   curve
//!
//! # When the descriptor is stable
//!
//! The paper asks for `N ≫ n + 1`, so that `BᵀB` has an inverse. The fitter checks the exact
//! conditions:
//!
//! 1. At least as many points as control points, `N ≥ n + 1`.
//! 2. As many *different* values of ρ among them. A B-spline also needs, for each basis function, a
//!    ρ where that function is not 0 (Schoenberg and Whitney 1953). Even steps satisfy this. With
//!    measured arc length, repeated points are refused.
//! 3. A condition number of `B` below the solver's limit, so that rounding moves the control points
//!    by less than a millionth.
//!
//! The first two guarantee that the descriptor exists and is unique, the third that it can be
//! computed. The effect of *noise* is measured by another number, the noise gain: the largest
//! standard deviation of a control point for noise of standard deviation 1 in the points. For 120
//! points (`cargo run --release -p lariat-fit --example conditions`):
//!
//! | control points | Bezier: condition, noise gain | cubic B-spline | Fourier |
//! |---:|---|---|---|
//! | 5 | 11, 1.6 | 5.4, 0.75 | 1.4, 0.13 |
//! | 9 | 147, 25 | 5.1, 0.74 | 1.4, 0.13 |
//! | 13 | 2.1·10³, 390 | 4.9, 0.94 | 1.4, 0.13 |
//! | 17 | 3.2·10⁴, 6.3·10³ | 4.8, 1.1 | 1.4, 0.13 |
//! | 25 | 7.7·10⁶, 1.7·10⁶ | 4.7, 1.3 | 1.4, 0.13 |
//!
//! A Bezier curve of high order is accurate, but its control points are too noisy for control.
//! Those of a B-spline are not, however many there are.
//!
//! # Solvers
//!
//! | solver | precomputed | a fit is | refused above cond(B) |
//! |---|---|---|---|
//! | `pinv` (default) | (BᵀB)⁻¹Bᵀ = R⁻¹Qᵀ | one product | 4.5·10⁹ |
//! | `cholesky` | L of BᵀB = LLᵀ | a product and two triangular solves | 6.7·10⁴ |
//! | `qr` | Q and R of B = QR | a product and one triangular solve | 4.5·10⁹ |
//!
//! A refusal names the condition number and the largest allowed curve. [faer](https://docs.rs/faer)
//! factorizes in the scalar type `scalar::Real`, one number at a time, so results have the same
//! bits on every machine. The fit uses its own product, because a general one is several times
//! slower at these sizes (9 × 120). The ridge is on second differences of the control points. A
//! ridge on the control points themselves would change the curve's shape when the rope moves.
//!
//! # Modules
//!
//! | module | content |
//! |---|---|
//! | `basis`, `functions`, `bezier` | families of curves, and their functions at one ρ: a row of B |
//! | `condition`, `checked` | B on the even grid, its condition number, and validation of requests |
//! | `scalar`, `matrix`, `factor` | QR, Cholesky, triangular inverses and singular values; products in a fixed order |
//! | `system`, `solve`, `linear` | ridge and pinned ends as a least-squares problem A s = c̄; its solvers; P with s = P c̄, the covariance C = PPᵀ, the degrees of freedom ‖I − BP‖² |
//! | `folded`, `kernel` | the fit: mirror symmetry decouples sums and differences of mirrored points, which halves the multiply-adds |
//! | `weighted`, `robust`, `arc_length`, `adaptive` | algebra that depends on the points. Normal equations in a = R s of B's own QR are nearly the identity, so Cholesky is accurate at any order |
//! | `tolerance`, `choice`, `placed` | choice of the size, and knots where the rope bends |
//! | `rational` | variable projection over the log-weights, with a trust region and a prior |
//! | `filter` | a constant-velocity Kalman filter; white acceleration acts on the curve |
//! | `curve`, `convert` | evaluation of curves as Bezier pieces, and conversions |
//!
//! # In the chain
//!
//! Open curves use the basis of the settings (`crates/chain/src/pipeline/fitting`). Closed ones are
//! Fourier series of n/2 harmonics at ρᵢ = i/N. The basis `auto` is a cubic B-spline of 4 to 32
//! control points (with 4, a Bezier curve), or a series of 1 to 15 harmonics. All sizes are
//! computed at the start, and each rope keeps its own, so a frame costs one fit. A size is chosen
//! at half of the tolerance. It changes only if the curve has not fitted for a second of exposure
//! time. A rope that a spline of 32 control points on even knots cannot follow gets its own knots,
//! which allocates. Quality is measured between visible points and the curve at their ρ. With
//! `robust`, hidden points have weight 0 unless the visible ones do not determine the curve. With
//! `filter`, each rope has its own filter while it is seen.
//!
//! # Known limitations
//!
//! - A curve has at most [`MAX_CONTROL_POINTS`] control points, and a centerline at most
//!   [`MAX_POINTS`] points.
//! - Points must be evenly spaced, except with the slower [`Rho::Measured`].
//! - Covariances assume independent noise in the points, except in [`Fitter::spread`]. Those of
//!   robust and rational fits are approximate.
//! - Conversions between forms of a curve allocate.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod adaptive;
mod arc_length;
mod basis;
mod bezier;
mod checked;
mod choice;
mod condition;
mod convert;
mod coordinate;
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
mod point;
mod rational;
mod resample;
mod robust;
mod scalar;
mod setters;
mod solve;
mod spread;
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
pub use coordinate::Coordinate;
pub use curve::{Curve, CurveError, Distance, Nearest};
pub use error::{FitError, FitterError};
pub use filter::{
    CurveSpace, CurveSpaceError, Filter, FilterError, FilterOptions, FilterStep, Noise,
    PredictError, Prediction, UpdateError,
};
pub use fitter::{Fit, Fitter, MAX_COORDINATE_PX};
pub use functions::MAX_KNOTS;
pub use noise::Square;
pub use options::{MAX_ORDER, MAX_POINTS, Options, Rho, Solver, Weights};
pub use point::Point;
pub use rational::{MAX_WEIGHT, RationalFit, RationalFitter};
pub use resample::{ResampleError, Resampler};
pub use spread::Spread;
pub use tolerance::Tolerance;
pub use weighted::{MAX_NOISE_GAIN, WeightedError};
// The matrix type of this interface.
pub use faer::{Mat, MatRef};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
