//! From the points of a centerline to a curve: regression on Bernstein polynomials.
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
//! The paper writes `B ⊗ I₂`; here `x` and `y` are two right-hand sides of the same `B`. The grid of
//! `ρ`, the order and so all of the algebra are fixed when a [`Fitter`] is made. A fit after that is one
//! small product and allocates nothing.
//!
//! ```
//! use lariat_fit::{Fitter, Options, point_at};
//!
//! let mut fitter = Fitter::new(Options { order: 3, points: 50, ..Options::default() })?;
//! let points: Vec<[f64; 2]> = (0..50)
//!     .map(|i| point_at(&[[0.0, 0.0], [10.0, 40.0], [60.0, -20.0], [90.0, 30.0]], i as f64 / 49.0))
//!     .collect();
//! let fit = fitter.fit(&points)?;
//! assert!((fit.control_points[1][1] - 40.0).abs() < 1e-9);
//! assert!(fit.max_px < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod bezier;
mod condition;
mod error;
mod fitter;
mod folded;
mod kernel;
mod options;
mod solve;

pub use bezier::{bernstein, point_at};
pub use error::{FitError, FitterError};
pub use fitter::{Fit, Fitter, MAX_COORDINATE_PX};
pub use options::{Basis, MAX_ORDER, MAX_POINTS, Options, Solver, UnknownSolver};
