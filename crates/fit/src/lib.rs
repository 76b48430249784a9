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
//! | for | see |
//! |---|---|
//! | the families of curves | [`Basis`]: Bezier, B-spline, rational Bezier, Fourier, feature points, center of mass |
//! | ridge, pinned ends, measured arc length, weights, the robust option, the least size within a tolerance | [`Options`], [`Tolerance`], [`SteadySize`] |
//! | the curve itself: points, tangents, curvature, length, what is nearest, `∂f/∂s` | [`Curve`] |
//! | `∂s/∂c̄`, the covariance of `s` | [`Fitter::matrix`], [`Fit::covariance_factor`] |
//! | points at equal steps again, after a map; what pixel noise does to the control points then | [`Resampler`], [`Fitter::propagate`] |
//! | the same for points that are each sure in their own way, as in space | [`Fitter::spread`] |
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
//!
//! # How it works
//!
//! A centerline's N points at ρᵢ = i/(N − 1) are regressed on Bernstein polynomials of order n (F. Chen,
//! [arXiv 2312.16502](https://arxiv.org/abs/2312.16502), equations 5 to 8):
//!
//! ```text
//! s = (BᵀB)⁻¹ Bᵀ c̄,   B is N × (n + 1),  Bᵢⱼ = Bⱼₙ(ρᵢ)
//! ```
//!
//! and so is every other basis, but for rational curves: one `Fitter`, one `B`, x and y two right-hand sides (the dimension
//! is a parameter). When it is stable, and how much noise gains, is said in the head of `crates/fit/src/lib.rs`.
//!
//! | module | what |
//! |---|---|
//! | `basis`, `functions`, `bezier` | the families, and their functions at one ρ: a row of B |
//! | `condition`, `checked` | B on the even grid, its condition number, and which requests can be met |
//! | `scalar`, `matrix`, `factor` | QR, Cholesky, triangular inverses and singular values by [faer](https://docs.rs/faer), in a scalar type whose results are the same on every machine; products in a fixed order |
//! | `system`, `solve`, `linear` | ridge and pinned ends as a least-squares problem A s = c̄; its three solvers; P with s = P c̄, the covariance C = PPᵀ, the degrees of freedom ‖I − BP‖² |
//! | `folded`, `kernel` | the fit itself: a grid read backwards has its control points backwards, so sums and differences of mirrored points decouple: half the multiply-adds. Two products in the widest registers, the second for the residuals of all points |
//! | `weighted`, `robust`, `arc_length`, `adaptive` | where the algebra changes with the points: weights, Huber's option, measured ρ. Normal equations in the coordinates a = R s of B's own QR, where they are nearly the identity, so that Cholesky is exact enough at any order |
//! | `tolerance`, `choice`, `placed` | the fewest control points that keep a curve within a tolerance of its points, and that size kept while the rope moves; knots where it bends |
//! | `rational` | variable projection over the log-weights, a trust region from the last frame's weights or a linearized start, a prior that keeps at 1 what the data do not tell |
//! | `filter` | a constant-velocity Kalman filter on the control points; white acceleration acts on the curve, not on control points, so that no change of shape lags behind another |
//! | `curve`, `convert` | what control laws ask of a curve (every polynomial basis as Bezier pieces), and its other forms |
//!
//! | solver | kept | a fit is | refused above cond(B) |
//! |---|---|---|---|
//! | `pinv` (default) | (BᵀB)⁻¹Bᵀ = R⁻¹Qᵀ | one product | 4.5·10⁹ |
//! | `cholesky` | L of BᵀB = LLᵀ | a product and two triangular solves | 6.7·10⁴ |
//! | `qr` | Q and R of B = QR | a product and one triangular solve | 4.5·10⁹ |
//!
//! The limits are where rounding would reach a millionth of the control points; a request beyond them is refused with the
//! number and the largest curve of its family that is allowed. faer factorizes when a fitter is made. It would choose its
//! vectors by the processor, and the last digits with them; `scalar::Real` has it compute one number at a time, so a
//! recording replays to the last bit on any machine. The fit itself is the crate's own product of the precomputed matrix
//! with the points: at these sizes (9 × 120) a general product costs several times as much. NumPy's results are the
//! oracle of the tests. The ridge
//! is on second differences of the control points, not on the points themselves: a ridge toward the picture's corner would make
//! a moved rope another shape.
//!
//! In the chain (`crates/chain/src/pipeline/fitting`): open curves have the basis of the settings; closed ones are truncated Fourier series of
//! n/2 harmonics, at ρᵢ = i/N. The basis `auto` is a cubic B-spline of 4 to 32 control points (of 4 a Bezier curve), or a series of 1 to 15
//! harmonics. All sizes are computed when the stage starts, and each rope keeps its own (`fitting/steady`): a frame costs one fit. A
//! size is chosen at half of the tolerance, so that it lasts while the rope bends on, and given up after a second, by exposure
//! times, in which the curve did not fit; never for a smaller one while it does, and never while the rope is out of sight. Where 32 even
//! pieces do not do, the rope gets knots of its own, moved eight times to where the points are missed, and the algebra for them: the
//! one thing that is computed, and allocated, at a rope's start. Every curve, of whatever basis, is then held against its points
//! (`fit` in the descriptor): those that were seen, at their own ρ, which is never less than the distance to the nearest point of the
//! curve, and right for `point_at` too. With `robust` hidden points weigh nothing, unless what is seen does not determine the curve: then
//! the bridged points count like the others. With `filter` each rope has a filter of its own; what is lost is not filtered.

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
